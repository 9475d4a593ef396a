"""Checkpoints: folders of safetensors and JSON under a SHA-256 manifest, whole or not there.

    checkpoints/step_00000200/{tensors.safetensors, state.json, MANIFEST.json}
    checkpoints/latest        the name of the newest
    checkpoints/best          the name of the one that validated best

A checkpoint is written under a temporary name and renamed, ``best`` and then ``latest`` are moved after that: whenever
a run is killed, ``latest`` names a whole checkpoint. What was altered since, cut off, or belongs to another run is
refused.
"""

from __future__ import annotations

import os
import re
import shutil
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from ucon.core.errors import DataError, brief
from ucon.core.files import canonical_json, read_verified, write_atomic, write_manifest
from ucon.core.strict_json import MAX_BYTES, parse_json, read_bounded
from ucon.learning.learner import State

TENSORS: Final = "tensors.safetensors"
VALUES: Final = "state.json"
LATEST: Final = "latest"
BEST: Final = "best"
FORMAT: Final = 1
#: Of one run, and so of the number in a checkpoint's name.
MOST_STEPS: Final = 10**12
_NAME: Final = re.compile(r"step_\d{8,12}")


class CheckpointError(DataError):
    """A checkpoint that is missing, truncated or altered, or of another run."""


class Checkpoints:
    """The checkpoints of one run, named by its hashes."""

    def __init__(self, folder: Path, identity: Mapping[str, str], keep: int = 2) -> None:
        """``identity``: hashes of the run; ``keep``: newest checkpoints that stay, each with its best one."""
        self.folder = folder
        self.identity = dict(identity)
        self.keep = keep

    def save(self, step: int, state: State, *, best: int | None = None) -> Path:
        """Write the state after ``step`` steps and point ``latest`` at it, drop what is too old.

        Args:
            step: steps done.
            state: of learner and trainer.
            best: step of the one that validated best so far, which ``best`` then names.
        """
        name = step_name(step)
        self.folder.mkdir(parents=True, exist_ok=True)
        temporary = Path(tempfile.mkdtemp(dir=self.folder, prefix=f".{name}."))
        try:
            self._write(temporary, step, state, best)
            self._put(temporary, self.folder / name)
        except BaseException:
            shutil.rmtree(temporary, ignore_errors=True)
            raise
        if best == step:  # before `latest`: who goes on from there does not validate it anew
            write_atomic(self.folder / BEST, name + "\n")
        write_atomic(self.folder / LATEST, name + "\n")
        self._drop_old()
        return self.folder / name

    def load(self, name: str = LATEST) -> tuple[int, State]:
        """Steps done and state of a checkpoint: ``latest``, ``best`` or a folder's name.

        Raises:
            CheckpointError: missing, truncated, altered, or of another run.
        """
        folder = self.folder / (self._named(name) if name in (LATEST, BEST) else name)
        try:
            raw, values = read_verified(folder / TENSORS), read_verified(folder / VALUES)
            content = _content(values)
            step, found, own = content["step"], content["identity"], content["values"]
            if type(step) is not int or not 0 <= step < MOST_STEPS or not isinstance(own, dict):
                raise ValueError(f"step {brief(step)} with {type(own).__name__} values")
            if not isinstance(found, dict):
                raise ValueError(f"{type(found).__name__} for the hashes of the run")
        except (DataError, ValueError, KeyError, TypeError) as error:
            raise CheckpointError(f"checkpoint {folder}: {_reason(error)}; {self._others(folder.name)}") from None
        if found != self.identity:
            differ = sorted(brief(k) for k in {*found, *self.identity} if found.get(k) != self.identity.get(k))
            raise CheckpointError(
                f"checkpoint {folder}: of another run (different {', '.join(differ)}); "
                "resume with the configuration and the data that it was made with"
            )
        return step, State(_tensors(raw, folder), own)

    def rewind(self, name: str) -> None:
        """Make ``name`` the newest: later checkpoints, which it will make again, are removed."""
        best = self._best_of(self.folder / name)
        if best and (self.folder / best).is_dir():
            write_atomic(self.folder / BEST, best + "\n")
        else:
            (self.folder / BEST).unlink(missing_ok=True)
        write_atomic(self.folder / LATEST, name + "\n")
        for path in self.all():
            if path.name > name:
                shutil.rmtree(path)

    @property
    def has_best(self) -> bool:
        """One has validated best and is still there."""
        return (self.folder / BEST).is_file() and (self.folder / self._named(BEST)).is_dir()

    def all(self) -> list[Path]:
        """Folders of all checkpoints, oldest first."""
        return sorted(path for path in self.folder.glob("step_*") if path.is_dir())

    def _write(self, folder: Path, step: int, state: State, best: int | None) -> None:
        from safetensors.torch import save

        content = {
            "format": FORMAT,
            "identity": self.identity,
            "step": step,
            "best": best,
            "values": dict(state.values),
        }
        write_atomic(folder / TENSORS, save({k: v.contiguous() for k, v in sorted(state.tensors.items())}))
        write_atomic(folder / VALUES, canonical_json(content) + "\n")
        write_manifest(folder, [TENSORS, VALUES])
        folder.chmod(0o755)

    @staticmethod
    def _put(temporary: Path, final: Path) -> None:
        if final.is_dir():  # written before an interruption, and now again
            shutil.rmtree(final)
        temporary.rename(final)
        handle = os.open(final.parent, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)

    def _named(self, pointer: str) -> str:
        try:
            name = read_bounded(self.folder / pointer, 100).decode().strip()
            if not _NAME.fullmatch(name):
                raise ValueError(name)
            return name
        except (OSError, ValueError):
            raise CheckpointError(
                f"{self.folder / pointer}: missing or damaged, so no checkpoint is {pointer}; {self._others()}"
            ) from None

    def _others(self, bad: str = "") -> str:
        """What to do instead."""
        names = [path.name for path in self.all() if path.name != bad]
        if not names:
            return "there is no other one, start the run anew"
        return f"go on from an earlier one with resume={self.folder / names[-1]}"

    def _drop_old(self) -> None:
        newest = self.all()[-self.keep :]
        kept = {path.name for path in newest} | {self._best_of(path) for path in newest}
        if (self.folder / BEST).is_file():
            kept.add(self._named(BEST))
        for path in self.all():
            if path.name not in kept:
                shutil.rmtree(path)
        for path in self.folder.glob(".step_*"):  # left by a killed process
            shutil.rmtree(path, ignore_errors=True)

    @staticmethod
    def _best_of(folder: Path) -> str:
        """Name of the checkpoint that was best when this one was written; empty if none was, or it cannot be told."""
        try:
            best = _content(read_bounded(folder / VALUES, MAX_BYTES)).get("best")
        except (OSError, ValueError, KeyError, TypeError):
            return ""
        return step_name(best) if type(best) is int and 0 <= best < MOST_STEPS else ""


def _content(values: bytes) -> dict[str, Any]:
    """What a checkpoint says of itself.

    Raises:
        ValueError: no JSON, or of another format.
    """
    content: dict[str, Any] = parse_json(values)
    if content["format"] != FORMAT:
        raise ValueError(f"format {brief(content['format'])}, this version reads {FORMAT}")
    return content


def step_name(step: int) -> str:
    """Name of the checkpoint after ``step`` steps; sorts by step."""
    return f"step_{step:08d}"


def _tensors(raw: bytes, folder: Path) -> Mapping[str, Any]:
    from safetensors import SafetensorError
    from safetensors.torch import load

    try:
        return load(raw)
    except (SafetensorError, ValueError, KeyError) as error:
        why = brief(str(error))
        raise CheckpointError(f"checkpoint {folder}: {TENSORS} is no safetensors file ({why})") from None


def _reason(error: Exception) -> str:
    return str(error) if isinstance(error, DataError) else f"{VALUES} does not say what it should ({brief(str(error))})"
