"""What people carry, wear as jewellery, and keep on the bathroom shelf."""

from __future__ import annotations

from math import cos, pi, sin

from ucon.objects.kit import Kit, shape
from ucon.objects.model import Material
from ucon.objects.palette import (
    BLACK,
    BLUE,
    BROWN,
    COPPER,
    DARK,
    DARKBROWN,
    GOLD,
    GREEN,
    GREY,
    ORANGE,
    RED,
    SILVER,
    WHITE,
    shade,
)
from ucon.objects.shapes.generic import torus

METAL = Material.METAL
SHEET = Material.PAPER
FABRIC = Material.FABRIC
FULL = ((-0.5, 0.5), (-0.5, 0.5))


def _keys(k: Kit) -> None:
    torus(k, 0.2, 0.06, (0.2, 0.6), SILVER, METAL, count=6)
    for dx, dy in ((0.45, 0.1), (0.3, -0.42), (0.35, 0.45)):
        k.rod((0.12, dy * 0.3, 0.4), (dx, dy, 0.3), (0.008, 0.014), GOLD, METAL)
    k.box((-0.5, -0.15), (-0.24, 0.24), (0, 1), RED)


def _coin(k: Kit) -> None:
    """A pile of three thick coins: a single coin of true thickness could not be seen."""
    color = COPPER if k.name == "penny" else SILVER
    for i, (dx, dy) in enumerate(((0.04, 0.0), (-0.04, 0.03), (0.02, -0.04))):
        span = (0.34 * i, 0.34 * i + 0.3)
        k.cyl((-0.44 + dx, 0.44 + dx), (-0.44 + dy, 0.44 + dy), span, shade(color, 1 - 0.12 * (i % 2)), METAL)
        k.cyl((-0.38 + dx, 0.38 + dx), (-0.38 + dy, 0.38 + dy), (span[1], span[1] + 0.04), shade(color, 0.6), METAL)


def _wallet(k: Kit) -> None:
    k.box((-0.5, 0.5), (-0.5, 0.5), (0, 0.46), k.color)
    k.box((-0.44, 0.44), (-0.44, 0.5), (0.46, 0.56), GREEN)
    k.box((-0.5, 0.5), (-0.5, 0.46), (0.56, 1.0), shade(k.color, 0.85))


def _bank_card(k: Kit) -> None:
    k.box(*FULL, (0, 0.8), k.color)
    k.box((0.2, 0.36), (-0.5, 0.5), (0.8, 1.0), BLACK)
    k.box((-0.2, 0.02), (-0.36, -0.16), (0.8, 1.0), GOLD)


def _note(k: Kit) -> None:
    k.box(*FULL, (0, 0.8), (120, 164, 116), SHEET)
    k.cyl((-0.3, 0.3), (-0.16, 0.16), (0.8, 1.0), (206, 222, 196), SHEET)


def _collar(k: Kit) -> None:
    torus(k, 0.44, 0.1, (0, 0.7), RED)
    k.cyl((0.38, 0.5), (-0.1, 0.1), (0, 1), GOLD, METAL, axis="x")


def _lighter(k: Kit) -> None:
    k.box((-0.5, 0.5), (-0.5, 0.3), (0, 1), RED)
    k.box((-0.5, 0.5), (0.3, 0.5), (0.1, 0.9), SILVER, METAL)


def _cigarette(k: Kit) -> None:
    k.cyl((-0.5, 0.1), (-0.5, 0.5), (0, 1), WHITE, axis="x")
    k.cyl((0.1, 0.5), (-0.5, 0.5), (0, 1), ORANGE, axis="x")


def _pipe(k: Kit) -> None:
    k.cyl((0.1, 0.5), (-0.5, 0.5), (0, 1.0), BROWN, Material.WOOD)
    k.cyl((0.16, 0.44), (-0.3, 0.3), (0.96, 1.01), BLACK)
    k.rod((-0.5, 0, 0.6), (0.2, 0, 0.3), 0.01, BLACK)


_POCKET = {
    "key_chain": _keys, "nickel": _coin, "penny": _coin, "quarter": _coin, "wallet": _wallet, "credit_card": _bank_card,
    "money": _note, "dog_collar": _collar, "lighter": _lighter, "cigarette": _cigarette, "tobacco_pipe": _pipe,
}  # fmt: skip


@shape("wallet")
def pocket_thing(k: Kit) -> None:
    """What people carry in pockets."""
    k.unit()
    _POCKET[k.name](k)


@shape("glasses")
def glasses(k: Kit) -> None:
    """Two lenses and two temples."""
    k.unit()
    lens = (40, 44, 50) if k.name == "sunglasses" else (180, 206, 220)
    for s in (-1, 1):
        c, d = sorted((s * 0.48, s * 0.06))
        k.cyl((0.38, 0.5), (c, d), (0, 1), lens, Material.GLASS, axis="x")
        k.box((-0.5, 0.4), (s * 0.48 - 0.03, s * 0.48 + 0.03), (0.6, 0.8), BLACK)
        k.box((0.36, 0.42), (c, d), (0.8, 1.0), BLACK)
    k.box((0.4, 0.46), (-0.1, 0.1), (0.6, 0.8), BLACK)


def _ring(k: Kit) -> None:
    torus(k, 0.36, 0.2, (0, 0.5), GOLD, METAL)
    if k.name == "ring":
        k.ball((0.1, 0.5), (-0.2, 0.2), (0.3, 1.0), (190, 226, 240), Material.GLASS)


def _necklace(k: Kit) -> None:
    torus(k, 0.42, 0.06, (0, 0.8), GOLD, METAL, count=10)
    k.ball((0.36, 0.5), (-0.1, 0.1), (0, 1.0), (200, 50, 70))


def _watch(k: Kit) -> None:
    torus(k, 0.4, 0.16, (0, 0.6), DARKBROWN)
    k.cyl((0.1, 0.5), (-0.34, 0.34), (0.2, 1.0), SILVER, METAL)
    k.cyl((0.16, 0.44), (-0.24, 0.24), (0.98, 1.02), WHITE)


def _gem(k: Kit) -> None:
    color = {"jade": (70, 160, 110), "pearl": (244, 238, 228)}.get(k.name, (190, 226, 240))
    if k.name == "diamond":
        k.cyl((-0.1, 0.1), (-0.1, 0.1), (0, 0.6), color, Material.GLASS, taper=5.0)
        k.cyl(*FULL, (0.6, 1.0), shade(color, 1.3), Material.GLASS, taper=0.6)
    else:
        k.ball(*FULL, (0, 1), color)
        k.ball((0.1, 0.36), (-0.2, 0.1), (0.55, 0.9), shade(color, 1.5))


def _bow(k: Kit) -> None:
    k.ball((-0.5, -0.02), (-0.5, 0.5), (0, 1), RED, FABRIC)
    k.ball((0.02, 0.5), (-0.5, 0.5), (0, 1), RED, FABRIC)
    k.ball((-0.12, 0.12), (-0.3, 0.3), (0.1, 0.9), (150, 20, 30), FABRIC)


def _snow_globe(k: Kit) -> None:
    k.cyl((-0.45, 0.45), (-0.45, 0.45), (0, 0.25), DARKBROWN, Material.WOOD)
    k.ball(*FULL, (0.16, 1.0), (196, 224, 240), Material.GLASS)
    k.cyl((0.2, 0.49), (-0.2, 0.2), (0.3, 0.75), (60, 130, 70), None, taper=0.2)


_JEWELS = {
    "ring": _ring, "bracelet": _ring, "necklace": _necklace, "watch": _watch, "diamond": _gem, "jade": _gem,
    "pearl": _gem, "bow": _bow, "snow_globe": _snow_globe,
}  # fmt: skip


@shape("jewelry_tiny")
def jewel(k: Kit) -> None:
    """Jewellery, enlarged where it would be too small to see."""
    k.unit()
    _JEWELS[k.name](k)


def _toothbrush(k: Kit) -> None:
    k.box((-0.5, 0.5), (-0.4, 0.4), (0, 0.5), BLUE)
    k.box((0.28, 0.48), (-0.5, 0.5), (0.5, 1.0), WHITE)


def _toilet_paper(k: Kit) -> None:
    k.cyl(*FULL, (0, 1), (246, 244, 240), SHEET)
    k.cyl((-0.18, 0.18), (-0.18, 0.18), (0.99, 1.01), (150, 120, 90), SHEET)


def _lipstick(k: Kit) -> None:
    k.cyl(*((-0.5, 0.5), (-0.5, 0.1)), (0, 1), BLACK, axis="y")
    k.cyl((-0.42, 0.42), (0.1, 0.26), (0.08, 0.92), GOLD, METAL, axis="y")
    k.cyl((-0.34, 0.34), (0.26, 0.5), (0.16, 0.84), RED, axis="y", taper=0.7)


def _razor(k: Kit) -> None:
    k.box((-0.5, 0.3), (-0.16, 0.16), (0.2, 0.6), (60, 130, 190))
    k.box((0.26, 0.5), (-0.5, 0.5), (0, 1), SILVER, METAL)
    k.box((0.49, 0.51), (-0.4, 0.4), (0.3, 0.6), DARK)


def _inhaler(k: Kit) -> None:
    k.box((-0.5, 0.5), (-0.5, -0.1), (0, 0.9), BLUE)
    k.cyl((-0.4, 0.3), (-0.1, 0.5), (0.05, 0.95), SILVER, METAL, axis="y")
    k.box((0.2, 0.5), (-0.5, -0.2), (0, 1), (150, 190, 230))


def _bandage(k: Kit) -> None:
    k.cyl((-0.5, 0.5), (-0.5, 0.5), (0, 1), (236, 212, 184), FABRIC, axis="x")
    k.cyl((-0.51, 0.51), (-0.2, 0.2), (0.3, 0.7), (200, 60, 60), axis="x")


def _clipper(k: Kit) -> None:
    k.box((-0.5, 0.4), (-0.5, 0.5), (0, 0.5), SILVER, METAL)
    k.rod((-0.45, 0, 0.95), (0.36, 0, 0.5), (0.004, 0.012), GREY, METAL)
    k.box((0.4, 0.5), (-0.5, 0.5), (0.1, 0.7), SILVER, METAL)


def _denture(k: Kit) -> None:
    for z0 in (0.0, 0.52):
        k.cyl(*FULL, (z0, z0 + 0.48), (226, 120, 130))
        k.box((0.3, 0.5), (-0.36, 0.36), (z0 + 0.14, z0 + 0.36), WHITE)


def _diaper(k: Kit) -> None:
    k.box((-0.5, 0.5), (-0.5, 0.5), (0, 0.7), WHITE, FABRIC)
    k.ball((-0.4, 0.4), (-0.44, 0.44), (0.2, 1.0), (244, 246, 248), FABRIC)
    for s in (-1, 1):
        k.box((0.2, 0.44), (s * 0.4 - 0.1, s * 0.4 + 0.1), (0.7, 0.9), (130, 180, 220), FABRIC)


def _loofah(k: Kit) -> None:
    k.ball(*FULL, (0, 0.8))
    for i in range(4):
        a = 2 * pi * i / 4
        k.ball(
            (0.3 * cos(a) - 0.2, 0.3 * cos(a) + 0.2),
            (0.3 * sin(a) - 0.2, 0.3 * sin(a) + 0.2),
            (0.2, 0.7),
            shade(k.color, 1.2),
        )
    k.box((-0.02, 0.02), (-0.12, 0.12), (0.75, 1.0), WHITE)


def _soap_dish(k: Kit) -> None:
    k.box(*FULL, (0, 0.5), WHITE)
    for s in (-1, 1):
        k.box((s * 0.46 - 0.04, s * 0.46 + 0.04), (-0.5, 0.5), (0.5, 1.0), WHITE)
        k.box((-0.42, 0.42), (s * 0.47 - 0.03, s * 0.47 + 0.03), (0.5, 1.0), WHITE)
    k.box((-0.3, 0.3), (-0.3, 0.3), (0.5, 0.6), (200, 206, 210))


_TOILETRIES = {
    "toothbrush": _toothbrush, "toilet_paper": _toilet_paper, "lipstick": _lipstick, "razor": _razor,
    "inhaler": _inhaler, "bandage": _bandage, "clipper": _clipper, "denture": _denture, "diaper": _diaper,
    "loofah": _loofah, "soap_dish": _soap_dish,
}  # fmt: skip


@shape("toiletry_small")
def toiletry(k: Kit) -> None:
    """Small things from the bathroom shelf."""
    k.unit()
    _TOILETRIES[k.name](k)
