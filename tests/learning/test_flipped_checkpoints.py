"""Checkpoints with cuts or flipped bits are never loaded as if whole; the error names the previous, intact one."""

import re
from contextlib import suppress

import pytest

from tests.learning.test_run import begun
from tests.learning.tiny import Line
from ucon.core.files import MANIFEST
from ucon.core.rng import stream
from ucon.learning.run.checkpoints import BEST, LATEST, TENSORS, VALUES, CheckpointError, Checkpoints
from ucon.learning.run.training_run import CHECKPOINTS

CUTS, FLIPS = 10, 100


@pytest.fixture
def checkpoints(tmp_path) -> Checkpoints:
    """The checkpoints of a whole run."""
    run = begun(tmp_path / "run", Line())
    run.run()
    assert (tmp_path / "run" / CHECKPOINTS).is_dir()
    return run.checkpoints


def cuts(raw: bytes) -> list[bytes]:
    """The file cut at ten places, evenly from an empty file to all but the last byte."""
    return [raw[: (len(raw) - 1) * k // (CUTS - 1)] for k in range(CUTS)]


def flips(raw: bytes, name: str) -> list[bytes]:
    """The file with one bit flipped, at a hundred places and at its first and last bit."""
    found = []
    for bit in {0, 8 * len(raw) - 1, *map(int, stream(0, "flip", name).choice(8 * len(raw), FLIPS, replace=False))}:
        changed = bytearray(raw)
        changed[bit // 8] ^= 1 << bit % 8
        found.append(bytes(changed))
    return found


def content(checkpoints: Checkpoints, name: str = LATEST):
    """Everything in a checkpoint, in comparable form."""
    step, state = checkpoints.load(name)
    return step, dict(state.values), {key: tensor.numpy().tobytes() for key, tensor in state.tensors.items()}


def refusal(checkpoints: Checkpoints) -> str:
    with pytest.raises(CheckpointError) as caught:
        checkpoints.load()
    assert "\n" not in str(caught.value)
    return str(caught.value)


@pytest.mark.parametrize("name", [TENSORS, VALUES])
def test_all_damage_to_the_state_is_noticed_and_the_checkpoint_before_is_named(checkpoints, name):
    path = checkpoints.all()[-1] / name
    raw = path.read_bytes()
    damaged = cuts(raw) + flips(raw, name)
    assert len(damaged) >= CUTS + FLIPS
    for bad in damaged:
        path.write_bytes(bad)
        advice = re.search(r"resume=.*(step_\d{8})$", refusal(checkpoints))
        assert advice is not None
        assert advice[1] == checkpoints.all()[-2].name
    assert content(checkpoints, checkpoints.all()[-2].name)[0] < content_step(path)
    path.write_bytes(raw)
    assert content(checkpoints)[0] == content_step(path)


def content_step(path) -> int:
    """The step that a checkpoint's folder is named after."""
    return int(path.parent.name.removeprefix("step_"))


def test_damage_to_the_checksums_is_noticed_or_changes_nothing(checkpoints):
    """Nothing protects the checksums themselves, so a flip may hit something unread; a cut file is invalid JSON."""
    path = checkpoints.all()[-1] / MANIFEST
    raw, whole, refused = path.read_bytes(), content(checkpoints), 0
    for bad in cuts(raw.rstrip()):
        path.write_bytes(bad)
        refusal(checkpoints)
    for bad in flips(raw, MANIFEST):
        path.write_bytes(bad)
        try:
            assert content(checkpoints) == whole
        except CheckpointError:
            refused += 1
    assert refused > FLIPS * 3 // 4


@pytest.mark.parametrize("name", [LATEST, BEST])
def test_a_damaged_pointer_leads_to_a_whole_checkpoint_or_is_refused(checkpoints, name):
    path = checkpoints.folder / name
    raw, whole = path.read_bytes(), {one.name: content(checkpoints, one.name) for one in checkpoints.all()}
    for bad in cuts(raw.rstrip()) + flips(raw, name):
        path.write_bytes(bad)
        with suppress(CheckpointError):
            assert content(checkpoints, name) in whole.values()
