"""Files that would run a program if they were unpickled: every reader refuses them in one line, and nothing runs."""

from __future__ import annotations

import io
import lzma
import pickle
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from ucon.core.errors import UconError
from ucon.core.files import write_manifest
from ucon.core.tensor_files import read_tensors
from ucon.core.untrusted.marked_yaml import parse_marked
from ucon.core.untrusted.unpack import UnpackError, read_array, read_arrays
from ucon.evaluation.kept.record import read_records
from ucon.habits.datafile import load_dataset_file
from ucon.habits.official import official
from ucon.learning.run.checkpoints import TENSORS, VALUES, Checkpoints
from ucon.learning.run.protocol import State
from ucon.lives.sets import load_lives
from ucon.objects.catalogue import catalogue
from ucon.sim.homefile import house_from_bytes
from ucon.task.sets import load_episodes


class Touch:
    """Its pickle is a call that makes a file."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __reduce__(self) -> Any:
        return Path.touch, (self.path,)


def pickled(path: Path) -> bytes:
    return pickle.dumps(Touch(path))


def by_torch(path: Path) -> bytes:
    """A file as written by ``torch.save``: a zip with a pickle inside."""
    held = io.BytesIO()
    torch.save({"weight": Touch(path)}, held)
    return held.getvalue()


def array(path: Path) -> bytes:
    """A ``.npy`` file of objects."""
    held = io.BytesIO()
    np.save(held, np.array([Touch(path)], object))
    return held.getvalue()


def arrays(path: Path) -> bytes:
    """An ``.npz`` file of objects."""
    held = io.BytesIO()
    with zipfile.ZipFile(held, "w") as file:
        file.writestr("a.npy", array(path))
    return held.getvalue()


def climbing(path: Path) -> bytes:
    """An ``.npz`` file whose entry would be written elsewhere if it were unpacked to files."""
    held, inside = io.BytesIO(), io.BytesIO()
    np.save(inside, np.zeros(2))
    with zipfile.ZipFile(held, "w") as file:
        file.writestr(f"../../../../../..{path}", inside.getvalue())
    return held.getvalue()


def tagged(path: Path) -> bytes:
    """YAML with a tag that calls a function."""
    return f"a: !!python/object/apply:pathlib.Path.touch [!!python/object/apply:pathlib.Path ['{path}']]\n".encode()


BOMBS = {made.__name__: made for made in (pickled, by_torch, array, arrays, climbing, tagged)}


def a_checkpoint(file: Path) -> None:
    checkpoints = Checkpoints(file.parent / "run", {})
    folder = checkpoints.save(1, State({"w": torch.zeros(1)}, {}))
    (folder / TENSORS).write_bytes(file.read_bytes())
    write_manifest(folder, [TENSORS, VALUES])
    checkpoints.load()


READERS: dict[str, Callable[[Path], Any]] = {
    "a checkpoint": a_checkpoint,
    "tensors": lambda file: read_tensors(file.read_bytes(), file),
    "arrays": lambda file: read_arrays(file.read_bytes(), 1 << 20),
    "an array": lambda file: read_array(file.read_bytes()),
    "YAML": lambda file: parse_marked(file.read_text("utf-8", "replace"), file.name),
    "a habit dataset": lambda file: load_dataset_file(file, catalogue().names),
    "the release": lambda file: official(file, catalogue().names),
    "episodes": load_episodes,
    "lives": load_lives,
    "records": read_records,
    "a home": lambda file: house_from_bytes(file.read_bytes(), file.name),
}


@pytest.mark.parametrize("bomb", BOMBS)
@pytest.mark.parametrize("reader", READERS)
@pytest.mark.parametrize("packed", [False, True])
def test_nothing_in_a_file_is_run(bomb: str, reader: str, packed: bool, tmp_path: Path) -> None:
    """Also if packed like sets and datasets, so that the content inside is read."""
    mark = tmp_path / "elsewhere" / "ran"
    mark.parent.mkdir()
    raw = BOMBS[bomb](mark)
    file = tmp_path / ("file.jsonl.xz" if packed else "file.jsonl")
    file.write_bytes(lzma.compress(raw) if packed else raw)
    if (bomb, reader, packed) == ("climbing", "arrays", False):  # a valid array under an odd name, read into memory
        READERS[reader](file)
    else:
        with pytest.raises((UconError, UnpackError)) as caught:
            READERS[reader](file)
        assert "\n" not in str(caught.value)
    assert not mark.exists()
    assert list(mark.parent.iterdir()) == []


@pytest.mark.parametrize("bomb", ["pickled", "by_torch"])
def test_the_bombs_are_live(bomb: str, tmp_path: Path) -> None:
    """An unsafe loader does run them, so the test above is meaningful."""
    mark = tmp_path / "ran"
    (tmp_path / "bomb").write_bytes(BOMBS[bomb](mark))
    loads = {
        "pickled": "import pickle; pickle.load(open(sys.argv[1], 'rb'))",
        "by_torch": "import torch; torch.load(sys.argv[1], weights_only=False)",
    }
    subprocess.run([sys.executable, "-c", f"import sys; {loads[bomb]}", str(tmp_path / "bomb")], check=True)
    assert mark.exists()
