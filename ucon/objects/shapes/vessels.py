"""Bowls, pots, cups, glasses, plates, trays and vases."""

from __future__ import annotations

from ucon.objects.kit import (
    BLACK,
    BROWN,
    DARK,
    DARKBROWN,
    GREY,
    SILVER,
    WHITE,
    Kit,
    shade,
    shape,
)
from ucon.objects.model import Material
from ucon.objects.shapes.casework import tub
from ucon.objects.shapes.generic import OPEN_TOP_HEADROOM, open_box, ring

INSCRIBED = 0.70
"""Half side of the largest square in a circle of radius 1, with a little play."""


def round_space(k: Kit, rx: float, ry: float, floor: float, top: float, cx: float = 0.0, cy: float = 0.0) -> None:
    """The upright box that fits into a round hollow, with headroom above the rim."""
    hx, hy = rx * INSCRIBED, ry * INSCRIBED
    k.space((cx - hx, cx + hx), (cy - hy, cy + hy), (floor, floor + (top - floor) * OPEN_TOP_HEADROOM))


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
    _hollow(k, x / 2, y / 2, 0.0, z, min(0.006, 0.05 * x), foot=0.6)


def _hollow(
    k: Kit, rx: float, ry: float, low: float, top: float, wall: float, foot: float = 0.9, floor: float | None = None
) -> None:
    """A round wall on a foot of ``foot`` times its width; the inside is darker, so that the hollow is seen."""
    base = low + (floor if floor is not None else max(0.006, 0.16 * (top - low)))
    ring(k, rx, ry, (base, top), wall)
    inner_x, inner_y = rx - wall, ry - wall
    k.cyl((-rx * foot, rx * foot), (-ry * foot, ry * foot), (low, base - 0.002))
    k.cyl((-inner_x, inner_x), (-inner_y, inner_y), (base - 0.004, base + 0.001), shade(k.color, 0.75))
    round_space(k, inner_x * 0.98, inner_y * 0.98, base + 0.001, top)


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
    _hollow(k, x / 2 - 0.012, y / 2, 0.0, z, 0.006, foot=0.55)
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
    _hollow(k, rx, ry, 0.0, z, 0.008, foot=0.97, floor=max(0.01, 0.08 * z))
    for s in (-1, 1):
        c, d = sorted((s * y / 2, s * (y / 2 - ear - 0.006)))
        reach = min(0.05, rx * 0.4)
        k.box((-reach, reach), (c, d), (0.68 * z, 0.68 * z + max(0.012, 0.08 * z)), shade(k.color, 0.7))
    if k.name == "steamer_basket":
        k.box((-rx, -rx + 0.004), (-ry * 0.3, ry * 0.3), (0.2 * z, 0.8 * z), shade(k.color, 0.7))


@shape("cup_mug")
def cup(k: Kit) -> None:
    """A hollow cup; mugs and teacups have a handle at the side."""
    x, y, z = k.size
    handled = k.name in ("mug", "teacup", "coffee_cup")
    if k.name == "chalice":
        _stem_glass(k, 0.45)
        return
    along_y = y > x
    ear = 0.24 * max(x, y) if handled else 0.0
    rx, ry = (x / 2, (y - ear) / 2) if along_y else ((x - ear) / 2, y / 2)
    cx, cy = (0.0, -ear / 2) if along_y else (-ear / 2, 0.0)
    wall, floor = 0.004, 0.008
    ring(k, rx, ry, (floor, z), wall, sides=8, cx=cx, cy=cy)
    k.cyl((cx - rx * 0.9, cx + rx * 0.9), (cy - ry * 0.9, cy + ry * 0.9), (0, floor + 0.001), shade(k.color, 0.9))
    content = {"mug": (70, 44, 28), "coffee_cup": (60, 36, 22), "teacup": (150, 84, 40)}.get(k.name)
    k.cyl((cx - rx + wall, cx + rx - wall), (cy - ry + wall, cy + ry - wall), (floor, floor + 0.003),
          content or shade(k.color, 0.7))  # fmt: skip
    if handled:
        t = 0.009
        for z0, z1 in ((0.68 * z, 0.8 * z), (0.25 * z, 0.37 * z)):
            _ear(k, along_y, cx, cy, rx, ry, (0.0, ear), (z0, z1), t)
        _ear(k, along_y, cx, cy, rx, ry, (ear - t, ear), (0.37 * z, 0.68 * z), t)
    round_space(k, (rx - wall) * 0.97, (ry - wall) * 0.97, floor + 0.003, z, cx, cy)


def _ear(
    k: Kit, along_y: bool, cx: float, cy: float, rx: float, ry: float, out: tuple[float, float],
    z: tuple[float, float], thick: float,
) -> None:  # fmt: skip
    half = (-thick / 2, thick / 2)
    if along_y:
        k.box(half, (cy + ry - 0.003 + out[0], cy + ry + out[1]), z, shade(k.color, 0.92))
    else:
        k.box((cx + rx - 0.003 + out[0], cx + rx + out[1]), half, z, shade(k.color, 0.92))


def _stem_glass(k: Kit, waist: float) -> None:
    x, y, z = k.size
    low = waist * z
    ring(k, x / 2, y / 2, (low, z), 0.004)
    k.cyl((-x * 0.44, x * 0.44), (-y * 0.44, y * 0.44), (low - 0.01, low + 0.004), shade(k.color, 0.92))
    k.cyl((-0.006, 0.006), (-0.006, 0.006), (0.006, low - 0.01), shade(k.color, 0.9))
    k.cyl((-x * 0.38, x * 0.38), (-y * 0.38, y * 0.38), (0, 0.006))
    round_space(k, (x / 2 - 0.006), (y / 2 - 0.006), low + 0.004, z)


@shape("glass_stem")
def wineglass(k: Kit) -> None:
    """Bowl, stem and foot."""
    _stem_glass(k, 0.5 if k.name == "wineglass" else 0.6)


@shape("glass_tumbler")
def tumbler(k: Kit) -> None:
    """A clear straight glass."""
    x, y, z = k.size
    beer = k.name == "beer_glass"
    _hollow(k, x / 2, y / 2, 0.0, z, 0.004, foot=0.95, floor=0.45 * z if beer else 0.012)
    if beer:
        part = k.parts[-2]
        k.parts.remove(part)
        k.cyl((-x * 0.46, x * 0.46), (-y * 0.46, y * 0.46), (0, 0.44 * z), (216, 160, 50), Material.GLASS)


@shape("flask")
def flask(k: Kit) -> None:
    """Round-bellied bottles with a neck."""
    k.unit()
    if k.name == "canteen":
        k.cyl((-0.5, 0.5), (-0.5, 0.5), (0, 0.8), k.color, Material.FABRIC, axis="x")
        k.cyl((-0.2, 0.2), (-0.14, 0.14), (0.76, 0.88), SILVER, Material.METAL)
        k.cyl((-0.26, 0.26), (-0.18, 0.18), (0.86, 1.0), BLACK)
        k.box((-0.52, 0.52), (-0.06, 0.06), (0.0, 0.8), BROWN)
        return
    glass = (190, 216, 222)
    wine = (120, 30, 44) if k.name == "decanter" else (176, 210, 224)
    k.cyl((-0.5, 0.5), (-0.5, 0.5), (0, 0.34), wine, Material.GLASS, taper=0.9)
    k.cyl((-0.45, 0.45), (-0.45, 0.45), (0.34, 0.55), glass, Material.GLASS, taper=0.4)
    k.cyl((-0.18, 0.18), (-0.18, 0.18), (0.55, 0.86), glass, Material.GLASS)
    k.cyl((-0.24, 0.24), (-0.24, 0.24), (0.86, 0.92 if k.name == "decanter" else 1.0), glass, Material.GLASS)
    if k.name == "decanter":
        k.ball((-0.14, 0.14), (-0.14, 0.14), (0.88, 1.0), (214, 232, 238), Material.GLASS)


@shape("jug")
def jug(k: Kit) -> None:
    """A tall open jug with spout and handle."""
    x, y, z = k.size
    ear = 0.22 * x
    rx, ry = (x - ear) / 2, y / 2
    cx = ear / 2 - 0.012
    ring(k, rx - 0.012, ry, (0.02, z), 0.006, cx=cx)
    k.cyl((cx - rx + 0.012, cx + rx - 0.012), (-ry, ry), (0, 0.02), shade(k.color, 0.92))
    k.cyl((cx - rx + 0.02, cx + rx - 0.02), (-ry + 0.01, ry - 0.01), (0.018, 0.024), (170, 206, 222))
    k.box((x / 2 - 0.03, x / 2), (-0.02, 0.02), (z - 0.04, z - 0.004), k.color)
    k.box((-x / 2, cx - rx + 0.016), (-0.012, 0.012), (0.74 * z, 0.82 * z), shade(k.color, 0.88))
    k.box((-x / 2, cx - rx + 0.016), (-0.012, 0.012), (0.22 * z, 0.3 * z), shade(k.color, 0.88))
    k.box((-x / 2, -x / 2 + 0.022), (-0.012, 0.012), (0.3 * z, 0.74 * z), shade(k.color, 0.88))
    round_space(k, rx - 0.024, ry - 0.012, 0.024, z, cx=cx)


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
        _hollow(k, x / 2, y / 2, 0.0, z * 0.999, 0.01, foot=0.85, floor=0.35 * z)
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
