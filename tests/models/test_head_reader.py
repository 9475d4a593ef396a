"""The head instead of the fitted reader: what it gives agents, and which files it refuses to load."""

import io
import json
import shutil
import time

import numpy as np
import pytest
import torch
from safetensors.torch import load, save

from models.agents.belief import ReadHabits
from models.nets.belief.head_reader import SHIPPED, HeadReader, load_head
from tests.learning.belief_tiny import plain_parts, tiny_belief
from ucon.core.errors import DataError
from ucon.core.files import MANIFEST, write_manifest
from ucon.habits import book
from ucon.learning.belief_head.learner import CONFIG, WEIGHTS
from ucon.objects.catalogue import catalogue
from ucon.readers import AnchorReader
from ucon.readers.sampled_homes import sampled_kb

HABITS = [
    "Every night the wallet is left on the low table in front of the couch.",
    "On trips it hides among socks in my luggage.",
    "Tea is never drunk after four.",
]
NAMES = ["coffee_table", "sofa", "suitcase", "fridge", "toilet", "desk"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The model folder of an untrained head."""
    path = tmp_path_factory.mktemp("head")
    files = tiny_belief().product()
    for name, content in files.items():
        (path / name).write_bytes(content)
    write_manifest(path, files)
    return path


@pytest.fixture(scope="module")
def reader(folder):
    return HeadReader(load_head(folder), plain_parts())


def test_stands_in_for_the_fitted_reader(reader):
    locations = ReadHabits(reader)({"habits": HABITS, "target": "wallet", "habit_level": "gt"})
    fitted = ReadHabits(AnchorReader())({"habits": HABITS, "target": "wallet", "habit_level": "gt"})
    assert locations.names == fitted.names
    assert locations.p.shape == fitted.p.shape
    assert 0.5 < locations.p.sum() < 1, "the rest is what nobody knows"


def test_beliefs_add_up(reader):
    belief = reader.belief("wallet", HABITS, NAMES, trusted=True)
    assert belief.p.sum() + belief.unseen == pytest.approx(1)
    assert 0 < belief.unseen - sum(belief.unseen_p.values()) < 0.2, "something that nobody knows"
    assert np.allclose(belief.relation.sum(1), 1)
    assert max(zip(belief.p, NAMES, strict=True))[1] in ("coffee_table", "suitcase")


def test_every_level_and_no_habit(reader):
    for texts, trusted in ((HABITS, True), (HABITS, False), ((), False), ((), True)):
        reading = reader.read("wallet", texts, trusted=trusted)
        assert reading.relevance.shape == (len(texts),)
        assert reading.belief(NAMES).p.sum() > 0
    assert reader.belief("wallet", [], []).unseen == pytest.approx(1)
    assert reader.belief("desk", [], ["desk", "sofa"]).p[0] < 1e-12
    assert reader.belief("wallet", HABITS, ["sofa", "sofa"]).candidates == ("sofa",)


def test_candidates_may_grow(reader):
    other = next(name for name in catalogue().names if name not in reader.number)
    reading = reader.read("wallet", HABITS)
    first = reading.belief(NAMES)
    grown = reading.belief([*NAMES, other])
    fresh = reader.read("wallet", HABITS).belief([*NAMES, other])
    assert np.allclose(grown.p, fresh.p, atol=1e-6)
    assert np.allclose(grown.p[:-1] / grown.p[0], first.p / first.p[0], atol=1e-6)


def test_unknown_names_are_read_by_their_words(reader):
    name = next(n for n in ("fireplace", "aquarium", "bookend", "vase") if n in catalogue() and n not in reader.number)
    habits = [f"The wallet always lies next to the {name}.", "Tea is never drunk after four."]
    named = reader.belief("wallet", habits, [name, "sofa"], trusted=True)
    silent = reader.belief("wallet", habits[1:], [name, "sofa"], trusted=True)
    assert named.p[0] > 2 * silent.p[0]


def test_several_targets_at_once_are_read_as_one_by_one(reader):
    kb = sampled_kb(book(), "train", 2, "task", k=4)
    for reading in reader.read_all(list(kb.entries), kb.texts):
        alone = reader.read(reading.target, kb.texts)
        assert np.allclose(alone.belief(NAMES).p, reading.belief(NAMES).p, atol=1e-5)
        assert np.allclose(alone.relevance, reading.relevance, atol=1e-3)


def test_support_names_the_reason(reader):
    reading = reader.read("wallet", HABITS, trusted=True)
    assert reading.support("suitcase").argmax() == 1
    assert reading.support("coffee_table").argmax() == 0


@pytest.mark.parametrize("name", [WEIGHTS, CONFIG])
def test_cut_off_and_altered_files_are_refused(folder, tmp_path, name):
    for change in (lambda raw: raw[:-20], lambda raw: raw[:30] + bytes([raw[30] ^ 1]) + raw[31:]):
        shutil.copytree(folder, tmp_path / "copy", dirs_exist_ok=True)
        file = tmp_path / "copy" / name
        file.write_bytes(change(file.read_bytes()))
        with pytest.raises(DataError, match="truncated or altered"):
            load_head(tmp_path / "copy")


def sealed(folder, tmp_path, name, change):
    """A copy of the model with one file changed and the manifest updated."""
    shutil.copytree(folder, tmp_path, dirs_exist_ok=True)
    (tmp_path / name).write_bytes(change((tmp_path / name).read_bytes()))
    write_manifest(tmp_path, [WEIGHTS, CONFIG])
    return tmp_path


def with_options(**options):
    return lambda raw: json.dumps({"head": {**json.loads(raw)["head"], **options}}).encode()


def with_tensors(change):
    return lambda raw: save(change(load(raw)))


def pickled(raw):
    buffer = io.BytesIO()
    torch.save({"a": torch.zeros(3)}, buffer)
    return buffer.getvalue()


UNFIT = {
    "another width": (CONFIG, with_options(width=24), rf"{WEIGHTS}: \w\S* is \(.*\), expected \("),
    "an unknown option": (CONFIG, with_options(layers=3), rf"{CONFIG}: describes no belief head of this version"),
    "an impossible option": (CONFIG, with_options(width=-1), rf"{CONFIG}: describes no belief head \(learner\.head\."),
    "no head": (CONFIG, lambda raw: b"{}", rf"{CONFIG}: describes no belief head of this version; train one"),
    "no options": (CONFIG, lambda raw: b'{"head": 3}', rf"{CONFIG}: describes no belief head of this version"),
    "no JSON": (CONFIG, lambda raw: b"{", rf"{CONFIG}:1:2: not JSON"),
    "a pickle": (WEIGHTS, pickled, rf"{WEIGHTS}: not a safetensors file \(a pickle, which is never read\)"),
    "a tensor less": (WEIGHTS, with_tensors(lambda t: dict(sorted(t.items())[1:])), r"lacks tensor \w"),
    "a tensor more": (WEIGHTS, with_tensors(lambda t: t | {"z": torch.zeros(2)}), "has the unknown tensor z"),
    "no number": (WEIGHTS, with_tensors(lambda t: {n: v * torch.nan for n, v in t.items()}), "are not finite"),
}


@pytest.mark.parametrize("name", UNFIT)
def test_what_is_no_head_of_this_architecture_is_named(folder, tmp_path, name):
    file, change, message = UNFIT[name]
    with pytest.raises(DataError, match=message) as caught:
        load_head(sealed(folder, tmp_path, file, change))
    assert str(tmp_path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_head_without_a_manifest_is_refused(folder, tmp_path):
    shutil.copytree(folder, tmp_path, dirs_exist_ok=True)
    (tmp_path / MANIFEST).unlink()
    with pytest.raises(DataError, match="cannot be verified"):
        load_head(tmp_path)


@pytest.mark.timed
def test_shipped_head_reads():
    reader = HeadReader.load()
    kb = sampled_kb(book(), "test", 1, "task")
    target = next(iter(kb.entries))
    reading = reader.read(target, kb.texts)
    assert reading.belief(NAMES).p.sum() > 0
    started = time.process_time()
    for other in list(kb.entries)[1:6]:
        reader.read(other, kb.texts).belief(NAMES)
    assert (time.process_time() - started) / 5 < 0.5
    assert sum(file.stat().st_size for file in SHIPPED.iterdir()) < 5e6


@pytest.mark.slow
def test_shipped_head_reaches_its_bars():
    """Issue 5, section 4.3, on test categories; 20 knowledge bases of each mode."""
    from models.nets.belief.measure_head import on_the_book

    reader, hit = HeadReader.load(), lambda found, level: np.mean(found[level].values["hit_at_5"])
    task = on_the_book(reader, "test", "task", 20)
    assert hit(task, "gt") >= 0.80
    assert min(hit(task, "full"), hit(task, "retrieval")) >= 0.55
    whole = on_the_book(reader, "test", "category", 20)
    assert hit(whole, "gt") >= 0.75 * hit(whole, "oracle")
    for found in (task, whole):
        assert max(found[level].calibration_error for level in ("none", "full", "retrieval", "gt")) <= 0.02


def test_habits_count_as_retrieved_unless_it_is_said_that_all_are_of_the_target(reader):
    """Habits are trusted only at level gt, where all of them are about the target."""
    for read in (reader.belief, lambda *given, **said: reader.read(*given[:2], **said).belief(given[2])):
        plain, trusted, doubted = (
            read("wallet", HABITS, NAMES, **said).p for said in ({}, {"trusted": True}, {"trusted": False})
        )
        assert np.array_equal(plain, doubted)
        assert not np.allclose(doubted, trusted)
