"""Which placements of an imported dataset can be realised in the homes, and why the others cannot.

Where the placements were tried in simulation, the recorded verdicts decide. Otherwise shapes decide: a placement can be
realised if its anchor is in the entry's home or can be added, and the shapes allow the relation. Nothing is simulated
then, so a home may still turn out to be too full when an episode is sampled.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Final, Literal, cast

from ucon.core.errors import ConfigError, SceneError
from ucon.habits.official import Located
from ucon.habits.verdicts import NEVER_SEEN, Triple, Verdicts
from ucon.objects.model import Relation, Vec3
from ucon.scenes import SCENES
from ucon.sim.cache import load_house
from ucon.sim.house import STRUCTURE
from ucon.sim.placement import implausible, importable

Group = Literal["implausible", "absent_anchor", "never_seen"]
#: Reason of a placement whose anchor is missing.
ABSENT: Final = "absent_anchor"

_PHRASES: Final = {
    "no_free_slot": "no free room there by any {anchor} of {scene}",
    "blocks_path": "by every {anchor} of {scene} it would stand in the way",
    "unstable": "it does not come to rest there by any {anchor} of {scene}",
    "too_large": "it is too large for every {anchor} of {scene}",
    "not_a_support": "no {anchor} of {scene} has a level surface on top",
    "not_a_container": "no {anchor} of {scene} has a space inside",
    "no_room_under": "there is no space under any {anchor} of {scene}",
    NEVER_SEEN: "placed, but nobody in reach can see it there by any {anchor} of {scene}",
    ABSENT: "no {anchor} in {scene}, and it cannot be brought in",
}

_Sizes = dict[str, tuple[Vec3 | None, ...]]


@dataclass(frozen=True, slots=True)
class Unplaced:
    """A placement that cannot be realised.

    Attributes:
        where: file and line.
        reason: a key, for counting.
        message: the reason as text.
    """

    where: str
    reason: str
    message: str

    @property
    def group(self) -> Group:
        """The reason's group: the anchor is absent, the object is never seen, or the placement is implausible."""
        return cast(Group, self.reason) if self.reason in (ABSENT, NEVER_SEEN) else "implausible"

    def __str__(self) -> str:
        return f"{self.where}: {self.message} ({self.reason})"


def unplaced(located: Iterable[Located], verdicts: Verdicts | None = None) -> list[Unplaced]:
    """The placements that cannot be realised in the homes that their entries are bound to.

    Args:
        located: placements with their file and line.
        verdicts: results of trying them; None decides by shapes.
    """
    found = []
    for one in located:
        triple: Triple = (one.category, one.placement.relation, one.placement.anchor)
        refused = _by_shape(one.scene, triple) if verdicts is None else _by_trial(one.scene, triple, verdicts)
        if refused is not None:
            found.append(Unplaced(one.where, *refused))
    return found


def counted(located: Sequence[Located], rest: Iterable[Unplaced]) -> dict[str, int]:
    """Count placements by verdict.

    Args:
        located: all placements.
        rest: those that cannot be realised.

    Returns:
        ``placed``, ``imported`` (those of them whose anchor is added), ``implausible``, ``absent_anchor``,
        ``never_seen``.
    """
    groups = {one.where: one.group for one in rest}
    placed = [one for one in located if one.where not in groups]
    counts = {"placed": len(placed), "imported": sum(one.placement.anchor not in _sizes(one.scene) for one in placed)}
    names: tuple[Group, ...] = ("implausible", "absent_anchor", "never_seen")
    return counts | {name: sum(group == name for group in groups.values()) for name in names}


def refusal(scene: str, triple: Triple) -> str | None:
    """Key of the reason why a home cannot realise a placement, by shapes; None where it can.

    Args:
        scene: name of the home.
        triple: category, relation, anchor.
    """
    refused = _by_shape(scene, triple)
    return refused and refused[0]


def _by_trial(scene: str, triple: Triple, verdicts: Verdicts) -> tuple[str, str] | None:
    """Reason and message by the recorded verdict for this home; by shapes where it was not tried there."""
    verdict, shape = verdicts.of.get(triple), _by_shape(scene, triple)
    if verdict is None or scene not in SCENES:
        return shape
    reason = verdict.refused.get(scene)
    if reason is None:
        return None
    if shape is not None and shape[0] != ABSENT:
        return shape  # its message is more specific
    reason = ABSENT if reason == "not_importable" else reason
    return reason, _PHRASES.get(reason, "refused by every {anchor} of {scene}").format(anchor=triple[2], scene=scene)


def _by_shape(scene: str, triple: Triple) -> tuple[str, str] | None:
    """Reason and message by shapes; None where the placement can be realised."""
    category, relation, anchor = triple
    try:
        sizes = _sizes(scene).get(anchor, ())
    except (ConfigError, SceneError) as error:
        return ABSENT, str(error)
    # If the home lacks the anchor, its usual size still tells implausible placements from those lacking an anchor.
    refusals = [implausible(category, cast(Relation, relation), anchor, size) for size in sizes or (None,)]
    if all(refusals):
        return next(refusal for refusal in refusals if refusal)
    if not sizes and not importable(anchor):
        return ABSENT, _PHRASES[ABSENT].format(anchor=anchor, scene=scene)
    return None


@lru_cache(maxsize=len(SCENES))
def _sizes(scene: str) -> _Sizes:
    """Sizes of each category's items in a home; structure has no size (None)."""
    house = load_house(scene)
    found: dict[str, dict[Vec3 | None, None]] = {name: {None: None} for name in STRUCTURE}
    for item in house.spec.items:
        found.setdefault(item.category, {})[item.size] = None
    return {name: tuple(sizes) for name, sizes in found.items()}
