"""Round and leafy fruit and vegetables, told apart by stems, leaves, stripes and florets."""

from __future__ import annotations

from ucon.objects.kit import Kit, shape
from ucon.objects.model import Material
from ucon.objects.palette import BROWN, CREAM, DARKBROWN, ORANGE, RED, RGB, TAN, WHITE, YELLOW, shade

LEAF: RGB = (74, 140, 62)
STEM: RGB = (104, 78, 48)
PLANT = Material.PLANT
WHOLE = ((-0.5, 0.5), (-0.5, 0.5))


def _broccoli(k: Kit) -> None:
    name = k.name
    _florets(k, (206, 216, 150) if name == "broccoli" else LEAF)


def _head_of_leaves(k: Kit) -> None:
    k.ball(*WHOLE, (0, 1), k.color, PLANT)
    k.ball((-0.1, 0.52), (-0.4, 0.3), (0.1, 0.8), shade(k.color, 1.25), PLANT)
    k.ball((-0.4, 0.2), (-0.2, 0.52), (0.15, 0.95), shade(k.color, 0.85), PLANT)
    k.cyl((-0.12, 0.12), (-0.12, 0.12), (0, 0.1), CREAM)


def _ice_block(k: Kit) -> None:
    k.box(*WHOLE, (0, 1), (206, 230, 242), Material.GLASS)
    k.box((-0.3, 0.3), (-0.3, 0.3), (0.98, 1.01), WHITE, Material.GLASS)


def _marshmallow(k: Kit) -> None:
    k.cyl(*WHOLE, (0, 1), (250, 244, 242))


def _mushroom(k: Kit) -> None:
    k.cyl((-0.2, 0.2), (-0.2, 0.2), (0, 0.5), CREAM)
    k.ball(*WHOLE, (0.3, 1.0), (196, 160, 124))


def _half_apple(k: Kit) -> None:
    k.ball((-0.5, 0.5), (-0.5, 0.5), (-1, 0.9), RED)
    k.cyl((-0.46, 0.46), (-0.46, 0.46), (0.0, 0.06), CREAM)
    k.cyl((-0.44, 0.44), (-0.44, 0.44), (0.88, 1.0), (246, 236, 200))


def _walnut(k: Kit) -> None:
    k.ball(*WHOLE, (0, 1), (176, 130, 82), Material.WOOD)
    k.cyl((-0.03, 0.03), (-0.49, 0.49), (0.01, 1.0), (136, 96, 58), None, axis="x")


def _acorn(k: Kit) -> None:
    k.ball(*WHOLE, (0, 0.8), (170, 120, 60))
    k.ball((-0.5, 0.5), (-0.5, 0.5), (0.45, 0.95), DARKBROWN)
    k.cyl((-0.06, 0.06), (-0.06, 0.06), (0.9, 1.0), DARKBROWN)


def _star_anise(k: Kit) -> None:
    for dx, dy in ((0.4, 0), (-0.4, 0), (0, 0.4), (0, -0.4), (0.28, 0.28), (-0.28, -0.28)):
        k.rod((0, 0, 0.5), (dx, dy, 0.5), 0.01, BROWN)


def _any_egg(k: Kit) -> None:
    name = k.name
    color = {"egg": (226, 188, 150), "hard_boiled_egg": (246, 244, 238)}.get(name, (226, 130, 170))
    k.ball(*WHOLE, (0, 1), color)
    if name == "easter_egg":
        k.cyl((-0.14, 0.14), (-0.49, 0.49), (0.02, 0.98), YELLOW, axis="x")
        k.cyl((0.2, 0.3), (-0.43, 0.43), (0.08, 0.92), (90, 160, 220), axis="x")


def _florets(k: Kit, stalk: RGB) -> None:
    k.cyl((-0.16, 0.16), (-0.16, 0.16), (0, 0.55), stalk, PLANT, taper=1.3)
    for x0, y0, z0 in ((-0.5, -0.3, 0.4), (0.0, -0.5, 0.42), (-0.1, 0.0, 0.4), (-0.5, 0.0, 0.45), (-0.28, -0.26, 0.5)):
        k.ball((x0, x0 + 0.55), (y0, y0 + 0.5), (z0, z0 + 0.5), shade(k.color, 0.85 + 0.06 * len(k.parts)), PLANT)


def _heap(k: Kit) -> None:
    color = (104, 60, 130) if k.name == "grape" else k.color
    spots = ((-0.5, -0.5, 0), (0.05, -0.5, 0), (-0.5, 0.05, 0), (0.05, 0.05, 0.05), (-0.25, -0.25, 0.5),
             (-0.5, -0.2, 0.3), (0.05, -0.2, 0.3), (-0.22, 0.1, 0.35))  # fmt: skip
    for i, (x0, y0, z0) in enumerate(spots):
        k.ball((x0, x0 + 0.46), (y0, y0 + 0.46), (z0, z0 + 0.5), shade(color, 0.9 + 0.05 * (i % 3)))
    if k.name == "raspberries":
        k.box((-0.5, 0.5), (-0.5, 0.5), (-0.05, 0.35), (206, 220, 226), Material.GLASS)
    elif k.name in ("grape", "strawberries"):
        k.cyl((-0.04, 0.04), (-0.04, 0.04), (0.85, 1.1), LEAF if k.name == "strawberries" else STEM)


def _pumpkin(k: Kit) -> None:
    for x0, y0 in ((-0.5, -0.3), (-0.1, -0.3), (-0.3, -0.5), (-0.3, -0.1)):
        k.ball((x0, x0 + 0.6), (y0, y0 + 0.6), (0, 0.88), shade(ORANGE, 0.9 + 0.04 * len(k.parts)))
    k.cyl((-0.06, 0.06), (-0.06, 0.06), (0.8, 1.0), (96, 120, 52))


def _strawberry(k: Kit) -> None:
    k.ball(*WHOLE, (0.0, 0.9), RED)
    k.cyl((-0.34, 0.34), (-0.34, 0.34), (0.78, 0.94), LEAF, None, taper=0.3)
    k.cyl((-0.05, 0.05), (-0.05, 0.05), (0.9, 1.0), LEAF)


def _watermelon(k: Kit) -> None:
    k.ball(*WHOLE, (0, 1))
    for i in range(3):
        y0 = -0.26 + 0.22 * i
        k.ball((-0.49, 0.49), (y0, y0 + 0.08), (0.005, 1.005), (28, 70, 34))
    k.ball((-0.2, 0.2), (-0.503, 0.503), (0.3, 0.7), (120, 170, 80))


def _stalked(k: Kit) -> None:
    k.ball(*WHOLE, (0, 0.88))
    k.cyl((-0.03, 0.03), (-0.03, 0.03), (0.82, 1.0), STEM)
    k.box((0.02, 0.22), (-0.05, 0.05), (0.92, 0.95), LEAF)
    if k.name == "apple":
        k.ball((0.1, 0.49), (-0.3, 0.1), (0.3, 0.78), (222, 120, 60))


def _crowned(k: Kit) -> None:
    color = RED if k.name == "pomegranate" else LEAF
    k.ball(*WHOLE, (0, 0.88))
    k.cyl((-0.24, 0.24), (-0.24, 0.24), (0.82, 0.92), color, None, taper=0.4)
    k.cyl((-0.04, 0.04), (-0.04, 0.04), (0.9, 1.0), color)


def _pointed(k: Kit) -> None:
    k.ball((-0.42, 0.42), (-0.5, 0.5), (0, 1))
    k.cyl((-0.5, -0.3), (-0.2, 0.2), (0.3, 0.7), shade(k.color, 0.92), None, axis="x", taper=1.5)
    k.cyl((0.3, 0.5), (-0.3, 0.3), (0.2, 0.8), shade(k.color, 0.92), None, axis="x", taper=0.5)


def _round(k: Kit) -> None:
    k.ball(*WHOLE, (0, 0.94 if k.name == "orange" else 1.0))
    if k.name == "orange":
        k.cyl((-0.08, 0.08), (-0.08, 0.08), (0.9, 1.0), LEAF)
    elif k.name == "avocado":
        k.cyl((0.44, 0.52), (-0.06, 0.06), (0.44, 0.56), STEM, axis="x")
    elif k.name == "vidalia_onion":
        k.cyl((0.42, 0.56), (-0.1, 0.1), (0.4, 0.6), TAN, axis="x", taper=0.3)
    elif k.name == "potato":
        k.ball((-0.1, 0.5), (-0.4, 0.3), (0.2, 1.0), shade(k.color, 0.92))


@shape("food_leafy")
def leafy(k: Kit) -> None:
    """Leaves fanned out from a pale stalk; a salad is a bowl of them."""
    k.unit()
    if k.name in ("basil_leaf", "mint_leaf", "mustard_leaf"):
        k.ball((-0.4, 0.5), (-0.5, 0.5), (0, 1))
        k.rod((-0.5, 0, 0.5), (0.4, 0, 0.9), 0.004, shade(k.color, 0.7))
        return
    stalk = (232, 238, 214) if k.name == "bok_choy" else (190, 60, 70) if k.name == "chard" else (150, 190, 100)
    k.ball((-0.5, 0.1), (-0.2, 0.2), (0.1, 0.7), stalk, PLANT)
    for i, (y0, z0) in enumerate(((-0.5, 0.0), (-0.1, 0.0), (-0.32, 0.25), (-0.5, 0.3), (0.0, 0.3))):
        k.ball(
            (-0.2 + 0.08 * (i % 2), 0.5 - 0.06 * i),
            (y0, y0 + 0.5),
            (z0, z0 + 0.65),
            shade(k.color, 0.8 + 0.1 * (i % 3)),
        )
    if k.name == "salad":
        k.ball((0.0, 0.3), (-0.2, 0.1), (0.6, 1.0), RED)


_ROUND = {
    "broccoli": _broccoli,
    "cauliflower": _broccoli,
    "grape": _heap,
    "raspberries": _heap,
    "blackberry": _heap,
    "raspberry": _heap,
    "candied_yam": _heap,
    "olive": _heap,
    "strawberries": _heap,
    "lettuce": _head_of_leaves,
    "head_cabbage": _head_of_leaves,
    "artichoke": _head_of_leaves,
    "brussels_sprouts": _head_of_leaves,
    "ice": _ice_block,
    "ice_cube": _ice_block,
    "marshmallow": _marshmallow,
    "mushroom": _mushroom,
    "half_apple": _half_apple,
    "walnut": _walnut,
    "acorn": _acorn,
    "star_anise": _star_anise,
    "egg": _any_egg,
    "hard_boiled_egg": _any_egg,
    "easter_egg": _any_egg,
    "pumpkin": _pumpkin,
    "strawberry": _strawberry,
    "watermelon": _watermelon,
    "apple": _stalked,
    "cherry": _stalked,
    "plum": _stalked,
    "peach": _stalked,
    "beefsteak_tomato": _crowned,
    "pomegranate": _crowned,
    "lemon": _pointed,
    "lime": _pointed,
}


@shape("food_sphere")
def round_food(k: Kit) -> None:
    """Balls, told apart by stems, leaves, stripes or florets, and heaps of berries."""
    k.unit()
    _ROUND.get(k.name, _round)(k)
