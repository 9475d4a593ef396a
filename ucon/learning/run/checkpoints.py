"""Checkpoints: folders of safetensors and JSON under a SHA-256 manifest, each complete or absent.

    checkpoints/step_00000200/{tensors.safetensors, state.json, MANIFEST.json}
    checkpoints/latest        name of the newest checkpoint
    checkpoints/best          name of the one with the best validation score

A checkpoint is written under a temporary name and renamed; then the pointers ``best`` and ``latest`` are moved. So
whenever a run is killed, ``latest`` names a complete checkpoint. One that was altered or truncated, or that belongs to
another run, is refused.
"""

from __future__ import annotations

import os
import re
import shutil
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from ucon.core.errors import DataError, brief
from ucon.core.files import canonical_json, read_verified, write_atomic, write_manifest
from ucon.core.tensor_files import read_tensors
from ucon.core.untrusted.plain_file import read_plain
from ucon.core.untrusted.strict_json import JsonError, parse_json
from ucon.learning.run.protocol import State
from ucon.learning.run.run_plan import MOST_STEPS

TENSORS: Final = "tensors.safetensors"
VALUES: Final = "state.json"
LATEST: Final = "latest"
BEST: Final = "best"
FORMAT: Final = 1
_NAME: Final = re.compile(r"step_\d{8}")
#: Largest files that are read, in bytes: plain values (with DAgger's trajectories), pointers, and tensors by default.
_MOST_VALUES: Final = 1 << 28
_MOST_POINTER: Final = 100
_MOST_TENSORS: Final = 1 << 34


class CheckpointError(DataError):
    """A checkpoint that is missing, truncated or altered, or of another run."""


class Checkpoints:
    """Writes and reads the checkpoints of one run, which is identified by its hashes.

    Args:
        folder: ``checkpoints/`` of the run.
        identity: hashes of the run; a checkpoint with other hashes is refused.
        keep: number of newest checkpoints to keep; those that were the best when these were written are kept, too.
    """

    def __init__(self, folder: Path, identity: Mapping[str, str], keep: int = 2) -> None:

        self.folder = folder
        self.identity = dict(identity)
        self.keep = keep

    def save(
        self, step: int, state: State, *, best: int | None = None, planned: Callable[[int], bool] = lambda step: True
    ) -> Path:
        """Write the state after ``step`` steps, point ``latest`` at it, and delete checkpoints that are no longer kept.

        Args:
            step: steps done.
            state: of learner and trainer.
            best: step of the checkpoint with the best validation score so far; ``best`` points at it if it is ``step``.
            planned: whether a step is one at which the run saves anyway. A checkpoint of another step, where the run
                was stopped, is deleted at the next planned one: the run then leaves the same files as one that was not
                stopped.

        Returns:
            Folder of the checkpoint.
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
        if best == step:  # before `latest`: a run that resumes there does not validate it again
            write_atomic(self.folder / BEST, name + "\n")
        write_atomic(self.folder / LATEST, name + "\n")
        self._drop_old(planned)
        return self.folder / name

    def load(self, name: str = LATEST, most: int = _MOST_TENSORS) -> tuple[int, State]:
        """Read a checkpoint.

        Args:
            name: ``latest``, ``best`` or a folder's name.
            most: largest file of tensors that is read, in bytes.

        Returns:
            Steps done, and the state; tensors on the CPU.

        Raises:
            CheckpointError: missing, truncated, altered, or of another run.
        """
        name = self._named(name) if name in (LATEST, BEST) else name
        if not _NAME.fullmatch(name):
            raise CheckpointError(f"{brief(name)}: not a checkpoint name; {self._others()}")
        folder = self.folder / name
        if not folder.exists() and (aside := _aside(folder)).is_dir():
            aside.rename(folder)  # its process was killed between the two renames of _put
        try:
            content = _content(read_verified(folder / VALUES, _MOST_VALUES))
            if step_name(content.step) != name:
                raise DataError(f"{VALUES} belongs to step {content.step}")
        except DataError as error:
            raise CheckpointError(f"checkpoint {folder}: {error}; {self._others(name)}") from None
        if content.identity != self.identity:
            keys = {*content.identity, *self.identity}
            differ = sorted(brief(k) for k in keys if content.identity.get(k) != self.identity.get(k))
            raise CheckpointError(
                f"checkpoint {folder}: of another run (different {', '.join(differ)}); "
                "resume with the configuration and the data that it was made with"
            )
        try:
            tensors = read_tensors(read_verified(folder / TENSORS, most), folder / TENSORS)
        except DataError as error:
            raise CheckpointError(f"checkpoint {folder}: {error}; {self._others(name)}") from None
        return content.step, State(tensors, content.values)

    def unusable(self, step: int, reason: str) -> CheckpointError:
        """The error about a checkpoint that cannot be used; its message names another one to continue from.

        Args:
            step: number of steps after which it was written.
            reason: what is wrong with it, in words.
        """
        name = step_name(step)
        return CheckpointError(f"checkpoint {self.folder / name}: {reason}; {self._others(name)}")

    def rewind(self, name: str) -> None:
        """Make ``name`` the latest checkpoint and delete all later ones; training will make them again."""
        write_atomic(self.folder / LATEST, name + "\n")
        for path in self.all():
            if path.name > name:
                shutil.rmtree(path)

    def point_to_best(self, step: int | None) -> bool:
        """Point ``best`` at the checkpoint after ``step`` steps.

        Returns:
            False where ``step`` is None or that checkpoint is gone; the pointer is then deleted.
        """
        if step is not None and (self.folder / step_name(step)).is_dir():
            write_atomic(self.folder / BEST, step_name(step) + "\n")
            return True
        (self.folder / BEST).unlink(missing_ok=True)
        return False

    def all(self) -> list[Path]:
        """Folders of all checkpoints, oldest first; links and other files are left out."""
        found = self.folder.glob("step_*")
        return sorted(p for p in found if _NAME.fullmatch(p.name) and p.is_dir() and not p.is_symlink())

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
        """Rename the finished folder into place and flush the directory to disk.

        A folder that is there already was left by a run that was interrupted after writing it, or has yet to be
        validated.
        """
        if replaced := final.is_dir():
            shutil.rmtree(_aside(final), ignore_errors=True)
            final.rename(_aside(final))  # `latest` may name it, so it stays until the other one is there
        temporary.rename(final)
        if replaced:
            shutil.rmtree(_aside(final), ignore_errors=True)
        handle = os.open(final.parent, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)

    def _named(self, pointer: str) -> str:
        """Name of the checkpoint that ``latest`` or ``best`` points at."""
        try:
            return read_plain(self.folder / pointer, _MOST_POINTER).decode().strip()
        except (OSError, DataError, UnicodeDecodeError):
            raise CheckpointError(
                f"{self.folder / pointer}: missing or damaged, so no checkpoint is {pointer}; {self._others()}"
            ) from None

    def _others(self, bad: str = "") -> str:
        """Advice for an error message: another checkpoint to resume from, or to start a new run."""
        names = [path.name for path in self.all() if path.name != bad]
        if not names:
            return "there is no other one, start a new run"
        return f"continue from an earlier one with resume={self.folder / names[-1]}"

    def _drop_old(self, planned: Callable[[int], bool]) -> None:
        there = self.all()
        newest = [path for path in there if planned(int(path.name.removeprefix("step_")))][-self.keep :]
        newest += [path for path in there[-1:] if path not in newest]
        kept = {path.name for path in newest} | {self._best_of(path) for path in newest}
        if (self.folder / BEST).is_file():
            kept.add(self._named(BEST))
        for path in there:
            if path.name not in kept:
                shutil.rmtree(path)
        for path in self.folder.glob(".step_*"):  # left by a killed process
            shutil.rmtree(path, ignore_errors=True)

    @staticmethod
    def _best_of(folder: Path) -> str:
        """Name of the best checkpoint when this one was written.

        Empty if there was none, or its file cannot be read.
        """
        try:
            best = _content(read_plain(folder / VALUES, _MOST_VALUES)).best
        except (OSError, DataError):
            return ""
        return "" if best is None else step_name(best)


@dataclass(frozen=True)
class _Content:
    """Content of a checkpoint's ``state.json``."""

    identity: dict[str, str]
    step: int
    best: int | None
    values: dict[str, Any]


def _content(raw: bytes) -> _Content:
    """Parse and check ``state.json``.

    Raises:
        DataError: not JSON, of another format, or with missing or wrong entries.
    """
    try:
        found = parse_json(raw, max_bytes=_MOST_VALUES)
    except JsonError as error:
        raise DataError(f"{VALUES}: {error}") from None
    if not isinstance(found, dict) or found.get("format") != FORMAT:
        number = found.get("format") if isinstance(found, dict) else None
        raise DataError(f"{VALUES}: format {brief(number)}, this version reads {FORMAT}")
    parts: list[Any] = [found.get(name) for name in ("identity", "step", "best", "values")]
    content = _Content(*parts)
    hashes = isinstance(content.identity, dict) and all(isinstance(value, str) for value in content.identity.values())
    steps = _is_step(content.step) and (content.best is None or _is_step(content.best))
    if not (hashes and steps and isinstance(content.values, dict)):
        raise DataError(f"{VALUES} has missing or invalid entries")
    return content


def _aside(folder: Path) -> Path:
    """Path of a checkpoint while another one takes its place."""
    return folder.with_name(f".{folder.name}.replaced")


def _is_step(value: Any) -> bool:
    return type(value) is int and 0 <= value <= MOST_STEPS


def step_name(step: int) -> str:
    """Folder name of the checkpoint after ``step`` steps, such as ``step_00000200``; names sort by step."""
    return f"step_{step:08d}"
