"""Bowls, pots, plates, trays and vases."""

from __future__ import annotations

from ucon.objects.kit import Kit, shape
from ucon.objects.model import Material
from ucon.objects.palette import BLACK, BROWN, DARK, DARKBROWN, GREY, SILVER, WHITE, shade
from ucon.objects.shapes.casework import tub
from ucon.objects.shapes.generic import OPEN_TOP_HEADROOM, open_box, ring
from ucon.objects.shapes.hollow import hollow, round_space


@shape("bowl")
def bowl(k: Kit) -> None:
    """Panels around a foot; an ashtray and a gravy boat are small and solid."""
    x, y, z = k.size
    if k.name in ("ashtray", "gravy_boat"):
        k.unit()
        k.cyl((-0.36, 0.36), (-0.36, 0.36), (0, 0.5), k.color, taper=1.3)
        k.cyl((-0.44, 0.44), (-0.5, 0.5), (0.5, 0.96))
        inside = DARK if k.name == "ashtray" else (150, 96, 52)
        k.cyl((-0.36, 0.36), (-0.4, 0.4), (0.96, 1.0), inside)
        if k.name == "gravy_boat":
            k.box((0.4, 0.5), (-0.12, 0.12), (0.7, 1.0))
            k.box((-0.5, -0.42), (-0.06, 0.06), (0.4, 0.95))
        return
    hollow(k, x / 2, y / 2, 0.0, z, min(0.006, 0.05 * x), foot=0.6)


@shape("colander")
def colander(k: Kit) -> None:
    """A steel bowl with dark holes; a funnel is a cone, a sieve a disc with a handle."""
    x, y, z = k.size
    if k.name == "funnel":
        k.unit()
        k.cyl((-0.12, 0.12), (-0.12, 0.12), (0.4, 0.9), taper=4.0)
        k.cyl((-0.5, 0.5), (-0.5, 0.5), (0.9, 1.0))
        k.cyl((-0.08, 0.08), (-0.08, 0.08), (0, 0.5))
        k.cyl((-0.42, 0.42), (-0.42, 0.42), (0.99, 1.0), GREY)
        return
    if k.name == "sieve":
        k.unit()
        k.cyl((-0.5, 0.5), (0.12, 0.5), (0, 1), SILVER, Material.METAL)
        k.cyl((-0.4, 0.4), (0.16, 0.46), (0.9, 1.02), GREY, Material.METAL)
        k.box((-0.08, 0.08), (-0.5, 0.14), (0.6, 1.0), BLACK)
        return
    hollow(k, x / 2 - 0.012, y / 2, 0.0, z, 0.006, foot=0.55)
    for i in range(3):
        k.box((x / 2 - 0.014, x / 2 - 0.011), (-0.05 + 0.04 * i, -0.03 + 0.04 * i), (z * 0.4, z * 0.55), DARK)
    for s in (-1, 1):
        a, b = sorted((s * x / 2, s * (x / 2 - 0.015)))
        k.box((a, b), (-0.04, 0.04), (z * 0.8, z * 0.88), SILVER, Material.METAL)


@shape("pan", "copper_pot")
def pan(k: Kit) -> None:
    """A round pan with a long handle towards the front."""
    x, y, z = k.size
    ry = y / 2
    rx = min(ry, x * 0.32)
    cx = -x / 2 + rx
    floor = 0.012
    ring(k, rx, ry, (floor, z), 0.006, cx=cx)
    k.cyl((cx - rx, cx + rx), (-ry, ry), (0, floor), shade(k.color, 0.9))
    k.cyl((cx - rx + 0.01, cx + rx - 0.01), (-ry + 0.01, ry - 0.01), (floor, floor + 0.002), shade(k.color, 0.65))
    k.box((cx + rx - 0.004, x / 2), (-0.016, 0.016), (z * 0.66, z * 0.66 + 0.018), BLACK if k.color[0] > 60 else BROWN)
    round_space(k, (rx - 0.01), (ry - 0.01), floor + 0.002, z, cx=cx)


@shape("pot")
def pot(k: Kit) -> None:
    """A round pot with two handles."""
    x, y, z = k.size
    ear = min(0.03, 0.1 * y)
    ry, rx = y / 2 - ear, x / 2
    hollow(k, rx, ry, 0.0, z, 0.008, foot=0.97, floor=max(0.01, 0.08 * z))
    for s in (-1, 1):
        c, d = sorted((s * y / 2, s * (y / 2 - ear - 0.006)))
        reach = min(0.05, rx * 0.4)
        k.box((-reach, reach), (c, d), (0.68 * z, 0.68 * z + max(0.012, 0.08 * z)), shade(k.color, 0.7))
    if k.name == "steamer_basket":
        k.box((-rx, -rx + 0.004), (-ry * 0.3, ry * 0.3), (0.2 * z, 0.8 * z), shade(k.color, 0.7))


@shape("plate_disc")
def plate(k: Kit) -> None:
    """A flat disc with a rim ring; what lies on it lies inside its rim."""
    x, y, z = k.size
    k.cyl((-x / 2, x / 2), (-y / 2, y / 2), (z * 0.45, z * 0.8))
    k.cyl((-x * 0.32, x * 0.32), (-y * 0.32, y * 0.32), (0, z * 0.45), shade(k.color, 0.9))
    k.cyl((-x * 0.36, x * 0.36), (-y * 0.36, y * 0.36), (z * 0.8, z), shade(k.color, 0.88))
    k.surface((-x * 0.25, x * 0.25), (-y * 0.25, y * 0.25), z)
    k.space((-x * 0.33, x * 0.33), (-y * 0.33, y * 0.33), (z, z + 0.06))
    k.solid = True


@shape("tray_flat")
def tray(k: Kit) -> None:
    """A board, or a flat sheet with a raised rim."""
    x, y, z = k.size
    if k.name in ("board", "chopping_block", "chopping_board", "cutting_board"):
        k.box((-x / 2, x / 2), (-y / 2, y / 2), (0, z * 0.96), k.color, Material.WOOD)
        k.box(
            (-x / 2 + 0.012, x / 2 - 0.012),
            (-y / 2 + 0.012, y / 2 - 0.012),
            (z * 0.96, z),
            shade(k.color, 1.2),
            Material.WOOD,
        )
        k.box((-0.04, 0.04), (y / 2 - 0.035, y / 2 - 0.018), (z * 0.96, z + 0.0005), DARKBROWN)
        k.surface((-x / 2 + 0.005, x / 2 - 0.005), (-y / 2 + 0.005, y / 2 - 0.005), z)
        return
    deep = k.name == "roasting_pan"
    rim = 0.006 if deep else 0.012
    floor = 0.006
    half = y / 2 - (0.03 if deep else 0.0)
    ix, iy = tub(k, (-x / 2, x / 2), (-half, half), (0, z), rim, floor, inside=shade(k.color, 0.8))
    for s in (-1, 1):
        if deep or k.name == "tray":
            edge = (y / 2, y / 2 - 0.03) if deep else (y / 2 - 0.001, y / 2 - 0.011)
            c, d = sorted((s * edge[0], s * edge[1]))
            low = z * 0.8 if deep else z * 0.9
            reach = 0.06
            k.box((-reach, reach), (c, d) if deep else (min(c, d), max(c, d)), (low, z + (0 if deep else 0.0005)),
                  shade(k.color, 0.6))  # fmt: skip
    if k.category.container:
        k.space(ix, iy, (floor, floor + max(0.07, (z - floor) * OPEN_TOP_HEADROOM)))
    if k.category.support:
        k.surface(ix, iy, floor)


@shape("vase")
def vase(k: Kit) -> None:
    """A tall vase with a waist; a plant pot with earth is open."""
    x, y, z = k.size
    if k.name == "plant_pot":
        hollow(k, x / 2, y / 2, 0.0, z * 0.999, 0.01, foot=0.85, floor=0.35 * z)
        k.cyl((-x * 0.43, x * 0.43), (-y * 0.43, y * 0.43), (0.35 * z, 0.35 * z + 0.003), (70, 50, 36))
        return
    ring(k, x * 0.3, y * 0.3, (0.72 * z, z), 0.004, (206, 214, 226))
    k.cyl((-x * 0.32, x * 0.32), (-y * 0.32, y * 0.32), (0, 0.12 * z), (196, 204, 218))
    k.ball((-x / 2, x / 2), (-y / 2, y / 2), (0.06 * z, 0.74 * z), (96, 130, 180))
    k.cyl((-x * 0.27, x * 0.27), (-y * 0.27, y * 0.27), (0.735 * z, 0.742 * z), DARK)
    round_space(k, x * 0.27, y * 0.27, 0.745 * z, z)


@shape("tupperware")
def tupperware(k: Kit) -> None:
    """A clear box without its lid, with a coloured rim."""
    x, y, z = k.size
    open_box(k, 0.006, z=(0, z - 0.008))
    rim = (70, 140, 200)
    for s in (-1, 1):
        a, b = sorted((s * x / 2, s * (x / 2 - 0.008)))
        k.box((a, b), (-y / 2, y / 2), (z - 0.008, z), rim)
        c, d = sorted((s * y / 2, s * (y / 2 - 0.008)))
        k.box((-x / 2 + 0.008, x / 2 - 0.008), (c, d), (z - 0.008, z), rim)
    box = k.compartments.pop().box
    k.space((box[0] + 0.003, box[3] - 0.003), (box[1] + 0.003, box[4] - 0.003), (box[2], box[5]))


@shape("dish_rack")
def dish_rack(k: Kit) -> None:
    """A wire rack with plates standing in it."""
    x, y, z = k.size
    deck = 0.28 * z
    steel = Material.METAL
    for low in (0.08 * z, deck):
        k.box((-x / 2, x / 2), (-y / 2, y / 2), (low - 0.012, low), SILVER, steel)
    for sx in (-1, 1):
        for sy in (-1, 1):
            a, b = sorted((sx * x / 2, sx * (x / 2 - 0.015)))
            c, d = sorted((sy * y / 2, sy * (y / 2 - 0.015)))
            k.box((a, b), (c, d), (0, z if sx < 0 else deck), SILVER, steel)
    for i in range(4):
        y0 = y * 0.12 + i * y * 0.09
        k.cyl((-x * 0.42, x * 0.42), (y0, y0 + 0.012), (deck, deck + 0.24), WHITE, axis="y")
    k.box((-x / 2, -x / 2 + 0.012), (-y / 2, y / 2), (z - 0.012, z), SILVER, steel)
    k.surface((-x / 2 + 0.02, x / 2 - 0.01), (-y / 2 + 0.02, y * 0.1), deck, 0.3)
