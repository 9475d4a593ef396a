"""Ovens, fridges, washers and cookers; those that open have a real interior."""

from __future__ import annotations

from itertools import pairwise

from ucon.objects.kit import Kit, shape
from ucon.objects.model import Material
from ucon.objects.palette import BLACK, DARK, GREY, RED, SILVER, shade
from ucon.objects.shapes.cabinets import hang_below
from ucon.objects.shapes.casework import BOARD, HANDLE, RIGHT_ANGLE, carcass, drop_door, leaves, seen_depth

Span = tuple[float, float]
FRONT = BOARD + HANDLE
LINER = (226, 230, 232)


@shape("fridge")
def fridge(k: Kit) -> None:
    """Fridge above, freezer below, each with a door of full width."""
    x, y, z = k.size
    front, split, plinth = x / 2, 0.34 * z, 0.05
    back = front - FRONT - 0.02
    k.box((-x / 2, back), (-y / 2, y / 2), (0, plinth), DARK)
    wall = 0.035
    ix, iy, iz = carcass(k, (-x / 2, back), (-y / 2, y / 2), (plinth, z), wall)
    k.box((ix[0], back), iy, (split - wall / 2, split + wall / 2), LINER)
    k.box((ix[0], ix[0] + 0.004), iy, iz, LINER)
    span = (-y / 2, y / 2)
    (lower,) = leaves(k, front, span, (plinth, split), shade(k.color, 0.9), pair=False, thickness=0.04)
    (upper,) = leaves(k, front, span, (split, z), shade(k.color, 1.05), pair=False, thickness=0.04)
    x0, edge = ix[0] + 0.004, ix[1] - 0.004
    deepest = edge - seen_depth(iz[0], split - wall / 2)
    k.space((max(x0, deepest), edge), iy, (iz[0], split - wall / 2), opened_by=(lower,))
    low, high = split + wall / 2, iz[1]
    levels = [low, low + (high - low) * 0.34, low + (high - low) * 0.64, high]
    for i, (bottom, top) in enumerate(pairwise(levels)):
        if i:
            k.box((x0, edge - 0.06), iy, (bottom - 0.012, bottom), (200, 222, 228), Material.GLASS)
        deepest = edge - seen_depth(bottom, top - 0.012, 0.06 if i < 2 else 0.0)
        k.space((max(x0, deepest), edge - 0.06 * (i > 0)), iy, (bottom, top - 0.012), opened_by=(upper,))
    k.top_surface(0.02, clearance=0.4)


def two_levels(k: Kit, x: Span, y: Span, z: Span, rack: float, thick: float, setback: float, joint: int) -> None:
    """The spaces above and below a rack whose top is at ``rack`` and which ends ``setback`` short of the front."""
    front = x[1] - 0.005
    deepest = max(x[0], front - seen_depth(rack, z[1]))
    k.space((deepest, front - setback), y, (rack, z[1]), opened_by=(joint,))
    deepest = max(x[0], front - seen_depth(z[0], rack - thick, setback))
    k.space((deepest, front), y, (z[0], rack - thick), opened_by=(joint,))


@shape("oven")
def oven(k: Kit) -> None:
    """Control panel with knobs, drop door with a window, one rack; a flat top."""
    x, y, z = k.size
    front = x / 2
    back = front - FRONT
    ix, iy, iz = carcass(k, (-x / 2, back), (-y / 2, y / 2), (0.1, z - 0.1), 0.03)
    k.box((-x / 2, back - 0.03), (-y / 2, y / 2), (0, 0.1), DARK)
    k.box((-x / 2, front - HANDLE), (-y / 2, y / 2), (z - 0.1, z), shade(k.color, 1.25), Material.METAL)
    for i in range(4):
        y0 = (-0.36 + 0.24 * i) * y
        k.cyl((front - HANDLE, front), (y0 - 0.02, y0 + 0.02), (z - 0.07, z - 0.03), SILVER, Material.METAL, axis="x")
    joint = drop_door(k, front, (-y / 2, y / 2), (0.1, z - 0.1), shade(k.color, 1.15), SILVER, (70, 76, 84))
    middle = (iz[0] + iz[1]) / 2
    k.box((ix[0], ix[1] - 0.1), iy, (middle - 0.01, middle), GREY, Material.METAL)
    two_levels(k, ix, iy, iz, middle, 0.01, 0.1, joint)
    k.top_surface(0.02)


@shape("dishwasher")
def dishwasher(k: Kit) -> None:
    """A drop door over the whole front, two racks."""
    x, y, z = k.size
    front = x / 2
    back = front - FRONT
    ix, iy, iz = carcass(k, (-x / 2, back), (-y / 2, y / 2), (0.08, z - 0.03), 0.025)
    k.box((-x / 2, back - 0.03), (-y / 2, y / 2), (0, 0.08), DARK)
    k.box((-x / 2, front - HANDLE), (-y / 2, y / 2), (z - 0.03, z), DARK)
    joint = drop_door(k, front, (-y / 2, y / 2), (0.08, z - 0.03), shade(k.color, 1.1))
    middle = (iz[0] + iz[1]) / 2
    k.box((ix[0], ix[1] - 0.1), iy, (middle - 0.012, middle), (120, 150, 190), Material.METAL)
    two_levels(k, ix, iy, iz, middle, 0.012, 0.1, joint)
    k.top_surface(0.02)


@shape("washer", "clothes_dryer")
def front_loader(k: Kit) -> None:
    """A white cube with a round door; behind it is a square opening that the door's rim covers completely."""
    x, y, z = k.size
    dryer = k.name == "clothes_dryer"
    front = x / 2
    face = front - 0.05
    middle, mouth, radius = 0.52 * z, 0.15, 0.235
    k.box((-x / 2, -x / 2 + BOARD), (-y / 2, y / 2), (0, z))
    for side in (-1, 1):
        edge = (side * y / 2, side * (y / 2 - 0.06))
        k.box((-x / 2 + BOARD, face - BOARD), (min(edge), max(edge)), (0, z))
    inner_y = (-y / 2 + 0.06, y / 2 - 0.06)
    floor, ceiling = middle - mouth - 0.02, middle + mouth + 0.06
    k.box((-x / 2 + BOARD, face - BOARD), inner_y, (0, floor), SILVER)
    k.box((-x / 2 + BOARD, face - BOARD), inner_y, (ceiling, z))
    for low, high in ((0, middle - mouth), (middle + mouth, z)):
        k.box((face - BOARD, face), (-y / 2, y / 2), (low, high))
    for low, high in ((-y / 2, -mouth), (mouth, y / 2)):
        k.box((face - BOARD, face), (low, high), (middle - mouth, middle + mouth))
    k.box((face, face + 0.006), (-y / 2 + 0.02, y / 2 - 0.02), (z - 0.11, z - 0.02), GREY if dryer else (206, 212, 218))
    k.cyl((face + 0.006, face + 0.03), (y * 0.25, y * 0.25 + 0.06), (z - 0.1, z - 0.04), DARK, axis="x")
    joint = k.hinge((face + 0.03, radius, middle), (0.0, 0.0, 1.0), RIGHT_ANGLE)
    round_z = (middle - radius, middle + radius)
    k.cyl((face, face + 0.03), (-radius, radius), round_z, (170, 174, 180), Material.METAL, axis="x", link=joint)
    glass = radius * 0.7
    k.cyl((face + 0.03, front), (-glass, glass), (middle - glass, middle + glass), (52, 60, 72), Material.GLASS,
          axis="x", taper=0.85, link=joint)  # fmt: skip
    deepest = max(-x / 2 + BOARD, face - BOARD - seen_depth(floor, middle + mouth))
    k.space((deepest, face - BOARD - 0.002), (-mouth - 0.02, mouth + 0.02), (floor, ceiling), opened_by=(joint,))
    k.top_surface(0.01)


@shape("microwave", "toaster_oven")
def counter_oven(k: Kit) -> None:
    """A box with a dark window on the left and controls on the right."""
    x, y, z = k.size
    front = x / 2
    back = front - 0.016 - 0.012
    split = y * 0.24
    k.box((-x / 2, back), (split, y / 2), (0, z))
    k.box((back, front - 0.012), (split, y / 2), (0, z), shade(k.color, 1.15))
    for i in range(2):
        z0 = z * (0.2 + 0.34 * i)
        k.cyl((front - 0.012, front), (split + 0.03, y / 2 - 0.03), (z0, z0 + 0.05), SILVER, axis="x")
    ix, iy, iz = carcass(k, (-x / 2, back), (-y / 2, split), (0, z), 0.014)
    window = (44, 48, 54) if k.name == "microwave" else (78, 58, 44)
    if k.name == "microwave":
        (joint,) = leaves(k, front, (-y / 2, split), (0, z), shade(k.color, 1.25), pair=False, hinge_low_y=True,
                          handle=SILVER, thickness=0.016)  # fmt: skip
        k.box((front - 0.012, front - 0.008), (-y / 2 + 0.04, split - 0.07), (z * 0.2, z * 0.85), window,
              Material.GLASS, link=joint)  # fmt: skip
    else:
        joint = drop_door(k, front, (-y / 2, split), (0, z), None, DARK, window)
    k.space((ix[0], ix[1] - 0.01), iy, iz, opened_by=(joint,))
    k.top_surface(0.015)


@shape("stove")
def stove(k: Kit) -> None:
    """Four dark burners on a steel top, knobs, an oven window."""
    x, y, z = k.size
    front = x / 2
    body = (86, 88, 92)
    top = z - 0.02
    k.box((-x / 2, front - 0.02), (-y / 2, y / 2), (0.04, top), body, Material.METAL)
    k.box((-x / 2, front - 0.05), (-y / 2 + 0.02, y / 2 - 0.02), (0, 0.04), BLACK)
    k.box((-x / 2, front), (-y / 2, y / 2), (top - 0.03, top), SILVER, Material.METAL)
    k.box((front - 0.02, front - 0.012), (-y * 0.42, y * 0.42), (0.15 * z, 0.68 * z), (34, 36, 42), Material.GLASS)
    k.box((front - 0.02, front), (-y * 0.4, y * 0.4), (0.72 * z, 0.75 * z), SILVER, Material.METAL)
    for i in range(4):
        y0 = (-0.36 + 0.24 * i) * y
        k.cyl((front - 0.02, front), (y0 - 0.022, y0 + 0.022), (0.82 * z, 0.82 * z + 0.044), BLACK, axis="x")
    burners(k, (-x / 2, front), top, z)
    k.surface((-x / 2 + 0.03, front - 0.03), (-y / 2 + 0.03, y / 2 - 0.03), z)


def burners(k: Kit, x: tuple[float, float], low: float, high: float) -> None:
    """Four round dark plates."""
    depth, width = x[1] - x[0], k.size[1]
    radius = 0.19 * min(depth, width)
    for fx in (0.27, 0.73):
        for fy in (-0.24, 0.24):
            cx, cy = x[0] + fx * depth, fy * width
            k.cyl((cx - radius, cx + radius), (cy - radius, cy + radius), (low, high), (36, 36, 38), Material.METAL)


@shape("burner")
def hob(k: Kit) -> None:
    """A hob plate with four burners."""
    x, y, z = k.size
    k.box((-x / 2, x / 2), (-y / 2, y / 2), (0, z - 0.015), SILVER, Material.METAL)
    burners(k, (-x / 2, x / 2), z - 0.015, z)
    k.top_surface(0.02)


@shape("deep_fryer")
def deep_fryer(k: Kit) -> None:
    """A steel cabinet with two dark oil basins."""
    x, y, z = k.size
    k.box((-x / 2, x / 2 - 0.02), (-y / 2, y / 2), (0, 0.86 * z), SILVER, Material.METAL)
    k.box((-x / 2, -x / 2 + 0.08), (-y / 2, y / 2), (0.86 * z, z), SILVER, Material.METAL)
    for side in (-1, 1):
        y0 = side * y * 0.23
        k.box((-x * 0.3, x * 0.4), (y0 - 0.18 * y, y0 + 0.18 * y), (0.86 * z, 0.88 * z), (60, 44, 26))
        k.box((x / 2 - 0.02, x / 2), (y0 - 0.15 * y, y0 + 0.15 * y), (0.2 * z, 0.6 * z), GREY, Material.METAL)
    k.surface((-x * 0.3, x * 0.4), (-y * 0.45, y * 0.45), 0.88 * z)


@shape("grill")
def indoor_grill(k: Kit) -> None:
    """A cooking grate on a stand with side panels and a low shelf."""
    x, y, z = k.size
    k.box((-x / 2, x / 2 - 0.03), (-y / 2, y / 2), (0.55 * z, 0.86 * z), BLACK, Material.METAL)
    for i in range(5):
        x0 = (-0.42 + 0.19 * i) * x
        k.box((x0, x0 + 0.08 * x), (-y * 0.46, y * 0.46), (0.86 * z, 0.9 * z), GREY, Material.METAL)
    k.box((-x / 2, -x / 2 + 0.04), (-y / 2, y / 2), (0.86 * z, z), DARK, Material.METAL)
    for fx in (-0.44, 0.44):
        for fy in (-0.44, 0.44):
            k.box((fx * x - 0.03, fx * x + 0.03), (fy * y - 0.03, fy * y + 0.03), (0, 0.55 * z), DARK, Material.METAL)
    for fy in (-0.3, 0.0, 0.3):
        k.cyl((x / 2 - 0.03, x / 2), (fy * y - 0.03, fy * y + 0.03), (0.66 * z, 0.66 * z + 0.06), RED, axis="x")
    k.surface((-x * 0.42, x * 0.48), (-y * 0.46, y * 0.46), 0.9 * z)


@shape("grill_outdoor")
def charcoal_grill(k: Kit) -> None:
    """A kettle grill on three legs with a side table."""
    x, y, z = k.size
    r = x * 0.46
    cy = -y * 0.14
    k.ball((-r, r), (cy - r, cy + r), (0.52 * z, z * 0.97), BLACK, Material.METAL)
    k.box((-0.04, 0.04), (cy - 0.08, cy + 0.08), (0.95 * z, z), (130, 90, 50), Material.WOOD)
    k.cyl((-r, r), (cy - r, cy + r), (0.72 * z, 0.75 * z), GREY, Material.METAL)
    for dx, dy in ((-0.9, 0.8), (-0.9, -0.8), (0.9, 0.0)):
        k.rod((dx * r * 0.5, cy + dy * r * 0.5, 0.6 * z), (dx * r, cy + dy * r, 0.02), 0.03, DARK, Material.METAL)
    for side in (-1, 1):
        yy = cy + side * r * 0.8
        k.cyl((-0.5 * x, -0.5 * x + 0.16), (yy - 0.02, yy + 0.02), (0, 0.16), BLACK, axis="y")
    k.box((-0.5 * x, 0.5 * x), (y * 0.32, y / 2), (0.68 * z, 0.71 * z), (150, 106, 64), Material.WOOD)
    for fx in (-0.42, 0.42):
        k.box((fx * x - 0.02, fx * x + 0.02), (y * 0.46, y / 2), (0, 0.68 * z), DARK, Material.METAL)
    k.box((-0.02, 0.02), (-y / 2, -y / 2 + 0.05), (0.7 * z, 0.74 * z), DARK)


@shape("range_hood")
def range_hood(k: Kit) -> None:
    """A steel canopy with a chimney."""
    x, y, z = k.size
    k.box((-x / 2, x / 2), (-y / 2, y / 2), (0, 0.16 * z), SILVER, Material.METAL)
    k.wedge((-x * 0.1, x / 2), (-y / 2, y / 2), (0.16 * z, 0.5 * z), shade(SILVER, 0.9), Material.METAL, flip=True)
    k.box((-x / 2, -x * 0.1), (-y / 2, y / 2), (0.16 * z, 0.5 * z), shade(SILVER, 0.9), Material.METAL)
    k.box((-x / 2, 0.0), (-y * 0.2, y * 0.2), (0.5 * z, z), shade(SILVER, 0.95), Material.METAL)
    hang_below(k, 0.4)
