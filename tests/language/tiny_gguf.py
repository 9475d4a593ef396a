"""A wheel with a tiny random Llama in GGUF, as in a registry's package, and its description as a packaged model."""

from __future__ import annotations

import json
import zipfile
from dataclasses import replace
from pathlib import Path

import gguf
import numpy as np
import torch
import transformers

from tests.language.tiny_models import CHAT, save_causal
from ucon.core.files import sha256_file
from ucon.language.packaged import SMOLLM2, PackagedModel

MEMBER = "tiny_llm/Tiny.gguf"
#: Multiples of 32, the block size of the format.
_SIZES = {"hidden_size": 64, "intermediate_size": 96, "num_attention_heads": 4, "num_key_value_heads": 4}
_NAMES = {
    "self_attn.q_proj": "attn_q",
    "self_attn.k_proj": "attn_k",
    "self_attn.v_proj": "attn_v",
    "self_attn.o_proj": "attn_output",
    "mlp.gate_proj": "ffn_gate",
    "mlp.up_proj": "ffn_up",
    "mlp.down_proj": "ffn_down",
    "input_layernorm": "attn_norm",
    "post_attention_layernorm": "ffn_norm",
}


def original(folder: Path) -> Path:
    """The model in Hugging Face layout, with one end-of-turn token, since GGUF has room for only one."""
    return save_causal(folder, positions=512, tie_word_embeddings=True, eos_token_id=5, **_SIZES)


def write_gguf(source: Path, out: Path, template: str = CHAT) -> None:
    """Write a model's GGUF file as common tools do, with the rows of attention matrices in their order."""
    config = transformers.AutoConfig.from_pretrained(source)
    weights = transformers.AutoModelForCausalLM.from_pretrained(source, dtype=torch.float32).state_dict()
    writer = gguf.GGUFWriter(out, "llama")
    writer.add_context_length(config.max_position_embeddings)
    writer.add_embedding_length(config.hidden_size)
    writer.add_block_count(config.num_hidden_layers)
    writer.add_feed_forward_length(config.intermediate_size)
    writer.add_head_count(config.num_attention_heads)
    writer.add_head_count_kv(config.num_key_value_heads)
    writer.add_layer_norm_rms_eps(config.rms_norm_eps)
    writer.add_rope_dimension_count(config.hidden_size // config.num_attention_heads)
    writer.add_vocab_size(config.vocab_size)
    _write_tokenizer(writer, source, template)
    for name, value in weights.items():
        if renamed := _renamed(name):
            writer.add_tensor(renamed, _rows(name, value.numpy(), config.num_attention_heads))
    writer.write_header_to_file()
    writer.write_kv_data_to_file()
    writer.write_tensors_to_file()
    writer.close()


def _write_tokenizer(writer: gguf.GGUFWriter, source: Path, template: str) -> None:
    told = json.loads((source / "tokenizer.json").read_text())
    tokens = sorted(told["model"]["vocab"], key=told["model"]["vocab"].get)
    special = {one["content"] for one in told["added_tokens"]}
    writer.add_tokenizer_model("gpt2")
    writer.add_token_list(tokens)
    kinds = [gguf.TokenType.CONTROL if token in special else gguf.TokenType.NORMAL for token in tokens]
    writer.add_token_types(kinds)
    writer.add_token_merges([merge if isinstance(merge, str) else " ".join(merge) for merge in told["model"]["merges"]])
    for add, token in ((writer.add_bos_token_id, "<s>"), (writer.add_eos_token_id, "<|end|>")):
        add(tokens.index(token))
    writer.add_unk_token_id(tokens.index("<unk>"))
    writer.add_pad_token_id(tokens.index("<pad>"))
    if template:
        writer.add_chat_template(template)


def _renamed(name: str) -> str:
    plain = name.removeprefix("model.").removesuffix(".weight")
    if plain in ("embed_tokens", "norm"):
        return {"embed_tokens": "token_embd.weight", "norm": "output_norm.weight"}[plain]
    if plain == "lm_head":  # tied to the embedding
        return ""
    _, number, part = plain.split(".", 2)
    return f"blk.{number}.{_NAMES[part]}.weight"


def _rows(name: str, value: np.ndarray, heads: int) -> np.ndarray:
    """Interleave the rows of query and key matrices: pairs from the two halves of each head."""
    if not name.endswith(("q_proj.weight", "k_proj.weight")):
        return value
    halves = value.reshape(heads, 2, -1, value.shape[1])
    return np.ascontiguousarray(halves.swapaxes(1, 2).reshape(value.shape))


def pack_wheel(member: Path, out: Path) -> Path:
    """A wheel with one file."""
    with zipfile.ZipFile(out, "w") as archive:
        archive.write(member, MEMBER)
    return out


def described(wheel: Path, member: Path, **changed: object) -> PackagedModel:
    """The packaged model that describes a wheel: its hash, and that of the file in it."""
    return replace(
        SMOLLM2,
        name="tiny",
        title="Tiny",
        requirement="tiny-llm==1",
        wheel_sha256=sha256_file(wheel),
        member=MEMBER,
        gguf_sha256=sha256_file(member),
        window=512,
        needed_bytes=1 << 20,
        **changed,  # type: ignore[arg-type]
    )
