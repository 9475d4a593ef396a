"""Doors, windows, things that hang on walls, radiators, and pieces of the building."""

from __future__ import annotations

from ucon.objects.kit import Kit, shape
from ucon.objects.model import Material
from ucon.objects.palette import BLACK, BROWN, DARK, GREY, NAVY, RED, SILVER, WHITE, shade
from ucon.objects.shapes.cabinets import hang_below
from ucon.objects.shapes.generic import plain

SKY = (170, 206, 236)


@shape("door")
def door(k: Kit) -> None:
    """A frame around a permanent opening; other doors of the house are closed panels."""
    x, y, z = k.size
    if k.name == "door":
        jamb = 0.04
        for s in (-1, 1):
            c, d = sorted((s * y / 2, s * (y / 2 - jamb)))
            k.box((-x / 2, x / 2), (c, d), (0, z))
        k.box((-x / 2, x / 2), (-y / 2 + jamb, y / 2 - jamb), (z - jamb, z))
        return
    if k.name == "gate":
        for i in range(6):
            y0 = -y / 2 + i * y / 6
            k.box((-x * 0.3, x * 0.3), (y0 + 0.01, y0 + y / 6 - 0.02), (0.08, z), k.color)
        for low in (0.2, 0.8):
            k.box((-x / 2, x / 2), (-y / 2, y / 2), (low * z, low * z + 0.09), shade(k.color, 0.8))
        k.box((-x / 2, x / 2), (-y / 2, -y / 2 + 0.05), (0, 0.1), DARK)
        return
    k.box((-x / 2, x * 0.3), (-y / 2, y / 2), (0, z))
    rows = 4 if k.name == "garage_door" else 1
    columns = 4 if k.name == "garage_door" else 2
    for i in range(rows):
        for j in range(columns):
            y0, z0 = -y / 2 + j * y / columns, i * z / rows
            k.box((x * 0.3, x / 2), (y0 + 0.03, y0 + y / columns - 0.03), (z0 + 0.04, z0 + z / rows - 0.04),
                  shade(k.color, 0.88))  # fmt: skip


@shape("window")
def window(k: Kit) -> None:
    """A white frame with four bright panes and a sill."""
    x, y, z = k.size
    frame = (236, 234, 228)
    k.box((-x / 2, 0), (-y / 2 + 0.05, y / 2 - 0.05), (0.06, z - 0.05), SKY, Material.GLASS)
    for s in (-1, 1):
        c, d = sorted((s * y / 2, s * (y / 2 - 0.06)))
        k.box((-x / 2, x * 0.3), (c, d), (0.03, z), frame)
    k.box((-x / 2, x * 0.3), (-y / 2 + 0.06, y / 2 - 0.06), (z - 0.06, z), frame)
    k.box((-x / 2, x / 2), (-y / 2, y / 2), (0, 0.06), frame)
    k.box((-x / 2, x * 0.2), (-0.02, 0.02), (0.06, z - 0.06), frame)
    k.box((-x / 2, x * 0.15), (-y / 2 + 0.06, y / 2 - 0.06), (z * 0.6, z * 0.6 + 0.035), frame)


@shape("curtain")
def curtain(k: Kit) -> None:
    """Cloth in folds from a rail; blinds and shutters have slats."""
    x, y, z = k.size
    if k.name != "curtain":
        count = 9
        k.box((-x / 2, -x * 0.1), (-y / 2, y / 2), (0, z), shade(k.color, 0.86), Material.PLAIN)
        for i in range(count):
            low = (i + 0.1) * z / count
            k.box((-x * 0.1, x / 2), (-y / 2, y / 2), (low, low + 0.75 * z / count), k.color, Material.PLAIN)
        hang_below(k, 0.3)
        return
    k.cyl((-x * 0.2, x * 0.2), (-y / 2, y / 2), (z - 0.03, z), BROWN, Material.WOOD, axis="y")
    for s in (-1, 1):
        for i in range(4):
            c, d = sorted((s * y / 2 - s * i * y * 0.09, s * y / 2 - s * (i + 1) * y * 0.09))
            depth = x / 2 if i % 2 else x * 0.3
            k.box((-x / 2, depth), (c, d), (0, z - 0.03), shade(k.color, 1.0 if i % 2 else 0.86))
    k.box((-x / 2, -x * 0.4), (-y * 0.14, y * 0.14), (0, z - 0.03), SKY, Material.GLASS)


@shape("mirror_wall_panel")
def mirror(k: Kit) -> None:
    """Pale glass in a slim frame."""
    x, y, z = k.size
    rim = 0.035
    k.box((-x / 2, x * 0.2), (-y / 2 + rim, y / 2 - rim), (rim, z - rim), (196, 216, 226), Material.GLASS)
    for s in (-1, 1):
        c, d = sorted((s * y / 2, s * (y / 2 - rim)))
        k.box((-x / 2, x / 2), (c, d), (0, z), (150, 118, 78), Material.WOOD)
    k.box((-x / 2, x / 2), (-y / 2 + rim, y / 2 - rim), (0, rim), (150, 118, 78), Material.WOOD)
    k.box((-x / 2, x / 2), (-y / 2 + rim, y / 2 - rim), (z - rim, z), (150, 118, 78), Material.WOOD)
    k.rod((x * 0.22, -y * 0.2, z * 0.5), (x * 0.22, y * 0.1, z * 0.8), (0.04, 0.004), WHITE)
    hang_below(k, 0.3)


@shape("picture_wall_panel")
def wall_picture(k: Kit) -> None:
    """A landscape in a frame; a poster has a portrait format and no frame."""
    x, y, z = k.size
    poster = k.name == "poster"
    rim = 0.0 if poster else 0.09 * min(y, z)
    front = x * 0.3 if poster else x * 0.25
    if not poster:
        wood = (96, 66, 40)
        for s in (-1, 1):
            c, d = sorted((s * y / 2, s * (y / 2 - rim)))
            k.box((-x / 2, x / 2), (c, d), (0, z), wood, Material.WOOD)
        k.box((-x / 2, x / 2), (-y / 2 + rim, y / 2 - rim), (0, rim), wood, Material.WOOD)
        k.box((-x / 2, x / 2), (-y / 2 + rim, y / 2 - rim), (z - rim, z), wood, Material.WOOD)
    y1, z0, z1 = y / 2 - rim, rim, z - rim
    sky, sun, hill, ground = ((226, 84, 60), WHITE, NAVY, (30, 30, 40)) if poster else (
        (140, 190, 226), (250, 220, 120), (104, 140, 96), (72, 110, 62))  # fmt: skip
    middle = z0 + 0.42 * (z1 - z0)
    k.box((-x / 2, front), (-y1, y1), (middle, z1), sky, Material.PAPER)
    k.box((-x / 2, front), (-y1, y1), (z0, middle), ground, Material.PAPER)
    size = 0.14 * min(y, z)
    lift = 0.15 * x
    k.cyl((front - lift, front + lift), (y1 * 0.35 - size, y1 * 0.35 + size), (z1 * 0.78 - size, z1 * 0.78 + size),
          sun, Material.PAPER, axis="x")  # fmt: skip
    k.box((front - lift, front + lift), (-y1 * 0.8, y1 * 0.1), (middle, middle + 0.16 * z), hill, Material.PAPER)
    hang_below(k, 0.3)


@shape("clock_wall")
def wall_clock(k: Kit) -> None:
    """A white dial in a dark ring with two hands."""
    k.unit()
    k.cyl((-0.5, 0.3), (-0.5, 0.5), (0, 1), BLACK, axis="x")
    k.cyl((0.3, 0.4), (-0.42, 0.42), (0.08, 0.92), WHITE, axis="x")
    k.box((0.4, 0.5), (-0.02, 0.02), (0.5, 0.82), BLACK)
    k.box((0.4, 0.5), (0.0, 0.24), (0.48, 0.52), BLACK)
    for y0, z0 in ((0, 0.84), (0, 0.12), (0.36, 0.48), (-0.4, 0.48)):
        k.box((0.4, 0.45), (y0 - 0.02, y0 + 0.04), (z0, z0 + 0.04), BLACK)


@shape("wall_switch")
def wall_plate(k: Kit) -> None:
    """A plate on the wall: rocker, socket holes, or alarm lamp."""
    k.unit()
    if k.name == "fire_alarm":
        k.cyl((-0.5, 0.5), (-0.5, 0.5), (0, 1), WHITE, taper=0.8)
        k.cyl((-0.1, 0.1), (-0.1, 0.1), (0, 1), RED)
        return
    k.box((-0.5, 0.2), (-0.5, 0.5), (0, 1), WHITE)
    if k.name == "electric_switch":
        k.box((0.2, 0.5), (-0.24, 0.24), (0.2, 0.8), (214, 214, 210))
    else:
        k.cyl((0.2, 0.4), (-0.34, 0.34), (0.16, 0.84), (222, 222, 218), axis="x")
        for s in (-1, 1):
            k.cyl((0.4, 0.5), (s * 0.16 - 0.06, s * 0.16 + 0.06), (0.44, 0.56), BLACK, axis="x")


@shape("radiator")
def radiator(k: Kit) -> None:
    """Ribs between two pipes; boilers and heaters are cabinets of metal."""
    x, y, z = k.size
    if k.name == "radiator":
        count = 9
        for i in range(count):
            low = -y / 2 + i * y / count
            k.box((-x / 2, x / 2), (low, low + 0.72 * y / count), (0, z))
        k.box((-x * 0.3, x * 0.3), (-y / 2, y / 2), (0.06 * z, 0.12 * z), shade(k.color, 0.85))
        k.box((-x / 2, x / 2), (-y / 2, y / 2), (z - 0.02, z), shade(k.color, 0.95))
        k.top_surface(0.005, clearance=0.5)
        hang_below(k, 0.14)
    elif k.name == "sauna_heater":
        k.box((-x / 2, x / 2), (-y / 2, y / 2), (0.12, 0.85 * z), GREY, Material.METAL)
        k.box((-x * 0.4, x * 0.4), (-y * 0.4, y * 0.4), (0, 0.12), BLACK)
        for i in range(5):
            y0 = (-0.4 + 0.17 * i) * y
            k.ball((-x * 0.4, x * 0.4), (y0, y0 + 0.16 * y), (0.72 * z, z), (90, 86, 82))
        k.surface((-x * 0.4, x * 0.4), (-y * 0.4, y * 0.4), z)
    elif k.name == "boiler":
        k.cyl((-x / 2, x / 2 - 0.02), (-y / 2, y / 2), (0.08, 0.92 * z), SILVER, Material.METAL)
        k.cyl((-x * 0.4, x * 0.4), (-y * 0.4, y * 0.4), (0, 0.08), DARK)
        k.cyl((-0.05, 0.05), (-0.05, 0.05), (0.92 * z, z), (184, 112, 68), Material.METAL)
        k.box((x / 2 - 0.05, x / 2), (-0.09, 0.09), (0.3 * z, 0.5 * z), DARK)
    else:
        k.box((-x / 2, x / 2), (-y / 2, y / 2), (0.3 * z, z))
        for i in range(4):
            x0 = (-0.4 + 0.22 * i) * x
            k.box((x0, x0 + 0.12 * x), (-y * 0.42, y * 0.42), (0, 0.3 * z), shade(k.color, 0.75))


@shape("floor", "wall", "ceiling")
def slab(k: Kit) -> None:
    """Pieces of the building that stand alone."""
    material = {
        "lawn": Material.GRASS, "greenery": Material.GRASS, "driveway": Material.CONCRETE, "floors": Material.PARQUET,
        "walls": Material.PLASTER, "pillar": Material.PLASTER, "ceilings": Material.PLASTER, "roof": Material.TILE,
        "structural_element": Material.CONCRETE,
    }.get(k.name, Material.PLAIN)  # fmt: skip
    k.material = material
    if k.name == "room_divider":
        x, y, z = k.size
        for i in range(3):
            low = -y / 2 + i * y / 3
            k.box((-x / 2, x / 2), (low, low + y / 3 - 0.01), (0.04, z), shade(k.color, 0.92 + 0.08 * (i % 2)))
            k.box((-x / 2, x / 2), (low, low + 0.03), (0, 0.04), DARK)
        k.box((-x * 0.3, x * 0.3), (-y / 2, y / 2), (0.1, 0.14), DARK)
        return
    plain(k)
