"""Ways to tell episodes apart: by target, where it is kept, home, kind of home, size of home, and split."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

from ucon.core.errors import UconError
from ucon.evaluation.figures.markdown import area_m2, kind_of_home, size_class
from ucon.evaluation.kept.record import EpisodeRecord


def _size(scene: str) -> str:
    """Class of a home's size; somebody's own home may be kept on another machine."""
    try:
        return size_class(area_m2(scene))
    except UconError:
        return "size not known"


#: The name of an episode's group, by title.
GROUPS: Final[Mapping[str, Callable[[EpisodeRecord], str]]] = {
    "target": lambda r: r.target.replace("_", " "),
    "relation": lambda r: f"{r.relation}{', behind a door' if r.contained else ''}",
    "home": lambda r: r.scene,
    "kind of home": lambda r: kind_of_home(r.scene),
    "size of home": lambda r: _size(r.scene),
    "split": lambda r: r.split.replace("/", ", ").replace("_", " "),
}
