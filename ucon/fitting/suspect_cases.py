"""Training data of the judge of suspects: hypotheses of searches in training homes, with the truth.

A search by belief is played with a detector that errs. At each new look at a thing that may be the target, its evidence
and whether it is the target are recorded; of looks at other things, only a share.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from ucon.core.geometry import HEADING_COS, HEADING_SIN
from ucon.core.rng import stream
from ucon.envs.ucon_env import UcONEnv
from ucon.perception.belief.from_habits import ReadHabits, expecting
from ucon.perception.detectors.box_detector import BoxDetector
from ucon.search.doubt import Doubts
from ucon.search.searcher import Searcher
from ucon.search.suspects import EVIDENCE, evidence_of
from ucon.task.episode import Episode

#: Habit levels that the searches are given, in turn.
LEVELS = ("none", "retrieval", "full", "gt")
#: Share of the new looks at things other than suspects that is recorded.
OTHERS = 0.25
#: A box belongs to the target if their middles are at most this far apart, metres, and the box is not much larger
#: (factor and metres): most pixels of a box around a small thing may show what is behind it.
NEAR_M, LARGER, LARGER_M = 0.2, 2.0, 0.3
#: Searches that collect cases stay in doubt longer than measured searches, so that they give more cases.
PATIENT = Doubts(take=0.9, settle=0.7)


@dataclass(frozen=True)
class SuspectCases:
    """n hypotheses; all arrays have one row for each."""

    evidence: NDArray[np.float32]
    """(n, F), a column for each of :data:`ucon.search.suspects.EVIDENCE`."""
    is_target: NDArray[np.bool_]
    """Whether it is the target."""
    weight: NDArray[np.float32]
    """How many hypotheses it stands for."""
    home: NDArray[np.int32]
    """Number of the episode."""

    @classmethod
    def join(cls, parts: Sequence[SuspectCases]) -> SuspectCases:
        """All rows of some cases."""
        return cls(*(np.concatenate([getattr(part, f.name) for part in parts]) for f in fields(cls)))

    def keep(self, rows: NDArray[np.bool_]) -> SuspectCases:
        """A selection of the rows."""
        return SuspectCases(*(getattr(self, f.name)[rows] for f in fields(self)))


def cases_of(episode: Episode, number: int, detector: BoxDetector, seed: int = 0) -> SuspectCases:
    """Search for the target of one episode, and record the hypotheses on the way.

    Args:
        episode: of a training home.
        number: of the episode; the habit level follows from it.
        detector: a detector that errs.
        seed: of the choice of looks that are recorded.

    Returns:
        The cases; there may be none.
    """
    draw = stream(seed, "suspect cases", episode.id)
    env = UcONEnv(
        [episode], habit_level=LEVELS[number % len(LEVELS)], observe="symbolic", detector=detector, privileged=True
    )
    rows: list[NDArray[np.float32]] = []
    truth: list[bool] = []
    weight: list[float] = []
    try:
        observation, info = env.reset(options={"episode": 0})
        target = int(info["privileged"]["target_instance"])
        where = _in_start_frame(env, target)
        search = Searcher(info, expecting(info, ReadHabits()), doubts=PATIENT)
        looks: dict[int, int] = {}
        over = False
        while not over:
            action = search.look(observation, info)
            assert search.doubt is not None
            suspects, seen = set(search.doubt.suspects.tracks), search.doubt.looks(search)
            new = [t for t, found in seen.items() if len(found) != looks.get(t, 0)]
            looks.update({t: len(seen[t]) for t in new})
            chosen = [t for t in new if t in suspects or draw.random() < OTHERS]
            if chosen:
                right = set(detector.tracks_of((target,)))
                rows.append(evidence_of(search, chosen))
                truth += [t in right or _is_there(search.map.box[t], where) for t in chosen]
                weight += [1.0 if t in suspects else 1.0 / OTHERS for t in chosen]
            if action is None:
                action = search.choose(search.decision().best)
            observation, _, terminated, truncated, info = env.step(int(action))
            over = terminated or truncated
    finally:
        env.close()
    evidence = np.concatenate(rows) if rows else np.zeros((0, len(EVIDENCE)), np.float32)
    return SuspectCases(
        evidence, np.array(truth, bool), np.array(weight, np.float32), np.full(len(truth), number, np.int32)
    )


def _in_start_frame(env: UcONEnv, instance: int) -> NDArray[np.float64]:
    """Middle (3,) and diagonal of an instance's closed box, metres in the agent's start frame; called at the start."""
    box = env.search.world.boxes[instance]
    x, y = env.search.xy
    c, s = HEADING_COS[env.search.pose.heading], HEADING_SIN[env.search.pose.heading]
    middle = 0.5 * (box[:3] + box[3:])
    dx, dy = middle[0] - x, middle[1] - y
    return np.array([c * dx + s * dy, c * dy - s * dx, middle[2], np.linalg.norm(box[3:] - box[:3])])


def _is_there(box: NDArray[np.float64], where: NDArray[np.float64]) -> bool:
    """Whether a 3-D box (6,) may belong to the target, given by :func:`_in_start_frame`."""
    apart = float(np.linalg.norm(0.5 * (box[:3] + box[3:]) - where[:3]))
    return apart <= NEAR_M and float(np.linalg.norm(box[3:] - box[:3])) <= LARGER * float(where[3]) + LARGER_M
