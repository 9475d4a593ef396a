"""Bread, pastry, meat, fish, sweets and dishes."""

from __future__ import annotations

from math import cos, pi, sin

from ucon.objects.kit import (
    BROWN,
    CREAM,
    DARKBROWN,
    ORANGE,
    RED,
    TAN,
    WHITE,
    YELLOW,
    Kit,
    shade,
    shape,
)  # fmt: skip
from ucon.objects.model import Material

WHOLE = ((-0.5, 0.5), (-0.5, 0.5))


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
