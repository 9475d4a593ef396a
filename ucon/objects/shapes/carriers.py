"""Baskets, bins, buckets, bags and crates."""

from __future__ import annotations

from ucon.objects.kit import Kit, shape
from ucon.objects.model import Material
from ucon.objects.palette import BLACK, DARK, GREEN, GREY, RED, RGB, SILVER, WHITE, shade
from ucon.objects.shapes.casework import tub
from ucon.objects.shapes.generic import OPEN_TOP_HEADROOM, open_box, ring
from ucon.objects.shapes.hollow import round_space


@shape("basket")
def basket(k: Kit) -> None:
    """Woven walls with a darker rim and bands; a shopping basket has a handle."""
    x, y, z = k.size
    shop, hanging = k.name == "shopping_basket", k.name == "hanging_basket"
    top = z * (0.62 if shop else 0.45 if hanging else 1.0)
    floor = 0.3 * z if z > 0.45 and not hanging else 0.02
    weave = k.material if shop or hanging else Material.FABRIC
    k.material = weave
    body = top - 0.025
    inset = 0.012
    ix, iy = tub(k, (-x / 2 + inset, x / 2 - inset), (-y / 2 + inset, y / 2 - inset), (0, body), 0.012, floor,
                 inside=shade(k.color, 0.7))  # fmt: skip
    rim = shade(k.color, 0.68)
    for s in (-1, 1):
        a, b = sorted((s * x / 2, s * (x / 2 - 0.024)))
        k.box((a, b), (-y / 2, y / 2), (body, top), rim, weave)
        c, d = sorted((s * y / 2, s * (y / 2 - 0.024)))
        k.box((-x / 2 + 0.024, x / 2 - 0.024), (c, d), (body, top), rim, weave)
    if shop:
        k.path(
            [(0, -y / 2 + 0.01, top), (0, -y * 0.4, z - 0.01), (0, y * 0.4, z - 0.01), (0, y / 2 - 0.01, top)],
            0.016,
            BLACK,
        )
    elif hanging:
        for s in (-1, 1):
            k.rod((0, s * (y / 2 - 0.02), top), (0, s * 0.01, z - 0.005), 0.01, DARK)
        k.ball((-x * 0.3, x * 0.1), (y * 0.15, y * 0.42), (top * 0.6, top * 1.35), GREEN, Material.PLANT)
    else:
        for s in (-1, 1):
            a, b = sorted((s * (x / 2 - inset), s * (x / 2 - 0.004)))
            k.box((a, b), (-y / 2 + 0.02, y / 2 - 0.02), (body * 0.42, body * 0.55), rim, weave)
            c, d = sorted((s * (y / 2 - inset), s * (y / 2 - 0.004)))
            k.box((-x / 2 + 0.02, x / 2 - 0.02), (c, d), (body * 0.42, body * 0.55), rim, weave)
    if hanging:
        iy = (iy[0], 0.0)
    k.space((ix[0] + 0.012, ix[1] - 0.012), (iy[0] + 0.012, iy[1] - 0.012),
            (floor, floor + (top - floor) * (1.0 if shop or hanging else OPEN_TOP_HEADROOM)))  # fmt: skip


@shape("bin")
def trash_can(k: Kit) -> None:
    """A round bin, or a wheeled square one; the floor is raised so that a person can see what lies on it."""
    x, y, z = k.size
    if k.name == "compost_bin":
        floor = 0.4 * z
        open_box(k, 0.015, z=(floor - 0.015, z))
        k.box((-x / 2, x / 2), (-y / 2, y / 2), (0, floor - 0.015), shade(k.color, 0.9))
        k.box((x / 2 - 0.004, x / 2 + 0.0005), (-y * 0.25, y * 0.25), (0.2 * z, 0.45 * z), (120, 190, 90))
        return
    floor = 0.3 * z
    ring(k, x / 2, y / 2, (floor, z), 0.012)
    k.cyl((-x / 2, x / 2), (-y / 2, y / 2), (0, floor), shade(k.color, 0.92))
    k.cyl((-x * 0.45, x * 0.45), (-y * 0.45, y * 0.45), (floor, floor + 0.004), shade(k.color, 0.45))
    round_space(k, x / 2 - 0.02, y / 2 - 0.02, floor + 0.004, z)


@shape("bucket")
def bucket(k: Kit) -> None:
    """A round bucket with its bail standing up."""
    x, y, z = k.size
    steel = k.name == "ice_bucket"
    top, floor = z * (1.0 if steel else 0.78), 0.04
    ring(k, x * 0.47, y * 0.47, (floor, top), 0.008)
    k.cyl((-x * 0.42, x * 0.42), (-y * 0.42, y * 0.42), (0, floor), shade(k.color, 0.6))
    if steel:
        for s in (-1, 1):
            c, d = sorted((s * y / 2, s * y * 0.45))
            k.box((-0.05, 0.05), (c, d), (top * 0.7, top * 0.8), SILVER, Material.METAL)
        k.box((-x / 2, -x * 0.44), (-0.03, 0.03), (top * 0.5, top * 0.6), SILVER, Material.METAL)
        k.cyl((x * 0.44, x / 2), (-0.03, 0.03), (top * 0.5, top * 0.6), SILVER, axis="x")
    else:
        bail = [(-0.46, top - 0.02), (-0.34, z - 0.01), (0.34, z - 0.01), (0.46, top - 0.02)]
        k.path([(0, fy * y, fz) for fy, fz in bail], 0.012, GREY, Material.METAL)
        k.box((-0.03, 0.03), (-0.05, 0.05), (z - 0.022, z), WHITE)
        for s in (-1, 1):
            a, b = sorted((s * x / 2, s * x * 0.44))
            k.box((a, b), (-0.05, 0.05), (top - 0.03, top), shade(k.color, 0.8))
            c, d = sorted((s * y / 2, s * y * 0.44))
            k.box((-0.04, 0.04), (c, d), (top - 0.03, top), shade(k.color, 0.8))
    round_space(k, x * 0.47 - 0.012, y * 0.47 - 0.012, floor, top)
    if not steel:
        box = k.compartments.pop().box
        k.space((box[0], box[3]), (box[1], box[4]), (floor, top))


@shape("bag_handle")
def handle_bag(k: Kit) -> None:
    """An open bag with two handles; the paper bag is stiff, the tote is cloth."""
    x, y, z = k.size
    top = z * (0.78 if k.name == "paper_bag" else 0.66)
    material = Material.PAPER if k.name == "paper_bag" else Material.FABRIC
    k.material = material
    ix, iy = tub(k, (-x / 2 + 0.004, x / 2 - 0.004), (-y / 2, y / 2), (0, top), 0.006, 0.01, inside=shade(k.color, 0.6))
    for s in (-1, 1):
        xx = s * (x / 2 - 0.006)
        loop = [(-0.25, top - 0.02), (-0.2, z - 0.005), (0.2, z - 0.005), (0.25, top - 0.02)]
        k.path([(xx, fy * y, fz) for fy, fz in loop], 0.01, shade(k.color, 0.7), material)
    if k.name == "shoulder_bag":
        k.box((x / 2 - 0.004, x / 2), (-y * 0.5, y * 0.5), (top * 0.5, top * 0.56), shade(k.color, 0.6))
        k.box((x / 2 - 0.004, x / 2), (-0.02, 0.02), (top * 0.42, top * 0.64), (208, 168, 62), Material.METAL)
    else:
        k.box((x / 2 - 0.004, x / 2), (-y * 0.22, y * 0.22), (top * 0.35, top * 0.65), shade(k.color, 0.75), material)
    k.space(ix, iy, (0.01, 0.01 + (top - 0.01) * 1.25))


@shape("backpack")
def backpack(k: Kit) -> None:
    """A standing backpack, open at the top: front pocket, straps at the back, flap folded behind."""
    x, y, z = k.size
    body = z * 0.86
    x0, x1 = -x / 2 + 0.03, x / 2 - 0.06
    floor = 0.12 * z
    ix, iy = tub(k, (x0, x1), (-y / 2 + 0.015, y / 2 - 0.015), (0, body), 0.008, floor, inside=shade(k.color, 0.5))
    k.box((x1, x / 2), (-y * 0.36, y * 0.36), (0.04, z * 0.5), shade(k.color, 1.2))
    k.box((x1, x / 2 - 0.02), (-y * 0.3, y * 0.3), (z * 0.53, z * 0.56), SILVER, Material.METAL)
    for s in (-1, 1):
        c, d = sorted((s * 0.04, s * 0.09))
        k.box((-x / 2, x0), (c, d), (0.06, z * 0.8), BLACK, Material.FABRIC)
        c, d = sorted((s * y / 2, s * (y / 2 - 0.015)))
        k.box((x0 + 0.03, x1 - 0.03), (c, d), (0.02, z * 0.3), shade(k.color, 0.75))
    k.box((x0 - 0.02, x0), (-y * 0.4, y * 0.4), (z * 0.8, z * 0.97), shade(k.color, 0.85))
    k.box((x0 - 0.01, x0 + 0.004), (-0.05, 0.05), (z * 0.97, z), BLACK)
    k.space(ix, iy, (floor, body * 1.1))


@shape("toy_box", "litter_box", "crate_open")
def crate(k: Kit) -> None:
    """Open boxes: a toy box with coloured panels, a litter tray, crates of fruit."""
    x, y, z = k.size
    if k.name == "toy_box":
        open_box(k, 0.018, floor_color=shade(k.color, 0.6))
        for i, color in enumerate((RED, (60, 120, 190), GREEN)):
            y0 = (-0.32 + 0.24 * i) * y
            k.box((x / 2 - 0.001, x / 2), (y0, y0 + 0.16 * y), (0.3 * z, 0.7 * z), color)
        k.surfaces.clear()
        return
    if k.name == "litter_box":
        open_box(k, 0.02, z=(0.0, 0.32 * z), floor_color=(206, 196, 176))
        k.box((-x / 2, -x / 2 + 0.02), (-y / 2, y / 2), (0.32 * z, z))
        for s in (-1, 1):
            c, d = sorted((s * y / 2, s * (y / 2 - 0.02)))
            k.box((-x / 2 + 0.02, x * 0.1), (c, d), (0.32 * z, z))
        k.box((-x / 2 + 0.02, x * 0.1), (-y / 2 + 0.02, y / 2 - 0.02), (z - 0.02, z))
        return
    fruit: RGB = {"box_of_lemons": (240, 214, 60), "box_of_raspberries": (180, 30, 60)}.get(k.name, (232, 130, 36))
    k.unit()
    wood = (186, 146, 96)
    for s in (-1, 1):
        a, b = sorted((s * 0.5, s * 0.44))
        k.box((a, b), (-0.5, 0.5), (0, 0.72), wood, Material.WOOD)
        c, d = sorted((s * 0.5, s * 0.46))
        k.box((-0.44, 0.44), (c, d), (0, 0.72), wood, Material.WOOD)
    k.box((-0.44, 0.44), (-0.46, 0.46), (0, 0.5), shade(fruit, 0.6))
    for i in range(6):
        x0, y0 = -0.42 + 0.42 * (i % 2), -0.45 + 0.3 * (i // 2)
        k.ball((x0, x0 + 0.42), (y0, y0 + 0.3), (0.3, 1.0), fruit)
