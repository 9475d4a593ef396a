"""Habits as causes: a habit is a cause if the search changes without it, and success or SPL change too.

A search is a chain of choices, and any early change may by luck end it sooner or later. So sentences that helped are
compared with those that hurt, which luck produces as often; and a cause is confirmed where the search comes out worse
(for one that hurt: better) in every way of not telling it: removed, with the thing elsewhere, and with its landmark
renamed.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Final, Literal

import numpy as np

from ucon.core.errors import EpisodeError
from ucon.envs.told.falsehoods import place_now
from ucon.evaluation.causes.weighing import Weighed
from ucon.evaluation.figures.intervals import Interval, mean_interval, rate_interval
from ucon.evaluation.kept.record import EpisodeRecord
from ucon.habits.types import HabitDataset
from ucon.task.episode import Episode

#: What a sentence is about: the target; another thing that stands near the target, where the sentence says; another
#: thing that may be kept at the target's anchor; or another thing that has nothing to do with the target.
About = Literal["target", "beside", "anchor", "other"]
ABOUT: Final[tuple[About, ...]] = ("target", "beside", "anchor", "other")
#: Largest distance of a landmark from the target, centre to centre, in metres.
NEAR_M: Final = 1.0


@dataclass(frozen=True)
class Tried:
    """One sentence that was removed from one episode, and how the search went with it and without it."""

    episode: str
    scene: str
    target: str
    habit: str
    row: int
    about: About
    thing: str
    """Category that the sentence is about."""
    rank: int
    """Its place in the list that the agent is given, from 1."""
    weight: float
    """How far the belief moves without it, 0 to 1."""
    changes: bool
    """Whether the search takes other actions without it."""
    success: tuple[bool, bool]
    """With the sentence, and without it."""
    spl: tuple[float, float]
    steps: tuple[int, int]

    @property
    def gain(self) -> tuple[int, float]:
        """What the search gains from the sentence: success and SPL with it minus those without it."""
        return int(self.success[0]) - int(self.success[1]), round(self.spl[0] - self.spl[1], 6)

    @property
    def is_cause(self) -> bool:
        """Whether the search changes without the sentence, and its success or SPL too."""
        return self.changes and self.gain != (0, 0.0)

    @property
    def helps(self) -> bool:
        """Whether it is a cause, and the search is better with it."""
        return self.is_cause and self.gain > (0, 0.0)

    @property
    def hurts(self) -> bool:
        """Whether it is a cause, and the search is worse with it."""
        return self.is_cause and not self.helps

    def to_json(self) -> dict[str, Any]:
        """Plain values by name."""
        return asdict(self) | {"gain": self.gain, "cause": self.is_cause}


def tried(
    episode: Episode, dataset: HabitDataset, habit: Weighed, told: EpisodeRecord, without: EpisodeRecord
) -> Tried:
    """Compare a search with the same search without one sentence.

    Args:
        episode: the episode of both searches.
        dataset: of the sentences.
        habit: the sentence.
        told: record of the search with it.
        without: record of the search without it.

    Raises:
        EpisodeError: the records are of other episodes.
    """
    if {told.episode, without.episode} != {episode.id}:
        raise EpisodeError(f"{episode.id}: compared with records of {told.episode} and {without.episode}; a bug")
    return Tried(
        episode=episode.id,
        scene=episode.scene,
        target=episode.target_category,
        habit=habit.habit,
        row=habit.row,
        about=about(episode, dataset, habit.row),
        thing=dataset.entry_of(habit.row).category,
        rank=habit.rank,
        weight=habit.weight,
        changes=told.actions != without.actions,
        success=(told.success, without.success),
        spl=(told.spl, without.spl),
        steps=(told.steps, without.steps),
    )


def about(episode: Episode, dataset: HabitDataset, row: int) -> About:
    """Kind of thing that a sentence is about in an episode."""
    entry = dataset.entry_of(row)
    if entry.category == episode.target_category:
        return "target"
    placement = landmarks(episode).get(entry.id)
    if placement is not None and placement in dataset.habits[row].supports:
        return "beside"
    anchor = place_now(dataset, episode).anchor
    return "anchor" if any(place.anchor == anchor for place in dataset.supports(row)) else "other"


def landmarks(episode: Episode) -> dict[str, int]:
    """Other things near the target: index of the placement in its entry, by the entry that placed the thing."""
    position, out = episode.target_object.position, {}
    for number, (entry, placement) in enumerate(episode.placed_by):
        thing = episode.arrangement.objects[number]
        near = float(np.linalg.norm(np.subtract(thing.position, position))) <= NEAR_M
        if number != episode.target and entry and near:
            out[entry] = placement
    return out


def strongest(found: Iterable[Tried]) -> dict[str, Tried]:
    """The strongest cause of every episode that has one: the largest gain or loss, the first of equal ones."""
    out: dict[str, Tried] = {}
    for one in found:
        held = out.get(one.episode)
        if one.is_cause and (held is None or _size(one) > _size(held)):
            out[one.episode] = one
    return out


def confirmed(one: Tried, others: Sequence[EpisodeRecord]) -> bool:
    """Whether the search gets worse (for a cause that hurts: better) in every other way of not telling the sentence.

    Args:
        one: a cause.
        others: records of its episode with the thing elsewhere, and with its landmark renamed.
    """
    held = (int(one.success[0]), one.spl[0])
    return all((held > _outcome(record)) if one.helps else (held < _outcome(record)) for record in others)


def counts(
    found: Sequence[Tried], episodes: Sequence[str], confirmations: Mapping[str, bool] | None = None
) -> dict[str, dict[str, Any]]:
    """Count causes by what the sentences are about.

    Args:
        found: all sentences that were tried.
        episodes: ids of all episodes, including those without sentences to try.
        confirmations: by episode, whether its strongest cause is confirmed; only where this could be tried.

    Returns:
        By kind, and for ``any``: sentences tried, how many change the search, shares of the episodes (with 95 %
        intervals) in which one helps, in which one hurts, and the difference of both, how many episodes are found, or
        lost, only with it, and how many of the strongest causes are confirmed.
    """
    first = strongest(found).values()
    return {kind: _counts(found, first, episodes, confirmations or {}, kind) for kind in (*ABOUT, "any")}


def _counts(
    found: Iterable[Tried], first: Iterable[Tried], episodes: Sequence[str], known: Mapping[str, bool], kind: str
) -> dict[str, Any]:
    some, best = ([one for one in part if kind in (one.about, "any")] for part in (found, first))
    helped, hurt = {one.episode for one in some if one.helps}, {one.episode for one in some if one.hurts}
    net = mean_interval([(name in helped) - (name in hurt) for name in episodes])
    return {
        "tried": len(some),
        "changes_search": sum(one.changes for one in some),
        "helps": _share(rate_interval([name in helped for name in episodes])),
        "hurts": _share(rate_interval([name in hurt for name in episodes])),
        "helps_less_hurts": _share(net),
        "found_with_it_alone": len({one.episode for one in some if one.gain[0] > 0}),
        "lost_with_it_alone": len({one.episode for one in some if one.gain[0] < 0}),
        "confirmed_helps": _confirmed([one for one in best if one.helps], known),
        "confirmed_hurts": _confirmed([one for one in best if one.hurts], known),
    }


def _confirmed(some: Sequence[Tried], known: Mapping[str, bool]) -> dict[str, int]:
    tested = [one for one in some if one.episode in known]
    return {"confirmed": sum(known[one.episode] for one in tested), "of": len(tested)}


def _share(interval: Interval) -> dict[str, Any]:
    return {"share": round(interval.mean, 6), "ci95": [round(limit, 6) for limit in interval.ci95]}


def _outcome(record: EpisodeRecord) -> tuple[int, float]:
    return int(record.success), record.spl


def _size(one: Tried) -> tuple[int, float]:
    return abs(one.gain[0]), abs(one.gain[1])
