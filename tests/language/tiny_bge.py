"""A tiny random BGE-M3: XLM-RoBERTa with a trained tokenizer, in the layout of the published folder."""

from __future__ import annotations

import json
from pathlib import Path

DIM = 32
SPECIAL = ("<s>", "<pad>", "</s>", "<unk>", "<mask>")
_MODULES = ("Transformer", ""), ("Pooling", "1_Pooling"), ("Normalize", "2_Normalize")


def build(folder: Path, texts: tuple[str, ...], *, seed: int = 0) -> Path:
    """Write the model into a new folder, with a vocabulary learned from ``texts``."""
    import torch
    from transformers import XLMRobertaConfig, XLMRobertaModel

    (folder / "1_Pooling").mkdir(parents=True)
    n = _tokenizer(folder, texts)
    torch.manual_seed(seed)
    config = XLMRobertaConfig(
        vocab_size=n, hidden_size=DIM, num_hidden_layers=2, num_attention_heads=4, intermediate_size=64,
        max_position_embeddings=130, type_vocab_size=1, pad_token_id=1, bos_token_id=0, eos_token_id=2,
    )  # fmt: skip
    torch.save(XLMRobertaModel(config).state_dict(), folder / "pytorch_model.bin")
    config.architectures = ["XLMRobertaModel"]
    (folder / "config.json").write_text(config.to_json_string())
    torch.save(torch.nn.Linear(DIM, 1).state_dict(), folder / "sparse_linear.pt")
    _layout(folder)
    return folder


def _layout(folder: Path) -> None:
    modules = [
        {"idx": i, "name": str(i), "path": path, "type": f"sentence_transformers.models.{name}"}
        for i, (name, path) in enumerate(_MODULES)
    ]
    modes = {"cls_token": True, "mean_tokens": False, "max_tokens": False, "mean_sqrt_len_tokens": False}
    pooling = {"word_embedding_dimension": DIM} | {f"pooling_mode_{name}": on for name, on in modes.items()}
    (folder / "modules.json").write_text(json.dumps(modules))
    (folder / "1_Pooling" / "config.json").write_text(json.dumps(pooling))
    (folder / "sentence_bert_config.json").write_text(json.dumps({"max_seq_length": 128, "do_lower_case": False}))


def _tokenizer(folder: Path, texts: tuple[str, ...]) -> int:
    from tokenizers import Tokenizer, models, pre_tokenizers, processors, trainers

    tokenizer = Tokenizer(models.Unigram())
    tokenizer.pre_tokenizer = pre_tokenizers.Metaspace()
    trainer = trainers.UnigramTrainer(
        vocab_size=400, special_tokens=list(SPECIAL), unk_token="<unk>", show_progress=False
    )
    tokenizer.train_from_iterator(texts, trainer)
    tokenizer.post_processor = processors.TemplateProcessing(
        single="<s> $A </s>", pair="<s> $A </s> </s> $B </s>", special_tokens=[("<s>", 0), ("</s>", 2)]
    )
    tokenizer.save(str(folder / "tokenizer.json"))
    names = ("bos", "pad", "eos", "unk", "mask")
    settings = {f"{name}_token": token for name, token in zip(names, SPECIAL, strict=True)}
    settings |= {"cls_token": "<s>", "sep_token": "</s>", "tokenizer_class": "XLMRobertaTokenizer"}
    (folder / "tokenizer_config.json").write_text(json.dumps(settings | {"model_max_length": 128}))
    return int(tokenizer.get_vocab_size())
