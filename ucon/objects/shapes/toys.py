"""Toys, dolls, homes of pets, and small finds from the garden."""

from __future__ import annotations

from math import cos, pi, sin

from ucon.objects.kit import Kit, shape
from ucon.objects.model import Material
from ucon.objects.palette import BLACK, BLUE, BROWN, CREAM, DARK, GOLD, GREEN, GREY, RED, TAN, WHITE, YELLOW, shade

METAL = Material.METAL

FABRIC = Material.FABRIC
FULL = ((-0.5, 0.5), (-0.5, 0.5))


@shape("doll_soft")
def doll(k: Kit) -> None:
    """Sitting: head with ears or hair, body, arms and legs."""
    k.unit()
    bear = k.name == "teddy_bear"
    fur = (156, 104, 62) if bear else (236, 196, 168)
    body = fur if bear else (226, 96, 150)
    k.ball((-0.36, 0.14), (-0.3, 0.3), (0, 0.62), body, FABRIC)
    k.ball((-0.34, 0.2), (-0.26, 0.26), (0.52, 0.96), fur, FABRIC)
    for s in (-1, 1):
        k.rod((0.0, s * 0.16, 0.1), (0.44, s * 0.32, 0.1), 0.2 * k.size[2], fur, FABRIC, kind="cylinder")
        k.ball((0.3, 0.5), (s * 0.32 - 0.12, s * 0.32 + 0.12), (0, 0.3), shade(fur, 0.9) if bear else WHITE, FABRIC)
        k.rod((-0.1, s * 0.26, 0.5), (0.1, s * 0.46, 0.26), 0.16 * k.size[2], fur, FABRIC, kind="cylinder")
        if bear:
            k.ball((-0.12, 0.02), (s * 0.2 - 0.1, s * 0.2 + 0.1), (0.82, 1.0), shade(fur, 0.85), FABRIC)
        k.ball((0.14, 0.22), (s * 0.1 - 0.03, s * 0.1 + 0.03), (0.74, 0.82), BLACK)
    if bear:
        k.ball((0.1, 0.3), (-0.12, 0.12), (0.58, 0.76), (216, 176, 128), FABRIC)
        k.ball((0.24, 0.32), (-0.04, 0.04), (0.68, 0.76), BLACK)
    else:
        k.ball((-0.42, 0.1), (-0.3, 0.3), (0.62, 1.0), (120, 70, 36), FABRIC)


def _globe(k: Kit) -> None:
    k.cyl((-0.3, 0.3), (-0.3, 0.3), (0, 0.06), BROWN, Material.WOOD)
    k.box((-0.04, 0.04), (-0.04, 0.04), (0.06, 0.2), GOLD, METAL)
    k.ball(*FULL, (0.16, 1.0), (60, 120, 190))
    for x0, y0, z0 in ((0.1, -0.3, 0.5), (0.1, 0.1, 0.3), (-0.2, 0.2, 0.6), (-0.45, -0.3, 0.4), (0.0, -0.2, 0.74)):
        k.ball((x0, x0 + 0.36), (y0, y0 + 0.3), (z0, z0 + 0.24), (80, 150, 80))


def _dice(k: Kit) -> None:
    k.box(*FULL, (0, 1), (246, 244, 240))
    for x0, y0 in ((-0.3, -0.3), (0.14, 0.14), (-0.08, -0.08)):
        k.cyl((x0, x0 + 0.18), (y0, y0 + 0.18), (0.99, 1.01), BLACK)
    for y0, z0 in ((-0.3, 0.14), (0.12, 0.66)):
        k.cyl((0.49, 0.51), (y0, y0 + 0.18), (z0, z0 + 0.18), BLACK, axis="x")
    k.cyl((-0.09, 0.09), (0.49, 0.51), (0.4, 0.6), RED, axis="y")


def _toy_car(k: Kit) -> None:
    k.box((-0.5, 0.5), (-0.46, 0.46), (0.16, 0.56), RED)
    k.box((-0.3, 0.16), (-0.42, 0.42), (0.56, 0.9), (150, 200, 226), Material.GLASS)
    k.box((-0.3, 0.1), (-0.42, 0.42), (0.9, 1.0), RED)
    for fx in (-0.3, 0.3):
        for s in (-1, 1):
            c, d = sorted((s * 0.5, s * 0.36))
            k.cyl((fx - 0.13, fx + 0.13), (c, d), (0, 0.36), BLACK, axis="y")
    for side in (-0.3, 0.3):
        k.cyl((0.49, 0.51), (side - 0.1, side + 0.1), (0.32, 0.5), YELLOW, axis="x")


def _toy_figure(k: Kit) -> None:
    k.box((-0.2, 0.2), (-0.24, 0.24), (0.3, 0.7), BLUE)
    k.ball((-0.24, 0.24), (-0.2, 0.2), (0.64, 1.0), (236, 190, 150))
    for s in (-1, 1):
        k.box((-0.5, 0.5), (s * 0.14 - 0.1, s * 0.14 + 0.1), (0, 0.3), RED)
        k.box((-0.1, 0.12), (s * 0.4 - 0.1, s * 0.4 + 0.1), (0.34, 0.66), YELLOW)


def _hourglass(k: Kit) -> None:
    for x0 in (-0.5, 0.4):
        k.cyl((x0, x0 + 0.1), (-0.5, 0.5), (0, 1), (150, 104, 62), Material.WOOD, axis="x")
    k.cyl((-0.4, 0.0), (-0.4, 0.4), (0.1, 0.9), (226, 200, 140), Material.GLASS, axis="x", taper=0.2)
    k.cyl((0.0, 0.4), (-0.08, 0.08), (0.42, 0.58), (206, 226, 234), Material.GLASS, axis="x", taper=5.0)
    for y0, z0 in ((-0.44, 0.5), (0.4, 0.5)):
        k.box((-0.4, 0.4), (y0, y0 + 0.05), (z0 - 0.03, z0 + 0.03), (150, 104, 62), Material.WOOD)


def _dreidel(k: Kit) -> None:
    k.box(*FULL, (0.3, 0.75), BLUE)
    k.cyl((-0.1, 0.1), (-0.1, 0.1), (0, 0.3), BLUE, None, taper=4.5)
    k.cyl((-0.08, 0.08), (-0.08, 0.08), (0.75, 1.0), TAN)
    k.box((0.49, 0.52), (-0.2, 0.2), (0.4, 0.66), GOLD)


def _seashell(k: Kit) -> None:
    for i in range(5):
        a = -0.8 + 0.4 * i
        tip = (0.4 * cos(a), 0.42 * sin(a), 0.5)
        color = shade((230, 190, 160), 0.9 + 0.06 * i)
        k.rod((-0.44, 0, 0.4), tip, (0.5 * k.size[2], 0.024), color, kind="sphere")
    k.ball((-0.5, 0.3), (-0.3, 0.3), (0, 0.7), (240, 214, 186))


def _blocks(k: Kit) -> None:
    colors = (RED, YELLOW, (60, 120, 200), GREEN)
    k.box((-0.5, 0.0), (-0.5, 0.0), (0, 0.5), colors[0])
    k.box((-0.5, 0.0), (0.0, 0.5), (0, 0.5), colors[1])
    k.box((0.0, 0.5), (-0.3, 0.3), (0, 0.5), colors[2])
    k.box((-0.4, 0.1), (-0.25, 0.25), (0.5, 1.0), colors[3])


def _abacus(k: Kit) -> None:
    for s in (-1, 1):
        c, d = sorted((s * 0.5, s * 0.44))
        k.box((-0.2, 0.2), (c, d), (0.06, 1), (170, 124, 78), Material.WOOD)
    k.box((-0.2, 0.2), (-0.44, 0.44), (0.94, 1), (170, 124, 78), Material.WOOD)
    k.box((-0.5, 0.5), (-0.5, 0.5), (0, 0.06), (170, 124, 78), Material.WOOD)
    for i, color in enumerate((RED, YELLOW, GREEN, BLUE)):
        z0 = 0.16 + 0.2 * i
        k.box((-0.04, 0.04), (-0.44, 0.44), (z0 + 0.04, z0 + 0.07), GREY)
        k.cyl((-0.3, 0.3), (-0.36 + 0.1 * i, 0.1 + 0.1 * i), (z0, z0 + 0.12), color, axis="y")


def _mock_up(k: Kit) -> None:
    k.box(*FULL, (0, 0.06), GREEN)
    k.box((-0.36, 0.36), (-0.4, 0.1), (0.06, 0.6), CREAM)
    k.wedge((-0.42, 0.0), (-0.44, 0.14), (0.6, 1.0), RED)
    k.wedge((0.0, 0.42), (-0.44, 0.14), (0.6, 1.0), RED, flip=True)
    k.box((0.36, 0.38), (-0.24, -0.06), (0.06, 0.4), BROWN)
    k.ball((-0.2, 0.3), (0.2, 0.5), (0.1, 0.6), (60, 130, 60))


def _beach(k: Kit) -> None:
    k.box((-0.5, 0.0), (-0.1, 0.1), (0.2, 0.8), RED)
    k.ball((-0.1, 0.5), (-0.5, 0.5), (0, 1), YELLOW)


_TOYS = {
    "globe": _globe, "dice": _dice, "toy_dice": _dice, "toy_car": _toy_car, "toy_figure": _toy_figure,
    "hourglass": _hourglass, "dreidel": _dreidel, "seashell": _seashell, "toy": _blocks, "alphabet_abacus": _abacus,
    "classroom_mock_up": _mock_up, "beach_toy": _beach,
}  # fmt: skip


@shape("toy_small")
def toy(k: Kit) -> None:
    """Toys and curios."""
    k.unit()
    _TOYS[k.name](k)


@shape("pet_box")
def pet_house(k: Kit) -> None:
    """Bird cage, bird feeder, chicken coop."""
    x, y, z = k.size
    if k.name == "chicken_coop":
        k.box((-x / 2 + 0.1, x / 2 - 0.1), (-y / 2 + 0.1, y / 2 - 0.1), (0.35 * z, 0.4 * z))
        k.box((-x / 2 + 0.1, -x / 2 + 0.14), (-y / 2 + 0.1, y / 2 - 0.1), (0.4 * z, 0.72 * z))
        for s in (-1, 1):
            c, d = sorted((s * (y / 2 - 0.1), s * (y / 2 - 0.14)))
            k.box((-x / 2 + 0.14, x / 2 - 0.1), (c, d), (0.4 * z, 0.72 * z))
            for fx in (-x / 2 + 0.1, x / 2 - 0.16):
                k.box((fx, fx + 0.06), (c, d), (0, 0.35 * z), shade(k.color, 0.7))
        k.wedge((-x / 2, 0.0), (-y / 2, y / 2), (0.72 * z, z), (150, 60, 50))
        k.wedge((0.0, x / 2), (-y / 2, y / 2), (0.72 * z, z), (150, 60, 50), flip=True)
        k.space((-x / 2 + 0.16, x / 2 - 0.12), (-y / 2 + 0.16, y / 2 - 0.16), (0.4 * z, 0.7 * z))
        return
    k.unit()
    if k.name == "birdcage":
        k.cyl(*FULL, (0, 0.08), (90, 140, 180))
        for i in range(8):
            a = 2 * pi * i / 8
            u, v = 0.46 * cos(a), 0.46 * sin(a)
            k.path([(u, v, 0.08), (u, v, 0.7)], 0.008, GOLD, METAL)
        k.cyl((-0.48, 0.48), (-0.48, 0.48), (0.7, 0.92), GOLD, METAL, taper=0.25)
        k.ball((-0.12, 0.12), (-0.1, 0.1), (0.9, 1.0), GOLD, METAL)
        k.ball((-0.14, 0.2), (-0.12, 0.12), (0.25, 0.5), (240, 210, 60))
        k.box((-0.03, 0.03), (-0.44, 0.44), (0.22, 0.26), BROWN, Material.WOOD)
        return
    k.box(*FULL, (0, 0.08), BROWN, Material.WOOD)
    k.box((-0.32, 0.32), (-0.32, 0.32), (0.08, 0.62), (222, 196, 130), Material.GLASS)
    k.wedge((-0.5, 0.0), (-0.5, 0.5), (0.62, 0.94), (150, 60, 50))
    k.wedge((0.0, 0.5), (-0.5, 0.5), (0.62, 0.94), (150, 60, 50), flip=True)
    k.box((-0.06, 0.06), (-0.06, 0.06), (0.9, 1.0), DARK)
    k.cyl((0.3, 0.5), (-0.04, 0.04), (0.12, 0.18), TAN, axis="x")


def _glass_shards(k: Kit) -> None:
    for i, (x0, y0) in enumerate(((-0.5, -0.4), (-0.1, -0.5), (0.0, 0.1), (-0.4, 0.2))):
        k.wedge(
            (x0, x0 + 0.5), (y0, y0 + 0.4), (0, 1 - 0.2 * (i % 2)), (190, 220, 230), Material.GLASS, flip=bool(i % 2)
        )


def _feather(k: Kit) -> None:
    k.ball((-0.2, 0.5), (-0.5, 0.5), (0.2, 0.8), (240, 240, 244))
    k.rod((-0.5, 0, 0.2), (0.4, 0, 0.9), 0.004, (180, 160, 130))


def _leaf(k: Kit) -> None:
    k.ball((-0.5, 0.5), (-0.36, 0.5), (0, 0.9), (80, 150, 60), Material.PLANT)
    k.rod((0, -0.5, 0.5), (0, 0.44, 0.9), 0.004, (120, 90, 50))


def _pebble(k: Kit) -> None:
    k.ball((-0.5, 0.5), (-0.5, 0.5), (0, 1), None, Material.CONCRETE)
    k.ball((-0.4, 0.3), (-0.3, 0.48), (0.1, 0.98), shade(k.color, 1.15), Material.CONCRETE)


def _pellet(k: Kit) -> None:
    for x0, y0, z0 in ((-0.5, -0.5, 0), (0.0, -0.5, 0), (-0.5, 0.0, 0), (0.0, 0.0, 0), (-0.25, -0.25, 0.5)):
        k.cyl((x0, x0 + 0.5), (y0, y0 + 0.5), (z0, z0 + 0.5), shade(k.color, 0.85 + 0.05 * len(k.parts)))


def _bulb(k: Kit) -> None:
    k.ball(*FULL, (0, 0.8), BROWN)
    k.cyl((-0.14, 0.14), (-0.14, 0.14), (0.7, 1.0), (120, 160, 80), None, taper=0.3)


def _cone(k: Kit) -> None:
    for i in range(4):
        r = 0.5 - 0.11 * i
        k.cyl((-r, r), (-r, r), (0.24 * i, 0.24 * i + 0.28), shade(BROWN, 0.9 + 0.08 * (i % 2)), None, taper=0.7)


def _cube(k: Kit) -> None:
    k.box(*FULL, (0, 1), (130, 132, 138), Material.CONCRETE)
    k.box((-0.4, 0.4), (-0.4, 0.4), (0.98, 1.01), (156, 158, 164), Material.CONCRETE)


_SEEDS = {
    "broken_glass": _glass_shards, "feather": _feather, "leaf": _leaf, "pebble": _pebble, "pellet": _pellet,
    "daffodil_bulb": _bulb, "pine_cone": _cone, "whiskey_stone": _cube,
}  # fmt: skip


@shape("seed_tiny")
def garden_bit(k: Kit) -> None:
    """Bulbs, cones, stones, leaves."""
    k.unit()
    _SEEDS[k.name](k)
