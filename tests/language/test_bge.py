"""BGE-M3's loading, dense vectors, lexical weights and errors, on a tiny random network of its architecture."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent))
import tiny_bge  # (the path above)

from ucon.core.errors import ConfigError, DataError
from ucon.habits import KnowledgeBase, book
from ucon.language.bge import BgeM3, bge_folder
from ucon.language.phrases import query_text
from ucon.language.sparse import SparseRows
from ucon.readers.sampled_homes import sampled_kb
from ucon.retrieval import BgeRetriever, base

TEXTS = tuple(book().texts[::400])


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tiny_bge.build(tmp_path_factory.mktemp("bge") / "model", TEXTS)


@pytest.fixture(scope="module")
def encoder(folder: Path) -> BgeM3:
    return BgeM3(str(folder))


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("UCON_CACHE", str(tmp_path / "cache"))


@pytest.fixture
def copy(folder: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(folder, tmp_path / "copy"))


@pytest.fixture(scope="module")
def small() -> KnowledgeBase:
    """A knowledge base of three categories, in a dataset of only these."""
    from ucon.habits.types import HabitDataset

    kb = sampled_kb(book(), "test", 5, "task", k=3)
    entries = tuple(entry for entries in kb.entries.values() for entry in entries)
    dataset = HabitDataset("small", entries)
    return KnowledgeBase.build(dataset, {entry.category: [entry] for entry in entries}, 0)


def by_hand(folder: Path, text: str) -> tuple[np.ndarray, dict[int, float]]:
    """Dense vector and lexical weights, straight from the published definition."""
    import torch
    from tokenizers import Tokenizer
    from transformers import XLMRobertaConfig, XLMRobertaModel

    model = XLMRobertaModel(XLMRobertaConfig.from_pretrained(folder, attn_implementation="eager")).eval()
    model.load_state_dict(torch.load(folder / "pytorch_model.bin", weights_only=True))
    head = torch.load(folder / "sparse_linear.pt", weights_only=True)
    ids = Tokenizer.from_file(str(folder / "tokenizer.json")).encode(text).ids
    with torch.no_grad():
        hidden = model(torch.tensor([ids])).last_hidden_state[0]
    weights: dict[int, float] = {}
    for token, state in zip(ids, hidden, strict=True):
        reached = float(torch.relu(state @ head["weight"][0] + head["bias"][0]))
        if token >= len(tiny_bge.SPECIAL) and reached > 0:
            weights[token] = max(weights.get(token, 0.0), reached)
    return (hidden[0] / hidden[0].norm()).numpy(), weights


def test_importing_costs_nothing() -> None:
    code = (
        "import sys, ucon.retrieval, ucon.language.bge as b; b.BgeM3('x'); ucon.retrieval.BgeRetriever('x');"
        "assert not {'torch', 'transformers', 'sentence_transformers', 'huggingface_hub'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_vectors_and_weights_are_those_of_the_definition(folder: Path, encoder: BgeM3) -> None:
    texts = [*TEXTS[:5], "to be or not to be, to be", "", "日本"]
    dense, sparse = encoder.encode_both(texts)
    assert dense.shape == (len(texts), encoder.dim) == (8, tiny_bge.DIM)
    found_any = False
    for i, text in enumerate(texts):
        vector, weights = by_hand(folder, text)
        assert np.abs(dense[i] - vector).max() < 1e-3
        ids, values = sparse.row(i)
        assert ids.tolist() == sorted(weights)
        assert np.allclose(values, [weights[k] for k in sorted(weights)], rtol=2e-3, atol=1e-6)
        found_any |= len(ids) > 0
    assert found_any


def test_vectors_do_not_depend_on_the_company_or_the_call(encoder: BgeM3) -> None:
    texts = list(TEXTS[:6])
    together, sparse = encoder.encode_both(texts)
    alone = np.concatenate([encoder.encode([text]) for text in texts])
    assert alone.tobytes() == together.tobytes() == encoder.encode(texts).tobytes()
    assert np.array_equal(together, together.astype(np.float16).astype(np.float32))
    for i, text in enumerate(texts):
        again = encoder.encode_both([text])[1].row(0)
        assert all(a.tobytes() == b.tobytes() for a, b in zip(sparse.row(i), again, strict=True))


def test_safetensors_give_the_same(copy: Path, encoder: BgeM3) -> None:
    import torch
    from safetensors.torch import save_file

    published = copy / "pytorch_model.bin"
    save_file(torch.load(published, weights_only=True), copy / "model.safetensors", metadata={"format": "pt"})
    published.unlink()
    other = BgeM3(str(copy))
    assert other.encode(TEXTS[:3]).tobytes() == encoder.encode(TEXTS[:3]).tobytes()


def test_names_tell_weights_and_settings_apart(copy: Path, encoder: BgeM3, tmp_path: Path) -> None:
    assert BgeM3(str(copy)).name == encoder.name
    assert BgeM3(str(copy)).sparse_name == encoder.sparse_name
    assert BgeM3(str(copy), device="cuda:0").name == f"{encoder.name}-cuda0"
    other = tiny_bge.build(tmp_path / "other", TEXTS, seed=1)
    assert BgeM3(str(other)).name != encoder.name
    shutil.copy(other / "sparse_linear.pt", copy)
    assert BgeM3(str(copy)).name == encoder.name
    assert BgeM3(str(copy)).sparse_name != encoder.sparse_name
    (copy / "sentence_bert_config.json").write_text('{"max_seq_length": 8}')
    assert BgeM3(str(copy)).name != encoder.name


def test_match_is_the_sum_over_shared_tokens() -> None:
    def row(**weights: float) -> tuple[np.ndarray, np.ndarray]:
        ids = np.array([int(k[1:]) for k in weights], np.int32)
        return ids, np.array(list(weights.values()), np.float16)

    rows = SparseRows.stack([row(t3=1.0, t7=0.5), row(), row(t7=2.0, t9=1.0), row(t1=1.0)])
    assert rows.dot(*row(t7=0.5, t9=0.25)).tolist() == [0.25, 0.0, 1.25, 0.0]
    assert rows.dot(*row()).tolist() == [0.0] * 4
    assert SparseRows.stack([]).dot(*row(t1=1.0)).tolist() == []


def test_ranking_mixes_both(folder: Path, encoder: BgeM3, small: KnowledgeBase, tmp_path: Path) -> None:
    target = next(iter(small.entries))
    query = query_text(target)
    (vector, *vectors), sparse = encoder.encode_both([query, *small.texts])
    cosine = np.asarray(vectors, np.float64) @ vector.astype(np.float64)
    lexical = sparse.dot(*sparse.row(0))[1:]
    for dense_weight, sparse_weight in ((1.0, 0.0), (0.0, 1.0), (1.0, 0.3)):
        retriever = BgeRetriever(str(folder), dense_weight, sparse_weight, cache=tmp_path)
        expected = dense_weight * cosine + sparse_weight * lexical
        assert np.allclose(retriever.scores(target, small), expected, atol=1e-6)
        assert retriever.rank(target, small).tolist() == base.ranked(expected, small.rows).tolist()


def test_a_dataset_is_encoded_once(
    folder: Path, small: KnowledgeBase, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    dataset, said = small.dataset, []
    retriever = BgeRetriever(str(folder), 1.0, 0.3, cache=tmp_path)
    retriever.prepare(dataset, lambda done, total: said.append((done, total)))
    n = len(dataset.texts) + len(dataset.categories)
    assert said == [(i + 1, n) for i in range(n)]
    first = {target: retriever.rank(target, small).tolist() for target in small.entries}
    part = next((tmp_path / "sparse").rglob("*.npz"))
    assert part.stat().st_size < 200 * n + 1000

    def refuse(self: BgeM3) -> None:
        raise AssertionError("the model is loaded")

    monkeypatch.setattr(BgeM3, "_model", property(refuse))
    again = BgeRetriever(str(folder), 1.0, 0.3, cache=tmp_path)
    again.prepare(dataset)
    assert {target: again.rank(target, small).tolist() for target in small.entries} == first
    monkeypatch.undo()
    part.write_bytes(part.read_bytes()[:-20])
    healed = BgeRetriever(str(folder), 1.0, 0.3, cache=tmp_path)
    assert {target: healed.rank(target, small).tolist() for target in small.entries} == first


def test_without_the_model_one_line_says_how_to_get_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("huggingface_hub.constants.HF_HUB_CACHE", str(tmp_path))
    for path in ("BAAI/bge-m3", str(tmp_path / "nowhere")):
        with pytest.raises(DataError, match=r"nothing is downloaded.*hf download.*retriever\.path=FOLDER"):
            bge_folder(path)
    with pytest.raises(
        DataError,
        match=r"no config\.json, .*no model\.safetensors or pytorch_model\.bin",
    ):
        bge_folder(str(tmp_path))


def _set(file: Path, **values: object) -> None:
    file.write_text(json.dumps(json.loads(file.read_text()) | values))


def _without_a_tensor(folder: Path) -> None:
    import torch

    state = torch.load(folder / "pytorch_model.bin", weights_only=True)
    del state["encoder.layer.1.output.dense.weight"]
    torch.save(state, folder / "pytorch_model.bin")


def _mean(folder: Path) -> None:
    _set(folder / "1_Pooling" / "config.json", pooling_mode_cls_token=False, pooling_mode_mean_tokens=True)


def _head(folder: Path, *shape: int) -> None:
    import torch

    torch.save({"weight": torch.zeros(shape), "bias": torch.zeros(1)}, folder / "sparse_linear.pt")


def _cut(file: Path) -> None:
    file.write_bytes(file.read_bytes()[:-100])


DAMAGE: dict[str, tuple[Callable[[Path], object], str]] = {
    "config": (lambda f: (f / "config.json").write_text("{"), r"config\.json:1:2: not JSON"),
    "another kind": (lambda f: _set(f / "config.json", model_type="bert"), "model type 'bert', expected 'xlm-roberta'"),
    "cut weights": (lambda f: _cut(f / "pytorch_model.bin"), r"cannot be loaded|weights lack"),
    "wrong shape": (lambda f: _set(f / "config.json", intermediate_size=128), "cannot be loaded"),
    "a tensor less": (_without_a_tensor, r"the weights lack 1 tensors \(encoder.layer.1.output.dense.weight"),
    "other pooling": (_mean, "does not pool"),
    "no tokenizer": (lambda f: (f / "tokenizer.json").unlink(), r"no tokenizer\.json"),
    "cut tokenizer": (lambda f: _cut(f / "tokenizer.json"), "cannot be loaded"),
    "no head": (lambda f: (f / "sparse_linear.pt").unlink(), r"no such file.*retriever\.sparse_weight=0"),
    "head's shape": (lambda f: _head(f, 1, 7), r"weight \(1, 7\) and bias \(1,\), expected \(1, 32\)"),
    "no linear layer": (lambda f: _cut(f / "sparse_linear.pt"), "not the weight and bias of a linear layer"),
}


@pytest.mark.parametrize("name", DAMAGE)
def test_damage_ends_in_one_line(name: str, copy: Path) -> None:
    damage, message = DAMAGE[name]
    damage(copy)
    with pytest.raises(DataError, match=message) as caught:
        BgeM3(str(copy)).encode_both(["a habit"])
    assert "\n" not in str(caught.value)


def test_a_head_is_needed_only_for_lexical_weights(copy: Path, encoder: BgeM3) -> None:
    (copy / "sparse_linear.pt").unlink()
    assert BgeM3(str(copy)).encode(TEXTS[:1]).tobytes() == encoder.encode(TEXTS[:1]).tobytes()


@pytest.mark.parametrize("weights", [(-1.0, 1.0), (0.0, 0.0)])
def test_weights_are_checked(weights: tuple[float, float]) -> None:
    with pytest.raises(ConfigError, match="one above 0"):
        BgeRetriever("x", *weights)


def test_a_folders_own_modules_are_not_run(copy: Path, tmp_path: Path) -> None:
    left = tmp_path / "canary"
    (copy / "mine.py").write_text(f"open({str(left)!r}, 'w')\nclass Own: ...\n")
    modules = json.loads((copy / "modules.json").read_text())
    (copy / "modules.json").write_text(json.dumps([*modules, {"idx": 9, "name": "9", "path": "", "type": "mine.Own"}]))
    with pytest.raises(DataError, match=r"module of type mine\.Own, which is code from the folder"):
        BgeM3(str(copy)).encode(["habit"])
    (copy / "modules.json").write_text("[1]")
    with pytest.raises(DataError, match="not a list of modules"):
        BgeM3(str(copy)).encode(["habit"])
    assert not left.exists()
