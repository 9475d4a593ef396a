"""Bedding, cloth, clothing and shoes."""

from __future__ import annotations

from ucon.objects.kit import Kit, shape
from ucon.objects.model import Material
from ucon.objects.palette import DARK, DARKBROWN, RED, SILVER, WHITE, shade

FABRIC = Material.FABRIC
METAL = Material.METAL


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
