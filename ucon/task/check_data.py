"""Checks of an episode's data that do not depend on its home.

Shipped files are checked against SHA-256; these checks are for episodes that people write themselves.
"""

from __future__ import annotations

import math
from typing import Any

from ucon.core.errors import ConfigError, EpisodeError, brief
from ucon.core.text import is_shown
from ucon.objects.catalogue import catalogue
from ucon.objects.model import RELATIONS
from ucon.sim.arrangement import PlacedObject
from ucon.task.rules import task_rules

_TEXTS = ("id", "scene", "home_hash", "habits", "habits_hash", "task", "split", "solution")


def check_data(episode: Any, where: str) -> None:
    """Refuse an episode whose data cannot be right in any home.

    Args:
        episode: an :class:`ucon.task.episode.Episode` (not in the signature: that module imports this one).
        where: names file and line in the error.

    Raises:
        EpisodeError: names the first wrong field and what was expected.
    """
    for name in _TEXTS:
        value = getattr(episode, name)
        expect(_is_text(value), where, name, value, "a text")
    try:
        task_rules(episode.task)
    except ConfigError as error:
        raise EpisodeError(f"{where}: {error}") from None
    objects = episode.arrangement.objects
    expect(_is_index(episode.target, len(objects)), where, "target", episode.target, f"an index below {len(objects)}")
    expect(len(episode.placed_by) == len(objects), where, "placed_by", len(episode.placed_by), f"{len(objects)} of it")
    expect(not episode.solution.strip("0123456"), where, "solution", episode.solution, "digits 0 to 6")
    length = episode.shortest_path_m
    expect(_is_number(length) and length > 0, where, "shortest_path_m", length, "metres above 0")
    expect(episode.start.heading in range(4), where, "start heading", episode.start.heading, "0 to 3")
    expect(isinstance(episode.seed, int), where, "seed", episode.seed, "a whole number")
    for name in ("entries", "task_entries"):
        ids = getattr(episode, name)
        right = isinstance(ids, tuple) and len(ids) > 0 and all(map(_is_text, ids))
        expect(right, where, name, ids, "at least one entry; its habits are all")
    origins = episode.placed_by
    right = all(isinstance(o, tuple) and len(o) == 2 and _is_text(o[0]) and type(o[1]) is int for o in origins)
    expect(right, where, "placed_by", origins, "an entry and a number for each object")
    context = episode.context
    if context is not None:
        right = _is_text(context.asker) and (context.occasion is None or _is_text(context.occasion))
        expect(right, where, "context", context, "an asker and an occasion that are texts")
    for number, placed in enumerate(objects):
        check_object(placed, f"{where}: object {number}")
    same = [o.category for o in objects].count(episode.target_category)
    expect(same == 1, where, f"number of {episode.target_category}", same, "1, since it is to be found")


def check_object(placed: PlacedObject, where: str) -> None:
    """Check one placed object."""
    if placed.category not in catalogue():
        try:
            catalogue()[placed.category]
        except ConfigError as error:
            raise EpisodeError(f"{where}: {error}") from None
    what = placed.category
    expect(_are_numbers(placed.position, 3), where, f"position of {what}", placed.position, "x, y, z in metres")
    quat = placed.quat_xyzw
    unit = _are_numbers(quat, 4) and abs(math.hypot(*quat) - 1) < 1e-3
    expect(unit, where, f"quat_xyzw of {what}", quat, "a unit quaternion x, y, z, w")
    known = (*RELATIONS, "imported")
    expect(placed.relation in known, where, f"relation of {what}", placed.relation, f"one of {', '.join(known)}")
    for name in ("room", "anchor", "tint", "holder", "compartment"):
        value = getattr(placed, name)
        expect(isinstance(value, int) and value >= -1, where, f"{name} of {what}", value, "a whole number")


def expect(right: bool, where: str, what: str, found: Any, expected: str) -> None:
    """Check one property of an episode.

    Args:
        right: whether it holds.
        where: names file and line, or the episode.
        what: the field.
        found: its value.
        expected: what it should be.

    Raises:
        EpisodeError: where ``right`` is False.
    """
    if not right:
        raise EpisodeError(
            f"{where}: {what} {brief(repr(found))}, expected {expected}; restore or make the episodes again"
        )


def _is_text(value: Any) -> bool:
    return isinstance(value, str) and is_shown(value)


def _is_index(value: Any, count: int) -> bool:
    return isinstance(value, int) and 0 <= value < count


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def _are_numbers(values: Any, count: int) -> bool:
    return isinstance(values, tuple) and len(values) == count and all(map(_is_number, values))
