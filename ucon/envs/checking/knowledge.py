"""Checks of what an agent is given: the habits of its level, the target, and nothing privileged."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields, is_dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ucon.envs.checking.contract import WALK, without_target
from ucon.envs.checking.findings import Finding, difference, same
from ucon.envs.checking.subject import Subject, choice, core, reset, step

_LEVELS: Final = ("none", "gt", "retrieval", "full")
#: Keys that would hold privileged facts.
_NAMES: Final = ("privileged", "solution", "scene", "target_instance", "arrangement", "locations", "placed_by")


def habits(subject: Subject) -> Finding:
    """The habits given are those of the habit level, in observation and info.

    Compared at four levels with the environment without a wrapper. ``habits_mask`` must be 1 exactly at habits' rows.
    """
    expected, counts = "exactly the habits of the level, padded with -1, the mask 1 where there is one", []
    for level in _LEVELS:
        env, ours = subject.make(habit_level=level), core(subject.reference(habit_level=level))
        told = reset(env, 0)
        right = reset(ours, 0)
        rows = tuple(right.info["habit_rows"])
        if tuple(told.info["habits"]) != tuple(right.info["habits"]) or tuple(told.info["habit_rows"]) != rows:
            given = len(told.info["habits"])
            return Finding("habits", False, expected, f"{given} at level {level}, not the {len(rows)} of that level")
        if told.info["habit_level"] != level:
            return Finding("habits", False, expected, f"habit_level {told.info['habit_level']} instead of {level}")
        if "habit_table" in dir(env.unwrapped) and np.asarray(told.obs["habits"]).ndim == 1:
            given_rows, mask = np.asarray(told.obs["habits"]), np.asarray(told.obs["habits_mask"])
            if tuple(given_rows[given_rows >= 0].tolist()) != rows or not np.array_equal(mask == 1, given_rows >= 0):
                n = int((given_rows >= 0).sum())
                found = f"{n} rows and a mask of {int(mask.sum())} for {len(rows)} at level {level}"
                return Finding("habits", False, expected, found)
        counts.append(f"{level} {len(rows)}")
    return Finding("habits", True, expected, ", ".join(counts))


def target(subject: Subject) -> Finding:
    """The target given is the episode's, its category in info and its embedding in the observation."""
    env, ours = subject.make(), subject.reference()
    for episode in (0, 1, 2):
        told, right = reset(env, episode), reset(ours, episode)
        if told.info["target"] != right.info["target"] or not same(told.obs["target"], right.obs["target"]):
            found = f"{told.info['target']}, or another embedding, instead of {right.info['target']}"
            return Finding("target", False, "the episode's category and its embedding", found)
    return Finding("target", True, "the episode's category and its embedding", "as expected in 3 episodes")


def no_secrets(subject: Subject) -> Finding:
    """Observation and info hold no privileged fact: scene, solution, instance or position of the target.

    Searches keys and values, in two episodes and up to four steps.
    """
    expected = "neither scene, solution, instance nor position of the target"
    env = subject.make()
    for episode in (0, 1):
        seen, ours = reset(env, episode), core(env)
        first = ours.episode
        texts = {first.scene, first.solution}
        box = ours.search.world.boxes[ours.search.target]
        centre = (box[:3] + box[3:]) / 2
        places = [np.asarray(first.target_object.position, float), centre]
        for number in range(4):
            for where, value in (*_parts(seen.obs, "obs"), *_parts(seen.info, "info")):
                last = where.rsplit(".", 1)[-1]
                if last in _NAMES or (isinstance(value, str) and (value in texts or first.scene in value)):
                    return Finding("secrets", False, expected, f"{where} = {str(value)[:40]!r}")
                if _is_place(value, places, ours):
                    return Finding("secrets", False, expected, f"{where} = {value}, the target's position")
                if last.endswith("instance") and np.ndim(value) == 0:
                    return Finding("secrets", False, expected, f"{where} = {value}")
            if seen.over:
                break
            seen = step(env, choice(seen, number) if subject.chooses else WALK[number])
    return Finding("secrets", True, expected, "none of them")


def unseen_target(subject: Subject) -> Finding:
    """With the target moved far below the floor, everything is the same until the target would have been seen.

    Otherwise an observation, reward or info depends on a target that the agent cannot see.
    """
    expected, compared = "the same observations, rewards and infos until the target is seen", 0
    envs = [subject.make() for _ in range(2)]
    known = subject.episodes()
    for number in (0, 2, 4):
        episode = known[number % len(known)]
        a, b = (reset(env, e) for env, e in zip(envs, (episode, without_target(episode)), strict=True))
        shown = _shown_since_now(envs[0])
        for turn in range(len(WALK)):
            if shown() or a.over:
                break
            if not same(tuple(a), tuple(b)):
                found = f"{difference(a.obs, b.obs)} of the observation, {difference(a.info, b.info)} of info differ"
                return Finding("unseen target", False, expected, found)
            compared += 1
            action = choice(a, turn) if subject.chooses else WALK[turn]
            a, b = (step(env, action) for env in envs)
    return Finding("unseen target", compared > 3, expected, f"as expected at {compared} steps")


def _shown_since_now(env: Any) -> Callable[[], bool]:
    """A function that says whether the target had a pixel in any frame since this call, also between two choices.

    A single pixel of the target can hide what is behind it, although it is too few for the target to count as seen.
    """
    inner = core(env)
    search, saw = inner.search, inner.search.saw
    shown = [bool(search.counts[search.target])]

    def note(counts: NDArray[np.int32]) -> None:
        saw(counts)
        shown[0] |= bool(counts[search.target])

    search.saw = note  # type: ignore[method-assign]
    return lambda: shown[0] or bool(search.counts[search.target]) or _was_seen(inner)


def _was_seen(inner: Any) -> bool:
    """Whether the target counted as seen at any step."""
    ledger: Any = inner.ledger
    return ledger is not None and ledger.first_seen_step >= 0


def _parts(value: Any, where: str) -> Iterator[tuple[str, Any]]:
    """Every leaf of nested data, with its path of keys."""
    if isinstance(value, Mapping):
        for name, part in value.items():
            yield from _parts(part, f"{where}.{name}")
        if not value:
            yield where, value
    elif is_dataclass(value) and not isinstance(value, type):
        for part in fields(value):
            yield from _parts(getattr(value, part.name), f"{where}.{part.name}")
    elif isinstance(value, tuple | list) and value and not all(isinstance(v, int | float) for v in value):
        for part in value:
            yield from _parts(part, where)
    else:
        yield where, value


def _is_place(value: Any, places: list[Any], ours: Any) -> bool:
    """Whether a value is two or three numbers that are the target's position, in the world or in the start frame."""
    if isinstance(value, str) or np.ndim(value) != 1 or len(value) not in (2, 3):
        return False
    try:
        told = np.asarray(value, float)
    except (TypeError, ValueError):
        return False
    start, grid = ours.episode.start, ours.search.world.house.grid
    origin = grid.xy((start.i, start.j))
    for place in places:
        c, s = np.cos(start.heading * np.pi / 2), np.sin(start.heading * np.pi / 2)
        dx, dy = place[:2] - origin
        own = np.array([c * dx + s * dy, c * dy - s * dx, place[2]])
        if any(np.abs(told - frame[: len(told)]).max() < 1e-2 for frame in (np.asarray(place), own)):
            return True
    return False
