"""Finds episodes where a habit about another thing pointed to a place by the target: tea bags beside the tea set.

The paper's third question asks why retrieved habits can do better than the target's own. One answer is a habit of
another thing that says where that thing is, with the target next to it. Such episodes are found from two runs of one
agent: with retrieved habits it found the target, with the target's own (``gt``) it did not, or took much longer; and
among its habits is one about another thing that does stand, as the habit says, by the target. This shows that the habit
was given and the target found, not that the agent went there because of it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ucon.core.errors import ConfigError
from ucon.evaluation.kept.record import EpisodeRecord
from ucon.task.episode import Episode

if TYPE_CHECKING:
    from ucon.envs.knowledge import HabitSource

#: Largest distance of a landmark from the target, centre to centre, in metres.
NEAR_M = 1.0
#: Least ratio of steps with the target's own habits to steps with retrieved ones.
LONGER = 1.5


@dataclass(frozen=True)
class LandmarkCase:
    """One such episode; ``steps_gt`` is given for failures too (``success_gt`` false)."""

    episode: str
    scene: str
    target: str
    landmark: str
    """Category of the other thing."""
    habit: str
    """The sentence about it."""
    rank: int
    """Rank of that habit in the list that the agent was given, from 1."""
    distance_m: float
    steps: int
    success_gt: bool
    steps_gt: int

    def to_json(self) -> dict[str, Any]:
        """Plain values by name."""
        return asdict(self)


def landmark_cases(
    retrieved: Sequence[EpisodeRecord],
    own: Sequence[EpisodeRecord],
    episodes: Sequence[Episode],
    source: HabitSource,
) -> Iterator[LandmarkCase]:
    """All such episodes, in the order of ``retrieved``.

    Args:
        retrieved: records of a run at level ``retrieval``.
        own: records of a run of the same agent at level ``gt``.
        episodes: those that the runs played.
        source: gives the habits.

    Raises:
        ConfigError: the runs are of other levels or agents, or an episode is missing.
    """
    _check(retrieved, own)
    at_gt = {record.episode: record for record in own}
    by_id = {episode.id: episode for episode in episodes}
    for record in retrieved:
        other = at_gt.get(record.episode)
        if other is None or not record.success or (other.success and other.steps < LONGER * record.steps):
            continue
        if record.episode not in by_id:
            raise ConfigError(f"episode {record.episode} is not in the given set; name the set that the runs played")
        yield from _cases(record, other, by_id[record.episode], source)


def _cases(
    record: EpisodeRecord, other: EpisodeRecord, episode: Episode, source: HabitSource
) -> Iterator[LandmarkCase]:
    """The case with the best-ranked habit about a landmark, if there is one."""
    dataset = source.dataset
    near = landmarks(episode)
    for rank, row in enumerate(source.knowledge(episode, "retrieval").rows.tolist(), 1):
        entry = dataset.entries[dataset.row_entry[row]]
        placed = near.get(entry.id)
        if placed is None or placed[0] not in dataset.habits[row].supports:
            continue
        yield LandmarkCase(
            record.episode, record.scene, record.target, entry.category, dataset.texts[row], rank,
            round(placed[1], 2), record.steps, other.success, other.steps,
        )  # fmt: skip
        return


def landmarks(episode: Episode) -> dict[str, tuple[int, float]]:
    """Other objects near the target, by the entry that placed them.

    Returns:
        Index of the placement in the entry, and distance in metres.
    """
    target = episode.target_object
    out = {}
    for number, (thing, (entry, placement)) in enumerate(
        zip(episode.arrangement.objects, episode.placed_by, strict=True)
    ):
        distance = float(np.linalg.norm(np.subtract(thing.position, target.position)))
        if number != episode.target and entry and distance <= NEAR_M:
            out[entry] = (placement, distance)
    return out


def _check(retrieved: Sequence[EpisodeRecord], own: Sequence[EpisodeRecord]) -> None:
    for records, level in ((retrieved, "retrieval"), (own, "gt")):
        found = {record.habit_level for record in records}
        if found != {level}:
            raise ConfigError(f"a run at habit level {level} is needed, this one has {', '.join(sorted(found))}")
    if {r.agent for r in retrieved} != {r.agent for r in own}:
        raise ConfigError("the two runs are of different agents; give two runs of one agent")
