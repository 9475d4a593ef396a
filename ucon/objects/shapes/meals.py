"""Bread, pastry, poultry, sausages, sweets and dishes."""

from __future__ import annotations

from math import cos, pi, sin

from ucon.objects.kit import Kit, shape
from ucon.objects.palette import CREAM, DARKBROWN, RED, TAN, WHITE, YELLOW, shade

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
