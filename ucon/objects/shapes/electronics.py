"""Screens, computers, sound, fans and printers."""

from __future__ import annotations

from ucon.objects.kit import Kit, shape
from ucon.objects.model import Material
from ucon.objects.palette import BLACK, DARK, GREY, SILVER, WHITE, shade
from ucon.objects.shapes.cabinets import hang_below

METAL = Material.METAL
SCREEN = (26, 32, 44)
GLOW = (86, 140, 190)


@shape("tv_panel")
def television(k: Kit) -> None:
    """A dark screen in a slim frame; the standing one has a foot."""
    x, y, z = k.size
    if k.name == "wall_mounted_tv":
        k.box((-x / 2, x * 0.3), (-y / 2, y / 2), (0, z), BLACK)
        k.box((x * 0.3, x / 2), (-y / 2 + 0.025, y / 2 - 0.025), (0.03, z - 0.025), SCREEN, Material.GLASS)
        k.surface((-x / 2, x / 2), (-y * 0.45, y * 0.45), z, 0.4)
        hang_below(k, 0.4)
        return
    foot = 0.1 * z
    k.box((-x / 2, x / 2), (-y * 0.26, y * 0.26), (0, 0.025), DARK)
    k.box((-0.03, 0.0), (-0.05, 0.05), (0.025, foot + 0.05), DARK)
    k.box((-0.02, 0.025), (-y / 2, y / 2), (foot, z), BLACK)
    k.box((0.025, 0.03), (-y / 2 + 0.02, y / 2 - 0.02), (foot + 0.025, z - 0.02), SCREEN, Material.GLASS)
    k.surface((-0.02, 0.025), (-y * 0.45, y * 0.45), z, 0.4)


@shape("monitor")
def monitor(k: Kit) -> None:
    """A screen on a column with a foot; its desktop glows."""
    x, y, z = k.size
    k.cyl((-x / 2, x / 2), (-y * 0.25, y * 0.25), (0, 0.02), SILVER, METAL)
    k.box((-0.04, -0.015), (-0.03, 0.03), (0.02, z * 0.5), SILVER, METAL)
    k.box((-0.015, 0.02), (-y / 2, y / 2), (0.28 * z, z), BLACK)
    k.box((0.02, 0.024), (-y / 2 + 0.015, y / 2 - 0.015), (0.28 * z + 0.02, z - 0.015), GLOW, Material.GLASS)
    k.box((0.024, 0.027), (-y * 0.4, -y * 0.05), (0.45 * z, 0.88 * z), WHITE)
    k.surface((-0.015, 0.02), (-y * 0.4, y * 0.4), z, 0.4)


@shape("laptop")
def laptop(k: Kit) -> None:
    """Open: base with keys, screen up at the back."""
    x, y, z = k.size
    base = 0.018
    k.box((-x / 2, x / 2), (-y / 2, y / 2), (0, base - 0.002), SILVER, METAL)
    k.box((-x * 0.36, x * 0.1), (-y * 0.42, y * 0.42), (base - 0.002, base), BLACK)
    k.box((x * 0.16, x * 0.44), (-y * 0.15, y * 0.15), (base - 0.002, base), GREY)
    k.box((-x / 2, -x / 2 + 0.012), (-y / 2, y / 2), (base, z), SILVER, METAL)
    k.box(
        (-x / 2 + 0.012, -x / 2 + 0.015),
        (-y / 2 + 0.012, y / 2 - 0.012),
        (base + 0.012, z - 0.01),
        GLOW,
        Material.GLASS,
    )
    k.surface((-x / 2 + 0.03, x / 2 - 0.005), (-y / 2 + 0.01, y / 2 - 0.01), base, 0.5)


@shape("speaker_box")
def speaker(k: Kit) -> None:
    """A dark box with round cones; a sound system has a display."""
    x, y, z = k.size
    k.box((-x / 2, x / 2 - 0.008), (-y / 2, y / 2), (0, z))
    if k.name == "sound_system":
        k.box((x / 2 - 0.008, x / 2), (-y * 0.2, y * 0.2), (0.55 * z, 0.85 * z), GLOW, Material.GLASS)
        radius, spots = 0.14 * y, ((-y * 0.34, 0.45 * z), (y * 0.34, 0.45 * z))
    else:
        radius, spots = min(0.36 * y, 0.2 * z), ((0.0, 0.3 * z), (0.0, 0.74 * z))
    for i, (cy, cz) in enumerate(spots):
        r = radius * (1.0 if i == 0 or k.name == "sound_system" else 0.7)
        k.cyl((x / 2 - 0.008, x / 2 - 0.004), (cy - r, cy + r), (cz - r, cz + r), (120, 122, 126), axis="x")
        k.cyl(
            (x / 2 - 0.004, x / 2), (cy - 0.7 * r, cy + 0.7 * r), (cz - 0.7 * r, cz + 0.7 * r), (44, 44, 48), axis="x"
        )
    if k.category.support:
        k.top_surface(0.005)
    hang_below(k, 0.3)


@shape("printer_box")
def printer(k: Kit) -> None:
    """A printer with paper in and out; a photocopier stands on the floor."""
    x, y, z = k.size
    copier = k.name == "photocopier"
    body = z if not copier else 0.92 * z
    front = x / 2 - 0.1
    k.box((-x / 2, front), (-y / 2, y / 2), (0, body * 0.9))
    k.box((-x / 2, front), (-y * 0.46, y * 0.46), (body * 0.9, z), DARK)
    k.box((front, x / 2), (-y * 0.3, y * 0.3), (0.2 * z, 0.25 * z), GREY)
    k.box((front, x / 2 - 0.02), (-y * 0.24, y * 0.24), (0.25 * z, 0.265 * z), WHITE, Material.PAPER)
    k.box((front, front + 0.01), (-y * 0.4, y * 0.4), (0.3 * z, 0.5 * z), BLACK)
    k.box((front, front + 0.02), (y * 0.2, y * 0.42), (0.66 * z, 0.8 * z), GLOW, Material.GLASS)
    if copier:
        for low in (0.03, 0.12):
            k.box((front, front + 0.02), (-y * 0.45, y * 0.45), (low * z, (low + 0.07) * z), shade(k.color, 0.8))
    k.surface((-x / 2 + 0.02, front - 0.02), (-y * 0.44, y * 0.44), z, 0.8)


@shape("fan_stand")
def fan(k: Kit) -> None:
    """A standing fan with blades; heater and dehumidifier are boxes with grilles."""
    x, y, z = k.size
    if k.name == "electric_fan":
        r = y / 2
        k.cyl((-x / 2, x / 2), (-x / 2, x / 2), (0, 0.04), (210, 212, 214))
        k.cyl((-0.02, 0.02), (-0.02, 0.02), (0.04, z - r), (210, 212, 214))
        k.cyl((-0.06, 0.04), (-r, r), (z - 2 * r, z), (176, 186, 194), axis="x")
        k.cyl((0.04, 0.05), (-0.9 * r, 0.9 * r), (z - 1.9 * r, z - 0.1 * r), (228, 232, 234), axis="x")
        for dy, dz in ((1, 0), (-0.5, 0.86), (-0.5, -0.86)):
            k.rod((0.06, 0.02, z - r), (0.06, dy * 0.75 * r, z - r + dz * 0.75 * r), (0.5 * r, 0.01), (70, 120, 190))
        k.cyl((0.05, 0.09), (-0.05, 0.05), (z - r - 0.05, z - r + 0.05), WHITE, axis="x")
        return
    k.unit()
    k.box((-0.5, 0.46), (-0.5, 0.5), (0.04, 1))
    k.box((-0.4, 0.4), (-0.4, 0.4), (0, 0.04), DARK)
    hot = k.name == "space_heater"
    k.box((0.46, 0.48), (-0.4, 0.4), (0.2, 0.8), (60, 40, 36) if hot else (206, 210, 214))
    for i in range(5):
        z0 = 0.24 + 0.11 * i
        k.box((0.48, 0.5), (-0.38, 0.38), (z0, z0 + 0.04), (230, 110, 50) if hot else GREY)
    k.box((0.0, 0.3), (-0.3, 0.3), (0.995, 1.01), DARK)


@shape("tripod")
def tripod(k: Kit) -> None:
    """Three legs with a camera on top."""
    k.unit()
    for dx, dy in ((0.48, 0.0), (-0.46, 0.48), (-0.46, -0.48)):
        k.rod((0, 0, 0.7), (dx, dy, 0.0), 0.028)
    k.cyl((-0.03, 0.03), (-0.03, 0.03), (0.6, 0.9), GREY)
    k.box((-0.07, 0.07), (-0.1, 0.1), (0.9, 1.0), BLACK)
    k.cyl((0.07, 0.16), (-0.04, 0.04), (0.92, 0.98), DARK, axis="x")
    x, y, z = k.size
    k.surface((-x * 0.05, x * 0.05), (-y * 0.05, y * 0.05), z)
