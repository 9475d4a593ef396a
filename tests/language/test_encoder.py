"""The embedded encoder: offline, one text at a time, fp16; the shipped table matches it; the cache repairs itself."""

import os
import shutil
import subprocess
import sys

import numpy as np
import pytest

from tests.timing import fastest_s
from ucon.core.errors import DataError
from ucon.fitting.text_tables import QUERY, table_texts, vocabulary
from ucon.habits import book
from ucon.language import MiniLM, StoredEncoder, phrases
from ucon.language.encoder import minilm_folder
from ucon.language.store import DATA, VectorTable, default_encoder, shipped_table


class Counting:
    """A tiny encoder that counts the texts it encodes."""

    name, dim = "counting", 4

    def __init__(self):
        self.count = 0

    def encode(self, texts):
        self.count += len(texts)
        return np.asarray([[len(t), 1, 2, 3] for t in texts], np.float32)


def test_import_is_cheap():
    heavy = "{'torch', 'transformers', 'bm25s'}"
    code = f"import sys, ucon.language, ucon.retrieval, ucon.habits; assert not {heavy} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.timed
def test_table_holds_the_default_texts_in_order_and_loads_fast():
    def load():
        shipped_table.cache_clear()
        shipped_table()

    assert fastest_s(load) < 0.1
    table = shipped_table()
    texts = table_texts()
    assert len(table) == len(texts)
    assert [table.row(t) for t in texts[: len(book())]] == list(range(len(book())))
    assert min(table.row(t) for t in texts) >= 0
    assert (DATA / "embeddings.npy").stat().st_size < 20e6, "the vectors alone; the keys come on top"
    assert QUERY == phrases.QUERY
    norms = np.linalg.norm(table.vectors[::97].astype(np.float32), axis=1)
    assert np.allclose(norms, 1, atol=2e-3)


def test_default_texts_need_no_torch():
    code = (
        "import sys; from ucon.habits import *; from ucon.retrieval import *;"
        "from ucon.readers import AnchorReader; d = book(); h = household('Rs_int', d);"
        "kb = KnowledgeBase.build(d, {c: h[c] for c in d.categories[::25]}, 0); t = d.categories[0];"
        "r = AnchorReader(); r.belief(t, kb.texts[:20], r.known);"
        "rows = habits_at_level('retrieval', kb, t, DenseRetriever()); assert len(rows) == 20;"
        "assert 'torch' not in sys.modules and 'transformers' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_vectors_do_not_depend_on_the_company():
    texts = [*book().texts[:3], "coffee table", *book().texts[-2:]]
    encoder = MiniLM()
    alone = np.concatenate([encoder.encode([t]) for t in texts])
    together = encoder.encode(texts)
    assert alone.tobytes() == together.tobytes()
    assert np.array_equal(together, together.astype(np.float16).astype(np.float32))
    assert np.abs(together - default_encoder().encode(texts)).max() < 2e-3


def test_no_network(tmp_path):
    code = (
        "import socket\n"
        "def refuse(*a, **k): raise AssertionError('network')\n"
        "socket.socket.connect = socket.getaddrinfo = refuse\n"
        "from ucon.language import MiniLM; v = MiniLM().encode(['a text never seen']); assert v.shape == (1, 384)"
    )
    environment = {k: v for k, v in os.environ.items() if not k.startswith(("HF_", "TRANSFORMERS"))}
    subprocess.run([sys.executable, "-c", code], check=True, env=environment | {"HF_HOME": str(tmp_path)})
    assert not list(tmp_path.rglob("*.safetensors"))


def test_altered_weights_are_refused(tmp_path):
    folder = tmp_path / "model"
    folder.mkdir()
    (folder / "model.safetensors").write_bytes((minilm_folder() / "model.safetensors").read_bytes()[:1000])
    with pytest.raises(DataError, match=r"model\.safetensors: SHA-256 .* reinstall"):
        MiniLM(folder).encode(["x"])


@pytest.mark.parametrize("name", ["embeddings.npy", "embeddings.keys"])
def test_altered_table_is_refused(tmp_path, name):
    shutil.copytree(DATA, tmp_path / "data")
    file = tmp_path / "data" / name
    file.write_bytes(file.read_bytes()[:-5])
    with pytest.raises(DataError, match="truncated or altered"):
        VectorTable.load(tmp_path / "data" / "embeddings")


def test_cache_encodes_each_text_once_and_heals(tmp_path):
    first = Counting()
    a = StoredEncoder(first, folder=tmp_path).encode(["x", "yy", "x", "zzz"])
    assert first.count == 3
    assert a[:, 0].tolist() == [1, 2, 1, 3]
    second = Counting()
    b = StoredEncoder(second, folder=tmp_path).encode(["zzz", "x"])
    assert second.count == 0
    assert b[:, 0].tolist() == [3, 1]
    for path in (tmp_path / "counting").glob("*.npz"):
        path.write_bytes(path.read_bytes()[:-1])
    third = Counting()
    assert StoredEncoder(third, folder=tmp_path).encode(["x"])[0, 0] == 1
    assert third.count == 1


def test_many_small_texts_do_not_fill_the_folder(tmp_path):
    encoder = Counting()
    store = StoredEncoder(encoder, folder=tmp_path)
    for i in range(80):
        store.encode([f"text {i}"])
    assert len(list((tmp_path / "counting").glob("*.npz"))) <= 33
    again = Counting()
    StoredEncoder(again, folder=tmp_path).encode([f"text {i}" for i in range(80)])
    assert again.count == 0


def test_unwritable_cache_is_a_warning(tmp_path, capsys):
    (tmp_path / "counting").write_text("a file where the folder should be")
    store = StoredEncoder(Counting(), folder=tmp_path)
    assert store.encode(["x"])[0, 0] == 1
    assert store.encode(["x"])[0, 0] == 1
    assert "cannot be written" in capsys.readouterr().err


def test_word_table_is_in_step():
    with np.load(DATA / "words.npz", allow_pickle=False) as file:
        assert file["words"].tobytes().decode().split("\n") == vocabulary()
        assert file["codes"].shape == (len(vocabulary()), 384)
