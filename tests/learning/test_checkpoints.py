"""Checkpoints are whole or refused, and the best and latest ones are kept."""

import json

import pytest
import torch

from ucon.core.errors import DataError
from ucon.learning.run.checkpoints import TENSORS, VALUES, CheckpointError, Checkpoints
from ucon.learning.run.protocol import State


def state(value: float) -> State:
    return State({"w": torch.full((3, 2), value), "n": torch.tensor([7])}, {"done": int(value), "note": "é"})


@pytest.fixture
def kept(tmp_path):
    checkpoints = Checkpoints(tmp_path / "checkpoints", {"config": "c", "habits": "h"}, keep=2)
    for step in (1, 2, 3, 4):
        checkpoints.save(step, state(step), best=2 if step > 1 else None)
    return checkpoints


def test_round_trip(kept):
    step, found = kept.load()
    assert step == 4
    assert dict(found.values) == {"done": 4, "note": "é"}
    assert found.tensors["w"].equal(torch.full((3, 2), 4.0))
    assert found.tensors["n"].dtype == torch.int64
    assert kept.load("best")[0] == 2
    assert kept.load("step_00000003")[0] == 3


def test_keeps_the_last_and_the_best(kept):
    assert [path.name for path in kept.all()] == ["step_00000002", "step_00000003", "step_00000004"]
    assert {p.name for p in kept.folder.iterdir()} == {*(p.name for p in kept.all()), "latest", "best"}


@pytest.mark.parametrize("file", [TENSORS, VALUES])
def test_truncated_or_altered_is_refused_and_says_what_to_do(kept, file):
    path = kept.all()[-1] / file
    whole = path.read_bytes()
    for bad in (whole[:-4], whole[:-1] + bytes([whole[-1] ^ 1]), b""):
        path.write_bytes(bad)
        with pytest.raises(CheckpointError, match=r"truncated or altered.*resume=.*step_00000003"):
            kept.load()
    assert issubclass(CheckpointError, DataError)
    path.unlink()
    with pytest.raises(CheckpointError, match="no such file"):
        kept.load()


def test_missing_is_refused(kept, tmp_path):
    (kept.folder / "latest").unlink()
    with pytest.raises(CheckpointError, match=r"missing.*resume=.*step_00000004"):
        kept.load()
    with pytest.raises(CheckpointError, match="start a new run"):
        Checkpoints(tmp_path / "none", {}).load()


def test_of_another_run_is_refused(kept):
    other = Checkpoints(kept.folder, {"config": "c", "habits": "changed"})
    with pytest.raises(CheckpointError, match=r"another run \(different habits\)"):
        other.load()


def test_garbage_under_a_right_manifest_is_refused(kept):
    from ucon.core.files import write_manifest

    folder = kept.all()[-1]
    for file, bad in ((TENSORS, b"nonsense"), (VALUES, b"[]"), (VALUES, json.dumps({"step": "x"}).encode())):
        whole = (folder / file).read_bytes()
        (folder / file).write_bytes(bad)
        write_manifest(folder, [TENSORS, VALUES])
        with pytest.raises(CheckpointError):
            kept.load()
        (folder / file).write_bytes(whole)


def test_leftovers_of_a_killed_process_are_harmless(kept):
    (kept.folder / ".step_00000005.x").mkdir()
    (kept.folder / ".step_00000005.x" / TENSORS).write_bytes(b"half")
    assert kept.load()[0] == 4
    kept.save(5, state(5), best=2)
    assert not list(kept.folder.glob(".step_*"))


def test_rewinding_drops_what_came_later(kept):
    kept.rewind("step_00000003")
    assert kept.load()[0] == 3
    assert kept.load("best")[0] == 2
    kept.save(4, state(40), best=2)
    assert kept.load()[1].values["done"] == 40


def test_what_was_best_stays_as_long_as_one_may_go_back_to_where_it_was(kept):
    for step in (5, 6):
        kept.save(step, state(step), best=6 if step == 6 else 2)
    assert [path.name for path in kept.all()] == ["step_00000002", "step_00000005", "step_00000006"]
    kept.rewind("step_00000005")
    assert kept.point_to_best(2)
    assert kept.load("best")[0] == 2
    for step in (6, 7, 8):
        kept.save(step, state(step), best=6)
    assert [path.name for path in kept.all()] == ["step_00000006", "step_00000007", "step_00000008"]


def test_another_format_is_refused(kept):
    from ucon.core.files import write_manifest

    path = kept.all()[-1] / VALUES
    path.write_text(json.dumps(json.loads(path.read_text()) | {"format": 99}))
    write_manifest(path.parent, [TENSORS, VALUES])
    with pytest.raises(CheckpointError, match="format 99"):
        kept.load()
