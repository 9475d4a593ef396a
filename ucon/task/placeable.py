"""Which placements of an imported dataset the homes can realise, and why the others not.

A placement can be realised where its anchor stands in the entry's home, or can be brought in, and the shapes allow the
relation. Nothing is settled here: a home may still be too full when an episode is sampled.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache

from ucon.core.errors import SceneError
from ucon.habits.official import Located
from ucon.objects.model import Vec3
from ucon.scenes import SCENES
from ucon.sim.cache import load_house
from ucon.sim.house import STRUCTURE
from ucon.sim.placement import Reason, implausible, importable

#: Reason of a placement that only lacks its anchor; every other one says that it can be nowhere.
ABSENT: Reason = "absent_anchor"

_Sizes = dict[str, tuple[Vec3 | None, ...]]


@dataclass(frozen=True, slots=True)
class Unplaced:
    """A placement that cannot be realised: where it is written, a reason that can be counted, a phrase for people."""

    where: str
    reason: Reason
    message: str

    def __str__(self) -> str:
        return f"{self.where}: {self.message} ({self.reason})"


def unplaced(located: Iterable[Located]) -> list[Unplaced]:
    """The placements that cannot be realised in the homes that their entries are bound to."""
    return [found for one in located if (found := _check(one)) is not None]


def _check(one: Located) -> Unplaced | None:
    category, relation, anchor = one.category, one.placement.relation, one.placement.anchor
    try:
        sizes = _sizes(one.scene).get(anchor, ())
    except SceneError as error:
        return Unplaced(one.where, ABSENT, str(error))
    # Without the anchor at hand, its usual size still tells what can be nowhere from what only lacks its anchor.
    refusals = [implausible(category, relation, anchor, size) for size in sizes or (None,)]
    if all(refusals):
        reason, message = next(refusal for refusal in refusals if refusal)
        return Unplaced(one.where, reason, message)
    if not sizes and not importable(anchor):
        return Unplaced(one.where, ABSENT, f"no {anchor} in {one.scene}, and it cannot be brought in")
    return None


@lru_cache(maxsize=len(SCENES))
def _sizes(scene: str) -> _Sizes:
    """Sizes in which each category stands in a home; structure has none."""
    house = load_house(scene)
    found: dict[str, dict[Vec3 | None, None]] = {name: {None: None} for name in STRUCTURE}
    for item in house.spec.items:
        found.setdefault(item.category, {})[item.size] = None
    return {name: tuple(sizes) for name, sizes in found.items()}
