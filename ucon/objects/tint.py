"""Colours and materials of categories, and their seeded colour variants."""

from __future__ import annotations

from ucon.core.rng import stream
from ucon.objects.catalogue import Hints
from ucon.objects.model import Category, Material
from ucon.objects.palette import RGB

_WOODS: tuple[RGB, ...] = (
    (168, 122, 76),
    (120, 82, 52),
    (196, 158, 112),
    (88, 60, 42),
    (226, 222, 212),
    (146, 98, 60),
)
_FABRICS: tuple[RGB, ...] = (
    (128, 130, 136),
    (70, 84, 110),
    (190, 176, 152),
    (112, 72, 60),
    (86, 104, 84),
    (150, 60, 58),
)
_FABRIC_ARCHETYPES = frozenset(
    {
        *("sofa", "blanket", "pillow", "mattress", "carpet", "ottoman", "curtain", "cloth_flat", "clothing_flat"),
        *("doll_soft", "glove_pair", "hammock", "backpack", "tent", "infant_seat"),
    }
)
_MATERIAL_OF_COLOR = {
    "wood": Material.WOOD,
    "darkwood": Material.WOOD,
    "silver": Material.METAL,
    "copper": Material.METAL,
    "gold": Material.METAL,
    "transparent": Material.GLASS,
    "brick": Material.TILE,
}
_MATERIAL_OF_GROUP = {
    "stationery": Material.PAPER,
    "book": Material.PAPER,
    "clothing": Material.FABRIC,
    "textile": Material.FABRIC,
}


def material_of(row: Category, hints: Hints) -> Material:
    """Material of the body of a category.

    Args:
        row: of the catalogue.
        hints: give the name of its colour.
    """
    if row.archetype in _FABRIC_ARCHETYPES:
        return Material.FABRIC
    if row.archetype in ("tree", "plant_small", "food_leafy"):
        return Material.PLANT
    by_color = _MATERIAL_OF_COLOR.get(hints.color_name)
    return by_color if by_color is not None else _MATERIAL_OF_GROUP.get(row.semantic_group, Material.PLAIN)


def tinted(row: Category, tint: int) -> RGB:
    """Colour of a variant: furniture and fabrics change their colour, other things only their brightness.

    Args:
        row: of the catalogue.
        tint: number of the variant; 0 is the catalogue's colour.
    """
    if tint == 0:
        return row.color
    random = stream(tint, "tint", row.name)
    color = row.color
    furniture = row.role in ("movable_furniture", "fixed_furniture") and row.semantic_group in ("furniture", "textile")
    if furniture:
        palette = _FABRICS if row.archetype in _FABRIC_ARCHETYPES | {"chair"} else _WOODS
        color = palette[int(random.integers(len(palette)))]
    factor = 0.9 + 0.2 * float(random.random())
    r, g, b = (max(0, min(255, round(v * factor))) for v in color)
    return r, g, b
