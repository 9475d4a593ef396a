"""Lamps, plants, candles, frames, clocks and statues."""

from __future__ import annotations

from math import cos, pi, sin

from ucon.objects.kit import Kit, shape
from ucon.objects.model import Material
from ucon.objects.palette import (
    BLACK,
    BROWN,
    CREAM,
    DARK,
    DARKBROWN,
    GLASSY,
    GOLD,
    GREEN,
    ORANGE,
    PINK,
    RED,
    RGB,
    SILVER,
    TERRACOTTA,
    WHITE,
    YELLOW,
    shade,
)
from ucon.objects.shapes.cabinets import hang_below

FABRIC = Material.FABRIC
METAL = Material.METAL
PLANT = Material.PLANT
LIGHT: RGB = (250, 236, 190)


@shape("lamp_floor", "lamp_table")
def lamp(k: Kit) -> None:
    """Foot, pole and shade; a lampshade is the shade alone."""
    k.unit()
    if k.name == "lampshade":
        k.cyl((-0.5, 0.5), (-0.5, 0.5), (0, 1), LIGHT, FABRIC, taper=0.6)
        return
    floor = k.name == "floor_lamp"
    low = 0.76 if floor else 0.5
    k.cyl((-0.36, 0.36), (-0.36, 0.36), (0, 0.03 if floor else 0.08), DARK, METAL)
    if floor:
        k.cyl((-0.04, 0.04), (-0.04, 0.04), (0.03, low + 0.05), DARK, METAL)
    else:
        k.ball((-0.3, 0.3), (-0.3, 0.3), (0.06, 0.46), (70, 110, 130))
        k.cyl((-0.06, 0.06), (-0.06, 0.06), (0.4, low + 0.05), GOLD, METAL)
    k.cyl((-0.5, 0.5), (-0.5, 0.5), (low, 1), LIGHT, FABRIC, taper=0.62)


@shape("lantern", "light_garden")
def lantern(k: Kit) -> None:
    """A framed light with a ring on top."""
    k.unit()
    k.box((-0.5, 0.5), (-0.5, 0.5), (0, 0.08), BLACK)
    k.box((-0.36, 0.36), (-0.36, 0.36), (0.08, 0.7), LIGHT, Material.GLASS)
    for sx in (-0.42, 0.42):
        for sy in (-0.42, 0.42):
            k.box((sx - 0.06, sx + 0.06), (sy - 0.06, sy + 0.06), (0.08, 0.7), BLACK)
    k.cyl((-0.5, 0.5), (-0.5, 0.5), (0.7, 0.88), BLACK, None, taper=0.3)
    k.box((-0.12, 0.12), (-0.02, 0.02), (0.88, 1.0), BLACK)


@shape("light_ceiling", "light_wall")
def ceiling_light(k: Kit) -> None:
    """Flat panels, globes on a cord, a chandelier with candles."""
    k.unit()
    if k.name == "chandelier":
        k.cyl((-0.04, 0.04), (-0.04, 0.04), (0.3, 1), GOLD, METAL)
        k.ball((-0.14, 0.14), (-0.14, 0.14), (0.2, 0.5), GOLD, METAL)
        for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1)):
            k.rod((0, 0, 0.3), (dx * 0.44, dy * 0.44, 0.2), 0.02, GOLD, METAL)
            k.cyl((dx * 0.44 - 0.06, dx * 0.44 + 0.06), (dy * 0.44 - 0.06, dy * 0.44 + 0.06), (0.2, 0.5), LIGHT)
        k.box((-0.08, 0.08), (-0.08, 0.08), (0, 0.2), GLASSY, Material.GLASS)
    elif k.name == "room_light":
        k.cyl((-0.02, 0.02), (-0.02, 0.02), (0.4, 1), DARK)
        k.cyl((-0.5, 0.5), (-0.5, 0.5), (0, 0.45), LIGHT, FABRIC, taper=0.5)
    elif k.name == "spotlight":
        k.box((-0.3, 0.3), (-0.5, 0.5), (0.7, 1), BLACK)
        for s in (-0.28, 0.28):
            k.cyl((-0.4, 0.4), (s - 0.16, s + 0.16), (0.1, 0.7), BLACK)
            k.cyl((-0.3, 0.3), (s - 0.12, s + 0.12), (0, 0.1), LIGHT)
    elif k.name == "wall_mounted_light":
        k.box((-0.5, -0.2), (-0.5, 0.5), (0, 1), SILVER, METAL)
        k.cyl((-0.3, 0.5), (-0.4, 0.4), (0.05, 0.95), LIGHT)
    else:
        round_light = k.name == "downlight"
        (k.cyl if round_light else k.box)((-0.5, 0.5), (-0.5, 0.5), (0.3, 1), WHITE)
        (k.cyl if round_light else k.box)((-0.42, 0.42), (-0.42, 0.42), (0, 0.4), LIGHT)


@shape("plant_small")
def plant(k: Kit) -> None:
    """A pot with leaves; cut flowers lie; a cactus stands."""
    k.unit()
    if k.has("cactus"):
        k.cyl((-0.36, 0.36), (-0.36, 0.36), (0, 0.34), TERRACOTTA, None, taper=1.3)
        k.ball((-0.3, 0.3), (-0.3, 0.3), (0.28, 1.0), (70, 136, 74), PLANT)
        k.ball((-0.2, 0.2), (0.14, 0.5), (0.45, 0.8), (80, 148, 82), PLANT)
        k.ball((-0.2, 0.2), (-0.5, -0.16), (0.38, 0.68), (64, 126, 70), PLANT)
    elif k.name in ("bouquet", "flower", "rose") or k.has("daffodil", "marigold"):
        _flowers(k)
    elif k.name == "hanging_plant":
        k.box((-0.02, 0.02), (-0.02, 0.02), (0.6, 1), DARK)
        k.cyl((-0.3, 0.3), (-0.3, 0.3), (0.4, 0.65), (214, 206, 190), None, taper=1.2)
        for x0, y0, z0 in (
            (-0.5, -0.3, 0.1),
            (0.0, -0.5, 0.0),
            (-0.3, 0.05, 0.05),
            (0.05, 0.0, 0.2),
            (-0.4, -0.4, 0.5),
        ):
            k.ball((x0, x0 + 0.45), (y0, y0 + 0.45), (z0, z0 + 0.4), shade(GREEN, 0.85 + 0.05 * len(k.parts)), PLANT)
        hang_below(k, 0.4)
    elif k.name == "weed":
        for dx, dy in ((0.5, 0), (-0.5, 0.1), (0, 0.5), (0.1, -0.5), (0.0, 0.0)):
            k.rod((0, 0, 0), (dx, dy, 1.0 if dx == dy else 0.8), (0.004, 0.02), shade(k.color, 0.9 + dx * 0.2), PLANT)
    else:
        k.cyl((-0.3, 0.3), (-0.3, 0.3), (0, 0.36), TERRACOTTA, None, taper=1.3)
        k.cyl((-0.34, 0.34), (-0.34, 0.34), (0.36, 0.38), (64, 46, 34))
        k.cyl((-0.03, 0.03), (-0.03, 0.03), (0.36, 0.6), BROWN)
        for i, (x0, y0, z0) in enumerate(((-0.5, -0.3, 0.45), (0.0, -0.5, 0.5), (-0.1, 0.0, 0.45), (-0.45, 0.0, 0.55),
                                          (-0.25, -0.28, 0.62))):  # fmt: skip
            k.ball((x0, x0 + 0.5), (y0, y0 + 0.5), (z0, z0 + 0.38), shade(GREEN, 0.8 + 0.1 * i), PLANT)
        if k.has("tomato", "chili"):
            for x0, y0, z0 in ((0.3, -0.1, 0.6), (0.2, 0.25, 0.7), (0.3, -0.35, 0.75)):
                k.ball((x0, x0 + 0.14), (y0, y0 + 0.12), (z0, z0 + 0.14), RED)


def _flowers(k: Kit) -> None:
    """Lying along x: stems at the back, blossoms in front."""
    color = {"rose": RED, "bouquet": PINK, "flower": PINK}.get(k.name, YELLOW if k.has("daffodil") else ORANGE)
    count = 1 if k.name in ("rose", "flower") else 5
    if count == 1:
        k.rod((-0.5, 0.0, 0.3), (0.2, 0.0, 0.5), 0.014, GREEN, PLANT)
        k.ball((-0.3, 0.0), (0.0, 0.4), (0.1, 0.4), GREEN, PLANT)
        k.ball((-0.2, 0.1), (-0.4, 0.0), (0.2, 0.5), (52, 116, 50), PLANT)
        for x0, y0 in ((0.1, -0.5), (0.1, 0.0), (0.0, -0.25), (0.2, -0.25)):
            k.ball((x0, x0 + 0.3), (y0, y0 + 0.5), (0.2, 0.9), shade(color, 0.85 + 0.05 * len(k.parts)))
        k.ball((0.15, 0.4), (-0.2, 0.2), (0.5, 1.0), YELLOW if k.name == "flower" else (150, 20, 30))
        return
    k.rod((-0.5, 0, 0.3), (0.0, 0, 0.5), (0.03, 0.06), GREEN, PLANT)
    k.cyl((-0.25, 0.05), (-0.2, 0.2), (0.1, 0.8), CREAM, Material.PAPER, axis="x", taper=1.8)
    colors = (color, WHITE, shade(color, 0.8), YELLOW, color)
    for i, (y0, z0) in enumerate(((-0.5, 0.1), (-0.2, 0.0), (0.1, 0.1), (-0.35, 0.5), (0.0, 0.5))):
        k.ball((0.1, 0.5), (y0, y0 + 0.4), (z0, z0 + 0.5), colors[i])


@shape("wreath")
def wreath(k: Kit) -> None:
    """A ring of green with red berries; a centrepiece stands, with a candle."""
    k.unit()
    standing = k.name != "centerpiece"  # thin along x, for a wall or a door
    for i in range(9):
        a = 2 * pi * i / 9
        u, v = 0.36 * cos(a), 0.36 * sin(a)
        color = shade(GREEN, 0.85 + 0.1 * (i % 3)) if not standing else (RED if i % 2 else (220, 90, 110))
        if standing:
            k.ball((-0.5, 0.5), (u - 0.15, u + 0.15), (0.5 + v - 0.15, 0.5 + v + 0.15), color, PLANT)
        else:
            k.ball((u - 0.15, u + 0.15), (v - 0.15, v + 0.15), (0, 0.4), color, PLANT)
    if not standing:
        k.cyl((-0.12, 0.12), (-0.12, 0.12), (0, 0.85), CREAM)
        k.cyl((-0.03, 0.03), (-0.03, 0.03), (0.85, 1.0), ORANGE, None, taper=0.2)


@shape("candle")
def candle(k: Kit) -> None:
    """Wax, wick and flame; a holder carries a thin candle."""
    k.unit()
    if k.name == "candle_holder":
        k.cyl((-0.5, 0.5), (-0.5, 0.5), (0, 0.06), SILVER, METAL)
        k.cyl((-0.1, 0.1), (-0.1, 0.1), (0.06, 0.4), SILVER, METAL)
        k.cyl((-0.3, 0.3), (-0.3, 0.3), (0.4, 0.46), SILVER, METAL)
        k.cyl((-0.16, 0.16), (-0.16, 0.16), (0.46, 0.9), CREAM)
        k.cyl((-0.08, 0.08), (-0.08, 0.08), (0.9, 1.0), ORANGE, None, taper=0.2)
        return
    k.cyl((-0.5, 0.5), (-0.5, 0.5), (0, 0.86))
    k.cyl((-0.38, 0.38), (-0.38, 0.38), (0.85, 0.865), shade(k.color, 1.4))
    k.cyl((-0.03, 0.03), (-0.03, 0.03), (0.86, 0.92), BLACK)
    k.cyl((-0.1, 0.1), (-0.1, 0.1), (0.9, 1.0), (250, 170, 50), None, taper=0.15)


@shape("picture_frame_stand")
def picture_frame(k: Kit) -> None:
    """A leaning frame with a photo and a support behind."""
    k.unit()
    k.box((0.1, 0.4), (-0.5, 0.5), (0, 1))
    k.box((0.4, 0.46), (-0.38, 0.38), (0.1, 0.9), (150, 190, 220), Material.PAPER)
    k.box((0.46, 0.48), (-0.38, 0.38), (0.1, 0.36), (90, 140, 80), Material.PAPER)
    k.ball((0.44, 0.5), (-0.12, 0.12), (0.36, 0.62), (226, 180, 150))
    k.rod((-0.5, 0, 0.0), (0.15, 0, 0.7), 0.012, DARKBROWN)


@shape("grandfather_clock")
def grandfather_clock(k: Kit) -> None:
    """A tall case with a dial and a pendulum."""
    k.unit()
    k.box((-0.46, 0.44), (-0.5, 0.5), (0, 0.12), k.color, Material.WOOD)
    k.box((-0.42, 0.38), (-0.4, 0.4), (0.12, 0.62), k.color, Material.WOOD)
    k.box((-0.5, 0.46), (-0.5, 0.5), (0.62, 0.94), k.color, Material.WOOD)
    k.wedge((-0.4, 0.36), (-0.4, 0.4), (0.94, 1.0), k.color, Material.WOOD)
    k.cyl((0.46, 0.5), (-0.36, 0.36), (0.66, 0.92), WHITE, axis="x")
    k.box((0.49, 0.51), (-0.02, 0.02), (0.78, 0.88), BLACK)
    k.box((0.38, 0.42), (-0.26, 0.26), (0.18, 0.58), (60, 44, 36))
    k.cyl((0.42, 0.46), (-0.14, 0.14), (0.22, 0.32), GOLD, METAL, axis="x")
    k.box((0.42, 0.44), (-0.02, 0.02), (0.3, 0.56), GOLD, METAL)


@shape("statue")
def statue(k: Kit) -> None:
    """A figure on a base; a headstone is a slab with a rounded top."""
    k.unit()
    if k.name == "headstone":
        k.box((-0.5, 0.5), (-0.5, 0.5), (0, 0.12), k.color, Material.CONCRETE)
        k.box((-0.25, 0.25), (-0.4, 0.4), (0.12, 0.7), k.color, Material.CONCRETE)
        k.cyl((-0.25, 0.25), (-0.4, 0.4), (0.4, 1.0), k.color, Material.CONCRETE, axis="x")
        k.box((0.25, 0.27), (-0.25, 0.25), (0.4, 0.6), shade(k.color, 0.6))
        return
    k.box((-0.5, 0.5), (-0.5, 0.5), (0, 0.14), shade(k.color, 0.7))
    if k.name == "bust":
        k.wedge((-0.3, 0.0), (-0.5, 0.5), (0.14, 0.46))
        k.wedge((0.0, 0.3), (-0.5, 0.5), (0.14, 0.46), flip=True)
        k.cyl((-0.14, 0.14), (-0.16, 0.16), (0.4, 0.6))
        k.ball((-0.3, 0.32), (-0.3, 0.3), (0.52, 1.0))
        k.ball((0.26, 0.4), (-0.06, 0.06), (0.68, 0.8))
        return
    k.cyl((-0.24, 0.24), (-0.26, 0.26), (0.14, 0.72), None, None, taper=0.8)
    k.ball((-0.2, 0.2), (-0.2, 0.2), (0.72, 1.0))
    for s in (-1, 1):
        k.rod((0, s * 0.24, 0.66), (0.3, s * 0.42, 0.4), 0.02)
