"""Places in English: ``in the fridge``, ``on the dining table``, ``beside the laptop``."""

from __future__ import annotations

from typing import Final

from ucon.sim.cache import load_house
from ucon.task.episode import Episode

_WORDS: Final = {"inside": "in", "ontop": "on", "imported": "on", "under": "under", "nextto": "beside"}
_STRUCTURE: Final = {"floors": "floor", "walls": "wall", "ceilings": "ceiling"}


def spoken_place(relation: str, anchor: str) -> str:
    """A placement as an English phrase.

    Args:
        relation: one of the four relations, or ``imported``.
        anchor: category of the anchor.
    """
    return f"{_WORDS[relation]} the {_STRUCTURE.get(anchor, anchor).replace('_', ' ')}"


def target_place(episode: Episode) -> str:
    """Where the target of an episode is kept, in English.

    Raises:
        UconError: its home cannot be loaded.
    """
    house, placed = load_house(episode.scene), episode.target_object
    added = placed.anchor - house.n_instances
    anchor = house.categories[placed.anchor] if added < 0 else episode.arrangement.objects[added].category
    return spoken_place(placed.relation, anchor)
