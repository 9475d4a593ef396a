"""Collects hypotheses of searches for the judge, in worker processes; what was collected is kept and found again."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import fields
from functools import lru_cache
from pathlib import Path
from typing import Final

import numpy as np
from safetensors.numpy import save

from ucon.core.files import sha256_bytes, user_cache
from ucon.core.pool import Needs
from ucon.core.rng import stream
from ucon.fitting.suspect_cases import SuspectCases, cases_of
from ucon.learning.run.kept_batches import code_hash, kept_batches, read_batch
from ucon.perception.detectors.box_detector import BoxDetector
from ucon.task.episode import Episode
from ucon.task.sets import load_episodes

#: Searches of one file.
BATCH: Final = 10
#: Code that defines what is collected. How the search continues decides which cases come up, not what they mean.
_CODE: Final = ("search/suspects.py", "search/suspect_kernels.py", "perception/hypotheses", "fitting/suspect_cases.py")


def collected(episodes: str, searches: int, detectors: Sequence[BoxDetector], seed: int, workers: int) -> SuspectCases:
    """Hypotheses of searches, with the truth.

    Args:
        episodes: name of a set; its episodes are played in random order, again from the first when all were played.
        searches: how many searches.
        detectors: taken in turn, after every round of habit levels.
        seed: of the draw.
        workers: processes; the result does not depend on it.

    Returns:
        Rows in the order of the searches. They are kept in the user's cache, by :func:`case_hash`.
    """
    folder = user_cache() / "judge" / case_hash(episodes, detectors, seed)
    what, given = f"searches in {episodes} homes", (episodes, tuple(detectors), seed)
    needs = Needs(tuple({e.scene for e in _episodes(episodes)}), (episodes,))
    files = kept_batches(folder, searches, BATCH, what, workers, _batch, given, needs)
    return SuspectCases.join([_read(file) for file in files])


def case_hash(episodes: str, detectors: Sequence[BoxDetector], seed: int) -> str:
    """Hash of what the cases mean: code of the evidence, episodes, errors of the detectors, seed."""
    errors = [d.errors.fingerprint() if d.errors is not None else d.name for d in detectors]
    of_episodes = sha256_bytes("".join(e.id for e in _episodes(episodes)).encode())
    return hashlib.sha256(" ".join([code_hash(*_CODE), of_episodes, *errors, str(seed)]).encode()).hexdigest()[:16]


def _batch(episodes: str, detectors: tuple[BoxDetector, ...], seed: int, numbers: range) -> bytes:
    """Cases of some searches, as the bytes of a file."""
    every = _episodes(episodes)
    order = stream(seed, "judge", episodes).permutation(len(every))
    found = [cases_of(every[int(order[k % len(every)])], k, detectors[k // 4 % len(detectors)], seed) for k in numbers]
    return _bytes(SuspectCases.join(found))


@lru_cache(maxsize=4)
def _episodes(name: str) -> tuple[Episode, ...]:
    return load_episodes(name)


def _bytes(cases: SuspectCases) -> bytes:
    """Cases as a file; equal cases give equal bytes."""
    return save({f.name: np.ascontiguousarray(getattr(cases, f.name)) for f in fields(cases)})


def _read(path: Path) -> SuspectCases:
    """The cases of a file of :func:`_bytes`.

    Raises:
        DataError: the file is damaged.
    """
    return SuspectCases(**read_batch(path, [f.name for f in fields(SuspectCases)], "cases"))
