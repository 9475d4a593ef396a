"""The tuned encoder's evidence about sentences: the shipped table, and new text."""

import shutil

import numpy as np
import pytest

from ucon.core.errors import DataError
from ucon.habits import book
from ucon.habits.splits import entry_parts
from ucon.language.adapter import read_adapter
from ucon.language.encoder import MINILM_SHA256
from ucon.language.pairs import default_pair_reader
from ucon.readers.evidence import EvidenceReader
from ucon.readers.household import default_parts
from ucon.readers.reader_weights import default_weights
from ucon.readers.tuned_evidence import ADAPTER, TunedEvidence, book_table


@pytest.fixture(scope="module")
def evidence():
    return TunedEvidence(default_weights(), default_pair_reader(), book_table())


def test_the_table_holds_what_the_encoder_says(evidence):
    texts = book().texts[5:20000:5000]
    table = evidence._logits(texts)
    encoded = evidence.logits_of(texts)
    assert all(book_table().row(text) >= 0 for text in texts)
    assert np.abs(table - encoded).max() < 0.05


def test_reads_new_sentences(evidence):
    said = evidence.read(["Leaves the remote on the coffee table every evening.", "Tea is never drunk after four."])
    assert default_weights().anchors[said.anchor[0].argmax()] == "coffee_table"
    assert said.place[0] > 0.9 > 0.5 > said.place[1]


def test_reads_held_out_categories_better_than_the_fitted_words(evidence):
    data, parts, pairs = book(), entry_parts(book()), default_pair_reader()
    rows = [
        row for row in range(0, len(data), 9) if parts[data.entry_of(row).id] == "val" and len(data.supports(row)) == 1
    ]
    texts, right = [data.texts[row] for row in rows], [data.supports(row)[0].anchor for row in rows]
    assert len(rows) > 80

    def accuracy(reader):
        best = reader.read(texts).anchor.argmax(1)
        return np.mean([reader.weights.anchors[k] == name for k, name in zip(best, right, strict=True)])

    assert accuracy(evidence) > accuracy(EvidenceReader(default_weights(), pairs)) + 0.02
    assert accuracy(evidence) > 0.8


def test_altered_adapters_are_refused(tmp_path):
    shutil.copytree(ADAPTER.parent, tmp_path / "places")
    path = tmp_path / "places" / ADAPTER.name
    path.write_bytes(path.read_bytes()[:-8])
    with pytest.raises(DataError, match="truncated or altered"):
        read_adapter(path, MINILM_SHA256)


def test_parts_are_known_by_their_hash():
    assert default_parts().sha256 != default_weights().sha256
    assert len(default_parts().sha256) == 64
