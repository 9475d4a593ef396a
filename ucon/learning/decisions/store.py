"""The store of labelled decisions: made by worker processes, kept in the cache, found again."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any, ClassVar, Final, Protocol

import numpy as np
from safetensors.numpy import save

from ucon.core.errors import DataError
from ucon.core.files import sha256_bytes, user_cache
from ucon.core.fingerprint import fingerprint_of
from ucon.core.pool import Needs
from ucon.core.rng import stream
from ucon.learning.decisions.decisions import TEXT, Decisions
from ucon.learning.run.kept_batches import code_hash, kept_batches, read_batch
from ucon.task.episode import Episode
from ucon.task.sets import load_episodes

#: Code that decides what a decision is and how the search continues.
_CODE: Final = ("search", "perception", "envs/search", "learning/decisions/decisions.py")
MakeEnv = Callable[[], Any]


class Labels(Protocol):
    """Searches an episode and labels its decisions; its ``repr`` gives all that the labels depend on besides code."""

    name: ClassVar[str]
    """Name of the folder in the cache, and of the random stream."""
    label: ClassVar[str]
    """Name of the label among the frames."""
    searches: ClassVar[int]
    """Number of searches per file."""
    code: ClassVar[tuple[str, ...]]
    """Source files below ``ucon/`` that decide the labels."""

    def __call__(self, env: Any, episode: Episode, level: str, draw: np.random.Generator) -> Decisions | None:
        """Decisions of one search; None where nothing was to be decided."""
        ...


def kept_decisions(
    labels: Labels, episodes: str, searches: int, make: MakeEnv, levels: Sequence[str], seed: int, workers: int
) -> Decisions:
    """Decisions of some searches, in the order of the searches.

    Args:
        labels: plays the searches and labels their decisions; can be pickled.
        episodes: name of a set; its episodes are played in random order, and in a new order after each pass.
        searches: how many.
        make: makes an environment of ``UcONSearch-v0`` that provides what the labels need.
        levels: habit levels, taken in turn.
        seed: of the draw.
        workers: processes; the result does not depend on it.
    """
    folder = user_cache() / labels.name / store_hash(labels, episodes, make, levels, seed)
    given = (labels, episodes, make, tuple(levels), seed)
    needs = Needs(tuple({e.scene for e in _episodes(episodes)}), (episodes,))
    files = kept_batches(
        folder, searches, labels.searches, f"searches in {episodes} homes", workers, _batch, given, needs
    )
    return Decisions.join([part for path in files if (part := _read(path, labels.label)) is not None])


def store_hash(labels: Labels, episodes: str, make: MakeEnv, levels: Sequence[str], seed: int) -> str:
    """Hash of what decides the decisions: labels, code, episodes, habits, reader, detector, levels and seed."""
    of_episodes = sha256_bytes("".join(f"{e.id} {e.home_hash}" for e in _episodes(episodes)).encode())
    parts = [repr(labels), code_hash(*_CODE, *labels.code), of_episodes, *levels, str(seed)]
    env = make()
    detector = env.env.detector
    errors = getattr(detector, "errors", None)
    parts += [env.source.dataset.sha256, str(fingerprint_of(env)), str(getattr(detector, "name", ""))]
    parts += [] if errors is None else [errors.fingerprint()]
    env.close()
    return hashlib.sha256(json.dumps(parts).encode()).hexdigest()[:16]


def _batch(labels: Labels, episodes: str, make: MakeEnv, levels: tuple[str, ...], seed: int, numbers: range) -> bytes:
    """Decisions of some searches, as the bytes of a file."""
    every, found, env = _episodes(episodes), [], make()
    try:
        for k in numbers:
            turn, at = divmod(k, len(every))
            order = stream(seed, labels.name, episodes, turn).permutation(len(every))
            draw = stream(seed, labels.name, "draw", k)
            one = labels(env, every[int(order[at])], levels[k % len(levels)], draw)
            found += [] if one is None else [one]
    finally:
        env.close()
    return _bytes(Decisions.join(found)) if found else save({"episode": np.zeros(0, np.int32)})


@lru_cache(maxsize=4)
def _episodes(name: str) -> tuple[Episode, ...]:
    return load_episodes(name)


def _bytes(decisions: Decisions) -> bytes:
    """Decisions as a file; equal ones give equal bytes."""
    text = {f"text/{name}": value for name, value in decisions.text.items()}
    return save({**{f"frames/{name}": v for name, v in decisions.frames.items()}, **text, "episode": decisions.episode})


def _read(path: Path, label: str) -> Decisions | None:
    """The decisions of a file of :func:`_batch` with a label of that name; None where nothing was to be decided.

    Raises:
        DataError: the file is damaged.
    """
    found = read_batch(path, (), "decisions")
    if [*found] == ["episode"] and not len(found["episode"]):
        return None
    if missing := {"episode", "frames/views", f"frames/{label}", *(f"text/{name}" for name in TEXT)} - {*found}:
        raise DataError(f"{path}: no {min(missing)}; remove it, and it is made again")
    frames = {name[7:]: value for name, value in found.items() if name.startswith("frames/")}
    return Decisions(frames, {name: found[f"text/{name}"] for name in TEXT}, found["episode"].astype(np.int32))
