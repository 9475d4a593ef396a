"""Files in a format that this version does not read: one line that names both formats and says what to do."""

from __future__ import annotations

import json
import lzma
from pathlib import Path

import pytest
import torch

from tests.sim.homes import hand_house
from ucon.core.errors import DataError, EpisodeError
from ucon.core.files import canonical_json, write_manifest
from ucon.learning.run.checkpoints import FORMAT, TENSORS, VALUES, CheckpointError, Checkpoints
from ucon.learning.run.protocol import State
from ucon.lives.sets import load_lives
from ucon.sim import homefile
from ucon.sim.homefile import house_from_bytes, house_to_bytes
from ucon.task.sets import load_episodes


@pytest.mark.parametrize("other", ["0", "2", "99", "x" * 500])
def test_a_compiled_home(other: str) -> None:
    magic, _, rest = house_to_bytes(hand_house()).split(b" ", 2)
    with pytest.raises(DataError, match=r"some\.home: compiled home of format .*, expected \d+; ") as caught:
        house_from_bytes(b" ".join((magic, other.encode(), rest)), "some.home")
    assert str(caught.value).endswith(homefile.REMEDY)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 300 + len(homefile.REMEDY)


@pytest.mark.parametrize(
    ("name", "load", "what"), [("mini", load_episodes, "episode"), ("lives_mini", load_lives, "life")]
)
def test_a_set_as_it_is_shipped(name: str, load, what: str, tmp_path: Path) -> None:
    """If one line of a file has another format, the error names the line."""
    lines = [canonical_json(one.to_json()) for one in load(name)[:3]]
    lines[1] = json.dumps(json.loads(lines[1]) | {"format": 0})
    path = tmp_path / "old.jsonl.xz"
    path.write_bytes(lzma.compress("".join(f"{line}\n" for line in lines).encode()))
    with pytest.raises(
        EpisodeError, match=rf"old\.jsonl\.xz:2: {what} format 0, expected \d+; make it again$"
    ) as caught:
        load(path)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("alone", [False, True])
def test_a_checkpoint(alone: bool, tmp_path: Path) -> None:
    """The hint names the previous checkpoint; if there is none, it suggests a new run."""
    checkpoints = Checkpoints(tmp_path / "checkpoints", {})
    for step in (1,) if alone else (1, 2):
        checkpoints.save(step, State({"w": torch.zeros(2)}, {}))
    folder = checkpoints.all()[-1]
    (folder / VALUES).write_text(json.dumps(json.loads((folder / VALUES).read_text()) | {"format": FORMAT + 1}))
    write_manifest(folder, [TENSORS, VALUES])
    hint = "there is no other one, start a new run$" if alone else r"resume=.*step_00000001$"
    with pytest.raises(CheckpointError, match=rf"format {FORMAT + 1}, this version reads {FORMAT}; .*{hint}"):
        checkpoints.load()
