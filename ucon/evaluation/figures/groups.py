"""Ways to group episodes: by target and where it is kept, by home, by split, and by what may make habits pay off."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from typing import Final

from ucon.core.errors import UconError
from ucon.evaluation.figures.markdown import area_m2, kind_of_home, size_class
from ucon.evaluation.figures.subsets import by_common_sense, by_variety
from ucon.evaluation.kept.record import EpisodeRecord


def _size(scene: str) -> str:
    """Class of a home's size; not known for a user's own home that is kept on another machine."""
    try:
        return size_class(area_m2(scene))
    except UconError:
        return "size not known"


#: By title of a grouping: gives the name of a record's group.
GROUPS: Final[Mapping[str, Callable[[EpisodeRecord], str]]] = {
    "target": lambda r: r.target.replace("_", " "),
    "relation": lambda r: f"{r.relation}{', behind a door' if r.contained else ''}",
    "home": lambda r: r.scene,
    "kind of home": lambda r: kind_of_home(r.scene),
    "size of home": lambda r: _size(r.scene),
    "split": lambda r: r.split.replace("/", ", ").replace("_", " "),
    "variety among households": by_variety,
    "common sense": by_common_sense,
}

#: Groupings by what may make habits pay off.
PAYS: Final = {name: GROUPS[name] for name in ("variety among households", "common sense", "size of home")}


def names_of(group: Callable[[EpisodeRecord], str], runs: Sequence[Sequence[EpisodeRecord]]) -> list[str]:
    """Names of the groups that have episodes in every run, sorted by their first number, then by name.

    Args:
        group: gives the name of a record's group.
        runs: records of each run.
    """
    return sorted(set.intersection(*({group(r) for r in run} for run in runs)), key=in_order)


def in_order(name: str) -> tuple[int, str]:
    """Sort key of a group: by its first number (``40-70 m2``), then by name."""
    number = re.search(r"\d+", name)
    return int(number[0]) if number else 0, name
