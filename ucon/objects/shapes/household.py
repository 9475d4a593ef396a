"""Lamps, plants, textiles, music, sports and decoration."""

from __future__ import annotations

from math import cos, pi, sin

from ucon.objects.kit import (
    BLACK,
    BROWN,
    CREAM,
    DARK,
    DARKBROWN,
    GLASSY,
    GOLD,
    GREEN,
    GREY,
    ORANGE,
    PINK,
    RED,
    RGB,
    SILVER,
    TAN,
    TERRACOTTA,
    WHITE,
    YELLOW,
    Kit,
    shade,
    shape,
)  # fmt: skip
from ucon.objects.model import Material
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


@shape("pillow")
def pillow(k: Kit) -> None:
    """A soft cushion with seams at its corners."""
    k.unit()
    k.ball((-0.5, 0.5), (-0.5, 0.5), (0, 1))
    k.box((-0.44, 0.44), (-0.44, 0.44), (0.25, 0.75))
    k.box((-0.48, 0.48), (-0.48, 0.48), (0.42, 0.56), shade(k.color, 0.85))
    x, y, z = k.size
    k.surface((-x * 0.15, x * 0.15), (-y * 0.15, y * 0.15), z)


@shape("blanket")
def blanket(k: Kit) -> None:
    """Folded in layers; a quilt shows its patches."""
    x, y, z = k.size
    for i in range(3):
        inset = 0.006 * i
        layer = (i * z / 3, (i + 1) * z / 3 - 0.002 * (i < 2))
        width = (-y / 2 + inset, y / 2 - inset)
        k.box((-x / 2 + inset, x / 2 - 0.01 * (i % 2)), width, layer, shade(k.color, (0.88, 1.0, 0.94)[i]))
    k.box((x / 2 - 0.012, x / 2), (-y / 2 + 0.01, y / 2 - 0.01), (0, z * 0.66), shade(k.color, 0.8))
    if k.name == "quilt":
        for i in range(3):
            y0 = (-0.42 + 0.29 * i) * y
            k.box(
                (-x * 0.4, x * 0.4),
                (y0, y0 + 0.14 * y),
                (z - 0.002, z),
                ((220, 200, 150), (190, 90, 90), WHITE)[i],
                FABRIC,
            )
    k.top_surface(0.03)


@shape("mattress")
def mattress(k: Kit) -> None:
    """A thick slab with piping."""
    x, y, z = k.size
    k.box((-x / 2 + 0.01, x / 2 - 0.01), (-y / 2 + 0.01, y / 2 - 0.01), (0, z))
    for low in (0.1, 0.8):
        k.box((-x / 2, x / 2), (-y / 2, y / 2), (low * z, (low + 0.08) * z), (120, 150, 190), FABRIC)
    k.top_surface(0.03)


@shape("carpet")
def carpet(k: Kit) -> None:
    """A border, a field and a medallion; flat on top to a millimetre or two."""
    x, y, z = k.size
    k.box((-x / 2, x / 2), (-y / 2, y / 2), (0, 0.6 * z), shade(k.color, 0.7))
    k.box((-x * 0.45, x * 0.45), (-y * 0.46, y * 0.46), (0.6 * z, 0.8 * z), shade(k.color, 1.25))
    k.box((-x * 0.4, x * 0.4), (-y * 0.42, y * 0.42), (0.8 * z, z), k.color)
    k.surface((-x * 0.4, x * 0.4), (-y * 0.42, y * 0.42), z, 1.5)


@shape("cloth_flat")
def cloth(k: Kit) -> None:
    """Folded cloth with a stripe."""
    k.unit()
    k.box((-0.5, 0.5), (-0.5, 0.5), (0, 0.5), shade(k.color, 0.92), FABRIC)
    k.box((-0.5, 0.48), (-0.5, 0.48), (0.5, 0.98), k.color, FABRIC)
    k.box((-0.36, -0.24), (-0.5, 0.48), (0.9, 1.0), (90, 140, 180), FABRIC)
    k.box((0.2, 0.32), (-0.5, 0.48), (0.9, 1.0), (90, 140, 180), FABRIC)


@shape("clothing_flat")
def clothing(k: Kit) -> None:
    """Folded or laid out: dress, top, tie."""
    k.unit()
    if k.name == "necktie":
        for i in range(5):
            half = 0.5 - 0.08 * i
            k.box((-0.44 + 0.16 * i, -0.28 + 0.16 * i), (-half, half), (0, 0.8), RED if i % 2 else k.color, FABRIC)
        k.box((-0.5, -0.44), (-0.24, 0.24), (0, 0.8), k.color, FABRIC)
        k.box((0.36, 0.5), (-0.24, 0.24), (0, 1.0), shade(k.color, 1.2), FABRIC)
    elif k.name == "dress":
        for i in range(4):
            half = 0.5 - 0.08 * i
            k.box(
                (-0.5 + 0.15 * i, -0.35 + 0.15 * i),
                (-half, half),
                (0, 0.7),
                shade(k.color, 0.92 + 0.06 * (i % 2)),
                FABRIC,
            )
        k.box((0.1, 0.14), (-0.27, 0.27), (0, 0.9), WHITE, FABRIC)
        k.box((0.14, 0.36), (-0.3, 0.3), (0, 0.8), shade(k.color, 0.9), FABRIC)
        for s in (-1, 1):
            c, d = sorted((s * 0.22, s * 0.14))
            k.box((0.36, 0.5), (c, d), (0.2, 1.0), k.color, FABRIC)
    else:
        k.box((-0.5, 0.2), (-0.5, 0.5), (0, 0.9), k.color, FABRIC)
        for s in (-1, 1):
            c, d = sorted((s * 0.4, s * 0.2))
            k.box((0.2, 0.5), (c, d), (0, 0.9), k.color, FABRIC)
        k.box((-0.3, 0.0), (-0.2, 0.2), (0.9, 1.0), (90, 140, 200), FABRIC)


@shape("hanger")
def hanger(k: Kit) -> None:
    """Lying flat: a triangle and a hook."""
    k.unit()
    k.rod((-0.42, -0.46, 0.5), (0.16, 0, 0.5), 0.018)
    k.rod((-0.42, 0.46, 0.5), (0.16, 0, 0.5), 0.018)
    k.rod((-0.44, -0.48, 0.5), (-0.44, 0.48, 0.5), 0.016)
    k.path([(0.14, 0, 0.5), (0.3, 0, 0.5), (0.46, 0.06, 0.5), (0.42, 0.14, 0.5)], 0.008, SILVER, METAL)


@shape("hat")
def hat(k: Kit) -> None:
    """Caps have a peak in front, hats a brim, helmets a ridge."""
    k.unit()
    if k.name == "hat":
        k.cyl((-0.5, 0.5), (-0.5, 0.5), (0, 0.12))
        k.cyl((-0.3, 0.3), (-0.3, 0.3), (0.12, 1), None, None, taper=0.85)
        k.cyl((-0.31, 0.31), (-0.31, 0.31), (0.12, 0.34), DARKBROWN)
    elif k.name == "work_helmet":
        k.cyl((-0.5, 0.5), (-0.5, 0.5), (0, 0.14))
        k.ball((-0.46, 0.38), (-0.46, 0.46), (-0.6, 0.95))
        k.box((-0.4, 0.32), (-0.06, 0.06), (0.5, 1.0), shade(k.color, 0.9))
    else:
        k.ball((-0.5, 0.28), (-0.5, 0.5), (-0.7, 0.95))
        k.cyl((-0.1, 0.5), (-0.42, 0.42), (0, 0.1), shade(k.color, 0.8), FABRIC)
        k.ball((-0.14, -0.06), (-0.06, 0.06), (0.9, 1.0), RED)
        k.box((0.16, 0.26), (-0.2, 0.2), (0.25, 0.55), WHITE)


@shape("shoe")
def shoe(k: Kit) -> None:
    """Sole and upper, toe in front; heels and boots rise at the back, sandals have straps."""
    k.unit()
    if k.name == "high_heel":
        wide = 0.8 * k.size[1]
        k.rod((-0.46, 0, 0.6), (0.2, 0, 0.1), (0.014, wide), RED)
        k.box((0.14, 0.5), (-0.5, 0.5), (0, 0.09), RED)
        k.ball((0.06, 0.5), (-0.5, 0.5), (0.06, 0.34))
        k.rod((-0.42, 0, 0.0), (-0.44, 0, 0.6), 0.012, k.color)
        k.rod((-0.36, 0, 0.68), (0.12, 0, 0.28), (0.02, wide), k.color)
        k.box((-0.5, -0.32), (-0.4, 0.4), (0.58, 1.0))
        return
    k.box((-0.5, 0.3), (-0.48, 0.48), (0, 0.2), WHITE if k.name != "hiking_boot" else DARK)
    k.cyl((0.1, 0.5), (-0.5, 0.5), (0, 0.2), WHITE if k.name != "hiking_boot" else DARK)
    if k.name == "sandal":
        for x0 in (-0.4, 0.1):
            k.cyl((x0, x0 + 0.16), (-0.46, 0.46), (-0.4, 1.0), k.color, None, axis="x")
        return
    color = (210, 60, 60) if k.name == "gym_shoe" else (120, 170, 210) if k.name == "baby_shoe" else k.color
    k.ball((-0.1, 0.5), (-0.48, 0.48), (0.05, 0.62), color)
    k.box((-0.48, 0.02), (-0.42, 0.42), (0.2, 1.0 if k.name == "hiking_boot" else 0.86), color)
    k.box((-0.44, -0.02), (-0.3, 0.3), (0.86, 1.01), DARK)
    k.box((0.02, 0.2), (-0.24, 0.24), (0.5, 0.72), WHITE)


@shape("glove_pair")
def gloves(k: Kit) -> None:
    """A palm, four fingers and a thumb; boxing gloves are round, a baseball glove has a web."""
    k.unit()
    if k.name == "boxing_gloves":
        for s in (-1, 1):
            c, d = sorted((s * 0.5, s * 0.02))
            k.ball((-0.1, 0.5), (c, d), (0, 1), RED)
            k.cyl((-0.5, 0.0), (c + 0.08, d - 0.08), (0.15, 0.85), (230, 230, 230), None, axis="x")
        return
    k.ball((-0.5, 0.15), (-0.45, 0.4), (0, 1))
    for i in range(4):
        y0 = -0.42 + 0.2 * i
        k.ball((-0.1, 0.5 - 0.06 * abs(i - 1.5)), (y0, y0 + 0.2), (0.1, 0.8), shade(k.color, 0.9 + 0.05 * i))
    k.rod((-0.2, 0.3, 0.4), (0.1, 0.5, 0.4), min(0.03, k.size[2] * 0.6))
    k.box((-0.5, -0.4), (-0.4, 0.36), (0.05, 0.9), shade(k.color, 0.7))


@shape("guitar")
def guitar(k: Kit) -> None:
    """Lying: two round bouts, sound hole, dark neck, head."""
    k.unit()
    wood = (186, 116, 56)
    k.cyl((-0.5, -0.16), (-0.5, 0.5), (0, 0.85), wood, Material.WOOD)
    k.cyl((-0.24, 0.06), (-0.38, 0.38), (0, 0.85), shade(wood, 1.08), Material.WOOD)
    k.box((-0.32, -0.1), (-0.28, 0.28), (0, 0.84), wood, Material.WOOD)
    k.cyl((-0.2, -0.08), (-0.16, 0.16), (0.85, 0.88), BLACK)
    k.box((-0.4, -0.36), (-0.22, 0.22), (0.85, 0.95), DARKBROWN)
    k.box((-0.1, 0.4), (-0.07, 0.07), (0.5, 0.98), DARKBROWN)
    k.box((0.38, 0.5), (-0.12, 0.12), (0.5, 0.95), (60, 40, 28))
    for s in (-1, 1):
        k.box((-0.38, 0.4), (s * 0.04 - 0.01, s * 0.04 + 0.01), (0.97, 1.0), SILVER)
    if k.name == "violin":
        k.rod((-0.45, 0.34, 0.3), (0.4, 0.44, 0.3), 0.01, BROWN)


@shape("horn")
def horn(k: Kit) -> None:
    """Brass along its longest side: bell, tube, valves or slide, mouthpiece."""
    k.unit()
    along_x = k.size[0] >= k.size[1]
    brass = (216, 172, 60)

    def at(u: float, v: float, w: float) -> tuple[float, float, float]:
        return (u, v, w) if along_x else (v, u, w)

    t = 0.12 * min(k.size)
    if along_x:
        k.cyl((0.2, 0.5), (-0.22, 0.22), (0.2, 0.8), brass, METAL, axis="x", taper=2.2)
    else:
        k.cyl((-0.22, 0.22), (0.2, 0.5), (0.2, 0.8), brass, METAL, axis="y", taper=2.2)
    k.rod(at(-0.46, 0.0, 0.5), at(0.25, 0.0, 0.5), 2 * t, brass, METAL)
    k.rod(at(-0.2, -0.36, 0.45), at(0.16, -0.36, 0.45), 1.6 * t, brass, METAL)
    k.rod(at(-0.2, -0.36, 0.45), at(-0.2, 0.0, 0.5), 1.6 * t, brass, METAL)
    k.rod(at(0.16, -0.36, 0.45), at(0.16, 0.0, 0.5), 1.6 * t, brass, METAL)
    for i in range(3):
        p = at(-0.12 + 0.09 * i, -0.18, 0.45)
        k.rod((p[0], p[1], 0.2), (p[0], p[1], 0.9), 1.8 * t, SILVER, METAL)
    k.rod(at(-0.5, 0.0, 0.5), at(-0.44, 0.0, 0.5), 2.6 * t, SILVER, METAL)


@shape("cymbal")
def cymbal(k: Kit) -> None:
    """A brass disc on a stand with three feet."""
    k.unit()
    k.cyl((-0.5, 0.5), (-0.5, 0.5), (0.92, 0.97), (220, 180, 70), METAL, taper=0.5)
    k.cyl((-0.06, 0.06), (-0.06, 0.06), (0.95, 1.0), BLACK)
    k.cyl((-0.03, 0.03), (-0.03, 0.03), (0.1, 0.95), SILVER, METAL)
    for dx, dy in ((0.44, 0.0), (-0.3, 0.4), (-0.3, -0.4)):
        k.rod((0, 0, 0.25), (dx, dy, 0.01), 0.02, SILVER, METAL)


@shape("piano")
def piano(k: Kit) -> None:
    """An upright: body at the back, keyboard shelf in front with white and black keys, legs, pedals."""
    x, y, z = k.size
    keys = 0.62 * z
    black = (34, 30, 30)
    k.box((-x / 2, -x * 0.08), (-y / 2, y / 2), (0.0, z - 0.03), black)
    k.box((-x / 2, 0.0), (-y / 2, y / 2), (z - 0.03, z), shade(black, 1.15))
    k.box((-x * 0.08, x / 2), (-y / 2, y / 2), (keys - 0.08, keys), black)
    for s in (-1, 1):
        c, d = sorted((s * y / 2, s * (y / 2 - 0.07)))
        k.box((-x * 0.08, x / 2), (c, d), (keys, keys + 0.1), black)
        k.box((x / 2 - 0.1, x / 2 - 0.03), (c, d), (0, keys - 0.08), black)
    k.box((x * 0.1, x / 2 - 0.03), (-y / 2 + 0.07, y / 2 - 0.07), (keys, keys + 0.02), (248, 246, 240))
    for i in range(5):
        y0 = -y / 2 + 0.12 + i * (y - 0.24) / 5
        k.box((x * 0.1, x * 0.3), (y0, y0 + 0.5 * (y - 0.24) / 5), (keys + 0.02, keys + 0.032), BLACK)
    k.box((-x * 0.08, -x * 0.04), (-0.3, 0.3), (z * 0.74, z * 0.92), (70, 50, 40), Material.WOOD)
    k.surface((-x / 2 + 0.01, -0.01), (-y / 2 + 0.02, y / 2 - 0.02), z)
    k.below((-x * 0.06, x / 2 - 0.02), (-y / 2 + 0.09, y / 2 - 0.09), keys - 0.09)


@shape("ball")
def ball(k: Kit) -> None:
    """Seams, patches or finger holes."""
    k.unit()
    k.ball((-0.5, 0.5), (-0.5, 0.5), (0, 1))
    if k.name == "soccer_ball":
        for x0, y0, z0 in (
            (0.5, 0, 0.5),
            (-0.5, 0, 0.5),
            (0, 0.5, 0.5),
            (0, -0.5, 0.5),
            (0, 0, 1.0),
            (0.34, 0.34, 0.86),
        ):
            u, v, w = x0 * 0.82, y0 * 0.82, 0.5 + (z0 - 0.5) * 0.82
            k.ball((u - 0.14, u + 0.14), (v - 0.14, v + 0.14), (w - 0.14, w + 0.14), BLACK)
    elif k.name in ("baseball", "tennis_ball"):
        color = RED if k.name == "baseball" else WHITE
        for x0 in (-0.26, 0.2):
            k.cyl((x0, x0 + 0.06), (-0.445, 0.445), (0.055, 0.945), color, axis="x")
    else:
        for y0, z0 in ((-0.12, 0.9), (0.06, 0.9), (-0.03, 0.76)):
            k.ball((0.0 + (0.95 - z0), 0.12 + (0.95 - z0)), (y0, y0 + 0.1), (z0 - 0.02, z0 + 0.09), GREY)


@shape("stick_long")
def stick(k: Kit) -> None:
    """Bats, clubs, rackets, skis, rods: long things lying down."""
    k.unit()
    name = k.name
    if name == "baseball_bat":
        k.cyl((-0.5, -0.46), (-0.4, 0.4), (0.1, 0.9), DARKBROWN, axis="x")
        k.cyl((-0.46, -0.1), (-0.26, 0.26), (0.24, 0.76), BLACK, axis="x")
        k.cyl((-0.12, 0.5), (-0.3, 0.3), (0.2, 0.8), None, None, axis="x", taper=1.65)
    elif name == "golf_club":
        k.box((-0.5, -0.28), (-0.3, -0.1), (0.1, 0.9), BLACK)
        k.box((-0.28, 0.44), (-0.26, -0.14), (0.3, 0.7), SILVER, METAL)
        k.box((0.4, 0.5), (-0.3, 0.5), (0, 1), GREY, METAL)
    elif name == "hockey_stick":
        k.box((-0.4, -0.1), (-0.5, 0.36), (0.2, 0.8), BLACK)
        k.rod((-0.25, 0.34, 0.5), (0.45, 0.48, 0.5), 0.05, (210, 180, 120), Material.WOOD)
        k.box((-0.42, -0.08), (-0.5, -0.34), (0.1, 0.9), WHITE)
    elif name == "tennis_racket":
        rim = ((0.0, -0.3), (0.0, 0.3), (0.14, 0.5), (0.36, 0.5), (0.5, 0.3), (0.5, -0.3), (0.36, -0.5), (0.14, -0.5))
        for (ax, ay), (bx, by) in zip(rim, (*rim[1:], rim[0]), strict=True):
            k.rod((ax, ay * 0.96, 0.5), (bx, by * 0.96, 0.5), 0.02, RED)
        k.box((0.02, 0.48), (-0.4, 0.4), (0.42, 0.58), (226, 230, 226))
        k.rod((-0.2, 0, 0.5), (0.02, 0.1, 0.5), 0.015, RED)
        k.rod((-0.2, 0, 0.5), (0.02, -0.1, 0.5), 0.015, RED)
        k.box((-0.5, -0.18), (-0.06, 0.06), (0, 1), BLACK)
    elif name == "ski":
        for s in (-1, 1):
            c, d = sorted((s * 0.5, s * 0.1))
            k.box((c, d), (-0.5, 0.42), (0, 0.4), k.color)
            k.rod((s * 0.3, 0.41, 0.2), (s * 0.3, 0.5, 0.9), (0.012, 0.035), k.color)
            k.box((c, d), (-0.1, 0.1), (0.4, 1.0), BLACK)
    else:
        k.rod((0, -0.5, 0.3), (0, 0.5, 0.3), 0.014, DARK)
        k.box((-0.3, 0.3), (-0.5, -0.32), (0.1, 0.6), TAN)
        k.cyl((-0.5, 0.5), (-0.32, -0.26), (0, 1.0), SILVER, METAL, axis="y")
        for y0 in (-0.1, 0.12, 0.34):
            k.box((-0.25, 0.25), (y0, y0 + 0.012), (0.15, 0.6), RED)


@shape("board_wheels")
def longboard(k: Kit) -> None:
    """A deck along y on four wheels."""
    k.unit()
    k.box((-0.42, 0.42), (-0.4, 0.4), (0.55, 0.8), (150, 100, 60), Material.WOOD)
    for s in (-1, 1):
        c, d = sorted((s * 0.3, s * 0.5))
        k.cyl((-0.42, 0.42), (c, d), (0.55, 0.8), (150, 100, 60), Material.WOOD)
        for t in (-1, 1):
            a, b = sorted((t * 0.5, t * 0.26))
            k.cyl((a, b), (s * 0.3 - 0.05, s * 0.3 + 0.05), (0, 0.5), (220, 90, 50), axis="x")
        k.box((-0.4, 0.4), (s * 0.3 - 0.02, s * 0.3 + 0.02), (0.2, 0.55), GREY, METAL)
    k.box((-0.34, 0.34), (-0.4, 0.4), (0.8, 1.0), DARK)


@shape("punching_bag")
def punching_bag(k: Kit) -> None:
    """A red bag on a round foot."""
    k.unit()
    k.cyl((-0.5, 0.5), (-0.5, 0.5), (0, 0.14), BLACK)
    k.cyl((-0.1, 0.1), (-0.1, 0.1), (0.14, 0.36), SILVER, METAL)
    k.cyl((-0.4, 0.4), (-0.4, 0.4), (0.34, 1.0), RED)
    for z0 in (0.46, 0.84):
        k.cyl((-0.41, 0.41), (-0.41, 0.41), (z0, z0 + 0.03), BLACK)


@shape("treadmill")
def treadmill(k: Kit) -> None:
    """A belt in a frame, two posts, a console; the runner steps on from +x."""
    x, y, z = k.size
    deck = 0.14
    k.box((-x / 2, x / 2), (-y * 0.32, y * 0.32), (0.03, deck), (40, 40, 42))
    for s in (-1, 1):
        c, d = sorted((s * y / 2, s * y * 0.32))
        k.box((-x / 2, x / 2), (c, d), (0, deck + 0.02), GREY)
        k.rod((-x * 0.36, s * (y / 2 - 0.05), deck), (-x * 0.42, s * (y / 2 - 0.05), z - 0.12), 0.06, DARK)
        k.box((-x * 0.42, -x * 0.1), (s * (y / 2 - 0.05) - 0.02, s * (y / 2 - 0.05) + 0.02), (z * 0.76, z * 0.8), BLACK)
    k.box((-x / 2, -x * 0.38), (-y / 2, y / 2), (z - 0.16, z), DARK)
    k.box((-x * 0.38, -x * 0.375), (-y * 0.3, y * 0.3), (z - 0.13, z - 0.03), (90, 170, 210), Material.GLASS)
    k.box((-x / 2, -x * 0.3), (-y * 0.32, y * 0.32), (deck, deck + 0.09), DARK)
    k.surface((-x * 0.28, x / 2 - 0.05), (-y * 0.3, y * 0.3), deck)


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
