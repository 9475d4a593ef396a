"""Fruit, vegetables, meat, bread and dishes."""

from __future__ import annotations

from itertools import pairwise
from math import cos, pi, sin

from ucon.objects.kit import (
    BROWN,
    CREAM,
    DARKBROWN,
    DARKGREEN,
    ORANGE,
    RED,
    RGB,
    TAN,
    WHITE,
    YELLOW,
    Kit,
    shade,
    shape,
)  # fmt: skip
from ucon.objects.model import Material

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


def _one_banana(k: Kit) -> None:
    _banana(k, 0.0, 0.0, 1.0)


def _bunch_of_bananas(k: Kit) -> None:
    for i in range(3):
        _banana(k, (i - 1) * 0.3, 0.12 * (i % 2), 0.6)


def _bell_pepper(k: Kit) -> None:
    k.ball((-0.5, 0.4), (-0.5, 0.1), (0, 0.95))
    k.ball((-0.5, 0.4), (-0.1, 0.5), (0, 0.95), shade(k.color, 0.92))
    k.cyl((0.34, 0.55), (-0.08, 0.08), (0.5, 0.66), LEAF, axis="x")


def _pineapple(k: Kit) -> None:
    k.ball((-0.5, 0.2), (-0.5, 0.5), (0, 1), (196, 146, 62))
    for i in range(3):
        x0 = -0.36 + 0.2 * i
        k.cyl((x0, x0 + 0.03), (-0.46, 0.46), (0.04, 0.96), (146, 100, 44), axis="x")
    for dy, dz in ((0, 0.5), (-0.3, 0.8), (0.3, 0.8), (0.0, 0.95), (0, 0.2)):
        k.rod((0.14, 0, 0.5), (0.5, dy, dz), 0.02, DARKGREEN, PLANT)


def _asparagus(k: Kit) -> None:
    x, y, _ = k.size
    _bundle(k, x >= y)


def _pear(k: Kit) -> None:
    k.ball((-0.5, 0.15), (-0.5, 0.5), (0, 1))
    k.ball((-0.15, 0.42), (-0.3, 0.3), (0.2, 0.8))
    k.cyl((0.38, 0.5), (-0.04, 0.04), (0.45, 0.55), STEM, axis="x")


def _sweet_corn(k: Kit) -> None:
    k.ball((-0.45, 0.45), (-0.3, 0.5), (0.05, 1.0), (240, 200, 70))
    k.ball((-0.5, 0.2), (-0.5, 0.1), (0, 0.8), (120, 170, 80), PLANT)
    k.ball((-0.2, 0.5), (-0.5, 0.05), (0, 0.85), (104, 154, 70), PLANT)


def _clove(k: Kit) -> None:
    name = k.name
    k.ball(*WHOLE, (0, 0.9), (236, 230, 216) if name == "garlic_clove" else None)
    k.cyl((-0.1, 0.1), (-0.1, 0.1), (0.7, 1.0), LEAF if name == "chili" else TAN, None, taper=0.3)


def _butternut_squash(k: Kit) -> None:
    k.ball((-0.5, 0.05), (-0.5, 0.5), (0, 1))
    k.cyl((-0.2, 0.44), (-0.32, 0.32), (0.18, 0.82), None, None, axis="x")
    k.cyl((0.42, 0.5), (-0.08, 0.08), (0.4, 0.6), STEM, axis="x")


def _any_root(k: Kit) -> None:
    x, y, _ = k.size
    _root(k, x >= y)


def _banana(k: Kit, y0: float, z0: float, width: float) -> None:
    """Bent in the plane of the table: three segments with dark ends."""
    w = 0.16 * width + 0.06
    points = [(-0.48, 0.3), (-0.2, -0.12), (0.16, -0.2), (0.44, 0.22)]
    t = 0.8 * min(k.size[2] * (1.0 if width > 0.9 else 0.4), 0.05)
    for (ax, ay), (bx, by) in pairwise(points):
        ay, by = y0 + ay * 0.8, y0 + by * 0.8
        k.rod((ax, ay, z0 + 0.4), (bx, by, z0 + 0.4), t, YELLOW, None, kind="cylinder")
    end = points[-1]
    k.rod((end[0], y0 + end[1] * 0.8, z0 + 0.4), (end[0] + 0.04, y0 + end[1] * 0.8 + w, z0 + 0.42), t * 0.4, STEM)


def _bundle(k: Kit, along_x: bool) -> None:
    tip = {"green_onion": (240, 240, 226), "celery": (150, 190, 90), "asparagus": (70, 104, 66)}.get(k.name, k.color)
    for i in range(3):
        side = -0.34 + 0.34 * i
        span = (side - 0.16, side + 0.16)
        z = (0, 1) if i == 1 else (0, 0.85)
        color = shade(k.color, 0.9 + 0.08 * i)
        if along_x:
            k.cyl((-0.5, 0.3), span, z, color, PLANT, axis="x")
            k.cyl((0.28, 0.5), span, z, tip, PLANT, axis="x", taper=0.5 if k.name != "celery" else 1.0)
        else:
            k.cyl(span, (-0.5, 0.3), z, color, PLANT, axis="y")
            k.cyl(span, (0.28, 0.5), z, tip, PLANT, axis="y", taper=0.4)


def _root(k: Kit, along_x: bool) -> None:
    """A tapering body with a green or brown end."""
    end = {"carrot": LEAF, "eggplant": LEAF, "beet": LEAF, "chili_pepper": LEAF, "baguette": None, "pickle": None}
    color = end.get(k.name, STEM)
    taper = {"carrot": 0.3, "chili_pepper": 0.2, "beet": 0.2}.get(k.name)
    axis = "x" if along_x else "y"

    def span(low: float, high: float, half: float, z: tuple[float, float], what: RGB | None, shrink: float) -> None:
        a, b = ((low, high), (-half, half)) if along_x else ((-half, half), (low, high))
        k.cyl(a, b, z, what, None, axis=axis, taper=shrink)

    if taper is not None:
        span(-0.3, 0.5, 0.5, (0, 1), None, taper)
        span(-0.5, -0.28, 0.3, (0.2, 0.8), color, 1.0)
        return
    ends = (-0.5, 0.5) if color is None else (-0.5, 0.42)
    if along_x:
        k.ball(ends, (-0.5, 0.5), (0, 1))
        k.cyl((-0.32, 0.26), (-0.46, 0.46), (0.03, 0.97), None, None, axis="x")
    else:
        k.ball((-0.5, 0.5), ends, (0, 1))
        k.cyl((-0.46, 0.46), (-0.32, 0.26), (0.03, 0.97), None, None, axis="y")
    if color is not None:
        span(0.38, 0.5, 0.2, (0.36, 0.64), color, 0.7)
    if k.name == "baguette":
        for i in range(4):
            y0 = -0.3 + 0.17 * i
            k.box((-0.3, 0.3), (y0, y0 + 0.05), (0.9, 1.0), (236, 206, 150))


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


@shape("food_disc_small")
def biscuit(k: Kit) -> None:
    """Round biscuits with chips; a portion of fries; a wafer bar."""
    k.unit()
    if k.name == "french_fries":
        k.box((-0.4, 0.4), (-0.45, 0.45), (0, 0.55), RED)
        for i in range(7):
            y0 = -0.42 + 0.12 * i
            x0 = -0.2 + 0.2 * (i % 3)
            k.box((x0 - 0.08, x0 + 0.08), (y0, y0 + 0.1), (0.4, 0.8 + 0.1 * ((i * 2) % 3)), (240, 206, 96))
        return
    if k.name == "wafer":
        k.box(*WHOLE, (0, 0.3), (226, 186, 120))
        k.box((-0.46, 0.46), (-0.49, 0.49), (0.3, 0.6), DARKBROWN)
        k.box(*WHOLE, (0.6, 1), (226, 186, 120))
        return
    k.cyl(*WHOLE, (0, 0.8))
    dots = {
        "chocolate_chip_cookie": DARKBROWN,
        "sugar_cookie": WHITE,
        "spice_cookie": TAN,
        "pepperoni": (230, 140, 120),
    }
    color = dots.get(k.name, shade(k.color, 0.6))
    for x0, y0 in ((-0.3, -0.2), (0.1, -0.3), (-0.1, 0.1), (0.2, 0.15), (-0.34, 0.2)):
        k.cyl((x0, x0 + 0.16), (y0, y0 + 0.16), (0.7, 1.0), color)


@shape("food_sausage")
def sausage(k: Kit) -> None:
    """Two or three links side by side."""
    k.unit()
    x, y, _ = k.size
    for i in range(2):
        side = (-0.5, 0.02) if i == 0 else (-0.02, 0.5)
        if x >= y:
            k.ball((-0.5, 0.5), side, (0, 1), shade(k.color, 1 - 0.1 * i))
            k.cyl(
                (-0.34, 0.34),
                (side[0] + 0.02, side[1] - 0.02),
                (0.03, 0.97),
                shade(k.color, 1 - 0.1 * i),
                None,
                axis="x",
            )
        else:
            k.ball(side, (-0.5, 0.5), (0, 1), shade(k.color, 1 - 0.1 * i))
            k.cyl(
                (side[0] + 0.02, side[1] - 0.02),
                (-0.34, 0.34),
                (0.03, 0.97),
                shade(k.color, 1 - 0.1 * i),
                None,
                axis="y",
            )


@shape("food_tiny")
def sweets(k: Kit) -> None:
    """Candy cane, lollipop, bait."""
    k.unit()
    if k.name == "lollipop":
        k.cyl((0.1, 0.5), (-0.5, 0.5), (0, 1), RED)
        k.cyl((0.2, 0.4), (-0.24, 0.24), (0.9, 1.05), WHITE)
        k.box((-0.5, 0.14), (-0.06, 0.06), (0.3, 0.6), WHITE)
    elif k.name == "candy_cane":
        for i in range(5):
            x0 = -0.5 + 0.17 * i
            k.box((x0, x0 + 0.17), (-0.5, -0.2), (0, 1), RED if i % 2 else WHITE)
        k.box((0.35, 0.5), (-0.5, 0.3), (0, 1), RED)
        k.box((0.2, 0.5), (0.2, 0.5), (0, 1), WHITE)
    else:
        k.ball((-0.5, 0.3), (-0.5, 0.5), (0, 1))
        k.wedge((0.25, 0.5), (-0.4, 0.4), (0, 0.9), RED, flip=True)


def _bird(k: Kit) -> None:
    roast = (190, 122, 62)
    k.ball((-0.5, 0.36), (-0.4, 0.4), (0, 1), roast)
    for s in (-1, 1):
        k.rod(
            (0.0, s * 0.3, 0.4),
            (0.42, s * 0.24, 0.55),
            0.28 * k.size[2],
            shade(roast, 0.9),
            kind="cylinder",
            taper=0.5,
        )
        k.ball((0.38, 0.5), (s * 0.24 - 0.08, s * 0.24 + 0.08), (0.46, 0.66), CREAM)
        c, d = sorted((s * 0.5, s * 0.3))
        k.ball((-0.3, 0.1), (c, d), (0.25, 0.7), shade(roast, 0.94))


def _drumstick(k: Kit) -> None:
    k.ball((-0.5, 0.15), (-0.5, 0.5), (0, 1), (186, 116, 58))
    k.cyl((0.0, 0.44), (-0.2, 0.2), (0.25, 0.7), (196, 130, 72), None, axis="x", taper=0.6)
    k.ball((0.36, 0.5), (-0.16, 0.16), (0.3, 0.7), CREAM)


def _small_cake(k: Kit) -> None:
    name = k.name
    k.cyl(
        (-0.36, 0.36),
        (-0.36, 0.36),
        (0, 0.5),
        (236, 226, 206) if name == "muffin" else (120, 170, 200),
        None,
        taper=1.25,
    )
    k.ball(*WHOLE, (0.35, 0.9), (226, 140, 170) if name == "cupcake" else (150, 96, 52))
    k.ball((-0.12, 0.12), (-0.12, 0.12), (0.82, 1.0), RED if name == "cupcake" else DARKBROWN)


def _flat_pie(k: Kit) -> None:
    name = k.name
    k.cyl(*WHOLE, (0, 0.8), (206, 150, 84))
    k.cyl((-0.44, 0.44), (-0.44, 0.44), (0.8, 0.9), (236, 180, 80))
    for x0, y0 in ((-0.3, -0.1), (0.1, -0.3), (0.05, 0.1), (-0.2, 0.2), (-0.05, -0.12)):
        k.cyl((x0, x0 + 0.16), (y0, y0 + 0.16), (0.9, 1.0), (190, 50, 40) if name == "pizza" else (220, 160, 70))


def _bagel(k: Kit) -> None:
    for i in range(8):
        a = 2 * pi * i / 8
        k.ball((0.32 * cos(a) - 0.18, 0.32 * cos(a) + 0.18), (0.32 * sin(a) - 0.18, 0.32 * sin(a) + 0.18), (0, 1),
               (196, 140, 80))  # fmt: skip


def _croissant(k: Kit) -> None:
    for i, (x0, half) in enumerate(((-0.3, 0.2), (-0.12, 0.3), (0.1, 0.3), (0.3, 0.2))):
        k.ball((x0 - 0.2, x0 + 0.2), (-half + 0.1 * abs(i - 1.5), half), (0, 0.75 + 0.25 * (i in (1, 2))),
               (206 - 12 * (i % 2), 146, 76))  # fmt: skip


def _hamburger(k: Kit) -> None:
    k.ball(*WHOLE, (0.3, 1), (206, 146, 80))
    k.cyl(*WHOLE, (0.38, 0.5), (92, 56, 36))
    k.cyl((-0.5, 0.5), (-0.5, 0.5), (0.32, 0.4), (90, 160, 70))
    k.cyl((-0.46, 0.46), (-0.46, 0.46), (0, 0.32), (206, 146, 80))


def _hotdog(k: Kit) -> None:
    k.ball((-0.5, -0.02), (-0.46, 0.46), (0, 0.9), (214, 160, 96))
    k.ball((0.02, 0.5), (-0.46, 0.46), (0, 0.9), (214, 160, 96))
    k.ball((-0.24, 0.24), (-0.5, 0.5), (0.25, 1.0), (180, 70, 50))
    k.box((-0.04, 0.04), (-0.36, 0.36), (0.95, 1.02), YELLOW)


def _waffle(k: Kit) -> None:
    k.box((-0.5, 0.5), (-0.5, 0.5), (0, 0.6), (206, 150, 80))
    for i in range(4):
        t = -0.5 + 0.3 * i
        k.box((t, t + 0.1), (-0.5, 0.5), (0.6, 1.0), (180, 122, 58))
        k.box((-0.5, 0.5), (t, t + 0.1), (0.6, 1.0), (180, 122, 58))


def _skewer(k: Kit) -> None:
    k.box((-0.5, 0.5), (-0.05, 0.05), (0.45, 0.55), TAN)
    for i, color in enumerate(((140, 80, 50), (90, 150, 60), (200, 60, 40), (140, 80, 50), (236, 200, 80))):
        x0 = -0.34 + 0.15 * i
        k.box((x0, x0 + 0.13), (-0.5, 0.5), (0, 1), color)


def _pretzel(k: Kit) -> None:
    for i in range(7):
        a = 2 * pi * (i + 0.5) / 8
        k.ball((0.36 * cos(a) - 0.13, 0.36 * cos(a) + 0.13), (0.36 * sin(a) - 0.13, 0.36 * sin(a) + 0.13), (0, 1),
               (150, 90, 44))  # fmt: skip
    k.rod((-0.3, 0.2, 0.5), (0.3, -0.1, 0.5), 0.025, (150, 90, 44))
    k.rod((-0.3, -0.2, 0.5), (0.3, 0.1, 0.5), 0.025, (160, 98, 50))


def _bun(k: Kit) -> None:
    k.ball(*WHOLE, (-0.4, 1.0))
    k.box((-0.36, 0.36), (-0.03, 0.03), (0.9, 0.99), shade(k.color, 1.3))


@shape("food_slab")
def slab_food(k: Kit) -> None:
    """Meat, fish, cheese, bread and cake."""
    k.unit()
    name = k.name
    if name in ("bacon", "brisket", "lamb", "steak", "pork_chop", "ham_hock", "virginia_ham"):
        _meat(k)
    elif name in ("trout", "salmon"):
        _fish(k)
    elif name in ("shrimp", "crab", "clam", "oyster"):
        _seafood(k)
    elif name in ("bread_slice", "toast", "french_toast"):
        k.box((-0.5, 0.3), (-0.46, 0.46), (0, 1), (150, 96, 52))
        k.ball((0.0, 0.5), (-0.5, 0.5), (0, 1), (150, 96, 52))
        k.box((-0.44, 0.34), (-0.4, 0.4), (0.02, 1.03), (238, 212, 160) if name != "toast" else (214, 160, 96))
    elif name in ("swiss_cheese", "cheddar"):
        (k.wedge if name == "cheddar" else k.box)((-0.5, 0.5), (-0.5, 0.5), (0, 1))
        for x0, y0 in ((-0.3, -0.2), (0.1, 0.1), (0.2, -0.36)):
            if name == "swiss_cheese":
                k.cyl((x0, x0 + 0.2), (y0, y0 + 0.2), (0.98, 1.02), (206, 160, 60))
    elif name in ("butter", "feta", "paraffin_wax", "pizza_dough", "white_chocolate"):
        _block(k)
    elif name == "club_sandwich":
        for i, color in enumerate(((222, 180, 116), (90, 160, 70), (230, 130, 120), (240, 210, 90), (222, 180, 116))):
            k.box((-0.5, 0.5), (-0.5, 0.5), (0.2 * i, 0.2 * i + 0.2), color)
    elif name == "sushi":
        k.cyl(*WHOLE, (0, 0.9), (30, 44, 34))
        k.cyl((-0.42, 0.42), (-0.42, 0.42), (0.9, 0.95), WHITE)
        k.cyl((-0.16, 0.16), (-0.16, 0.16), (0.95, 1.0), ORANGE)
    else:
        layers = {"tiramisu": (CREAM, BROWN), "lasagna": (RED, YELLOW), "brownie": (DARKBROWN, (50, 30, 20)),
                  "fruitcake": (BROWN, RED), "half_apple_pie": (TAN, (190, 130, 70))}  # fmt: skip
        low, high = layers.get(name, (k.color, shade(k.color, 1.2)))
        k.box(*WHOLE, (0, 0.6), low)
        k.box((-0.48, 0.48), (-0.48, 0.48), (0.6, 0.9), high)
        k.box((-0.3, 0.2), (-0.3, 0.3), (0.9, 1.0), shade(high, 0.85))


def _meat(k: Kit) -> None:
    fat = (240, 220, 206)
    if k.name == "bacon":
        for i in range(5):
            y0 = -0.5 + 0.2 * i
            k.box((-0.5, 0.5), (y0, y0 + 0.2), (0, 1 - 0.1 * (i % 2)), (170, 50, 46) if i % 2 == 0 else fat)
    elif k.name in ("ham_hock", "virginia_ham"):
        k.ball((-0.5, 0.3), (-0.5, 0.5), (0, 1), (206, 120, 110))
        k.cyl((-0.36, -0.1), (-0.44, 0.44), (0.06, 0.94), (220, 150, 136), axis="x")
        k.cyl((0.2, 0.5), (-0.12, 0.12), (0.36, 0.64), CREAM, axis="x")
    else:
        color = (
            (160, 50, 46)
            if k.name in ("steak", "lamb")
            else (210, 130, 120)
            if k.name == "pork_chop"
            else (120, 70, 46)
        )
        k.ball((-0.5, 0.5), (-0.5, 0.5), (-0.5, 1.0), fat)
        k.ball((-0.4, 0.46), (-0.44, 0.44), (-0.4, 1.04), color)
        k.cyl((-0.3, -0.12), (-0.1, 0.1), (0.8, 1.0), CREAM)


def _fish(k: Kit) -> None:
    if k.name == "salmon":
        k.box((-0.5, 0.5), (-0.5, 0.5), (0, 0.3), (150, 150, 156))
        k.box((-0.5, 0.5), (-0.48, 0.48), (0.3, 1.0), (236, 130, 96))
        for i in range(3):
            x0 = -0.3 + 0.25 * i
            k.box((x0, x0 + 0.03), (-0.48, 0.48), (0.98, 1.01), (250, 190, 160))
        return
    k.ball((-0.3, 0.5), (-0.5, 0.5), (0, 1), (130, 140, 140), Material.METAL)
    k.box((-0.5, -0.34), (-0.42, 0.42), (0.3, 0.6), (104, 112, 112))
    k.rod((-0.4, 0, 0.5), (-0.2, 0, 0.5), (0.012, 0.02), (120, 128, 128))
    k.ball((0.34, 0.4), (-0.3, 0.3), (0.6, 0.9), (20, 20, 20))


def _seafood(k: Kit) -> None:
    if k.name == "crab":
        k.ball((-0.3, 0.3), (-0.32, 0.32), (0, 1), (210, 80, 46))
        for s in (-1, 1):
            for i in range(2):
                k.rod((-0.1 + 0.14 * i, s * 0.25, 0.4), (-0.2 + 0.14 * i, s * 0.5, 0.1), 0.012, (190, 66, 40))
            k.rod((0.2, s * 0.25, 0.4), (0.4, s * 0.4, 0.5), 0.016, (210, 80, 46))
            k.ball((0.3, 0.52), (s * 0.34 - 0.12, s * 0.34 + 0.12), (0.2, 0.8), (226, 96, 60))
    elif k.name == "shrimp":
        for i, (x0, y0) in enumerate(((-0.3, 0.2), (-0.1, -0.1), (0.15, -0.1), (0.3, 0.2))):
            k.ball((x0 - 0.2, x0 + 0.2), (y0 - 0.3, y0 + 0.3), (0, 1 - 0.1 * i), (240, 150 - 10 * (i % 2), 130))
    else:
        k.ball(*WHOLE, (0, 1), k.color)
        k.ball((-0.4, 0.4), (-0.4, 0.4), (0.3, 1.02), shade(k.color, 1.4))


def _block(k: Kit) -> None:
    if k.name == "pizza_dough":
        k.ball(*WHOLE, (-0.4, 1.0), (238, 222, 186))
    elif k.name == "butter":
        k.box((-0.5, 0.5), (-0.5, 0.5), (0, 0.9), (248, 226, 120))
        k.box((-0.5, 0.5), (-0.5, -0.1), (-0.0, 1.0), (222, 226, 232), Material.PAPER)
    elif k.name == "white_chocolate":
        k.box(*WHOLE, (0, 0.7), (244, 230, 196))
        for i in range(3):
            for j in range(2):
                k.box(
                    (-0.45 + 0.48 * j, -0.05 + 0.48 * j),
                    (-0.46 + 0.32 * i, -0.18 + 0.32 * i),
                    (0.7, 1.0),
                    (250, 240, 212),
                )
    else:
        k.box(*WHOLE, (0, 1))
        k.box((-0.4, 0.4), (-0.4, 0.4), (0.99, 1.01), shade(k.color, 0.9))


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
    """Balls with what tells them apart: stems, leaves, stripes, florets, heaps of berries."""
    k.unit()
    _ROUND.get(k.name, _round)(k)


_LONG = {
    "banana": _one_banana,
    "bunch_of_bananas": _bunch_of_bananas,
    "bell_pepper": _bell_pepper,
    "pineapple": _pineapple,
    "asparagus": _asparagus,
    "green_bean": _asparagus,
    "green_onion": _asparagus,
    "celery": _asparagus,
    "pea_pod": _asparagus,
    "pear": _pear,
    "sweet_corn": _sweet_corn,
    "garlic_clove": _clove,
    "date": _clove,
    "chili": _clove,
    "butternut_squash": _butternut_squash,
}


@shape("food_long")
def long_food(k: Kit) -> None:
    """Things that are long: along x or along y, whichever is longer."""
    k.unit()
    _LONG.get(k.name, _any_root)(k)


_LUMPS = {
    "chicken": _bird,
    "turkey": _bird,
    "duck": _bird,
    "chicken_wing": _drumstick,
    "chicken_thigh": _drumstick,
    "turkey_leg": _drumstick,
    "quail_leg": _drumstick,
    "cupcake": _small_cake,
    "muffin": _small_cake,
    "pizza": _flat_pie,
    "quiche": _flat_pie,
    "cheese_tart": _flat_pie,
    "bagel": _bagel,
    "croissant": _croissant,
    "hamburger": _hamburger,
    "hotdog": _hotdog,
    "waffle": _waffle,
    "kabob": _skewer,
    "kebab": _skewer,
    "pretzel": _pretzel,
}


@shape("food_lump")
def lump(k: Kit) -> None:
    """Bread, pastry, poultry and dishes."""
    k.unit()
    _LUMPS.get(k.name, _bun)(k)
