"""Tables, desks, counters and the nightstand."""

from __future__ import annotations

from ucon.objects.kit import Kit, shape
from ucon.objects.model import Material
from ucon.objects.palette import DARK, GOLD, shade

CUSHION = Material.FABRIC
BOARD = 0.02


def legs(k: Kit, top: float, thick: float, inset: float = 0.02, material: Material | None = None) -> None:
    """Four square legs from the floor to ``top``."""
    x, y, _ = k.size
    for sx in (-1, 1):
        for sy in (-1, 1):
            a, b = sx * (x / 2 - inset), sx * (x / 2 - inset - thick)
            c, d = sy * (y / 2 - inset), sy * (y / 2 - inset - thick)
            k.box((min(a, b), max(a, b)), (min(c, d), max(c, d)), (0, top), shade(k.color, 0.8), material or k.material)


def under_all(k: Kit, top: float, inset: float) -> None:
    """The space between the legs, from edge to edge."""
    x, y, _ = k.size
    k.below((-x / 2 + inset, x / 2 - inset), (-y / 2 + inset, y / 2 - inset), top)


@shape("dessert_stand")
def dessert_stand(k: Kit) -> None:
    """A white stand with two round-edged tiers."""
    x, y, z = k.size
    low = 0.45 * z
    k.box((-x / 2, x / 2), (-y / 2, y / 2), (low - 0.03, low))
    legs(k, low - 0.03, 0.04)
    for s in (-1, 1):
        k.cyl((-0.015, 0.015), (s * y * 0.24 - 0.015, s * y * 0.24 + 0.015), (low, z - 0.03), GOLD, Material.METAL)
    k.box((-x * 0.3, x * 0.3), (-y * 0.36, y * 0.36), (z - 0.03, z), shade(k.color, 0.96))
    k.surface((-x * 0.29, x * 0.29), (-y * 0.35, y * 0.35), z)
    k.below((-x / 2 + 0.07, x / 2 - 0.07), (-y / 2 + 0.07, y / 2 - 0.07), low - 0.03)


@shape("breakfast_table", "conference_table", "console_table", "stand", "coffee_table")
def table(k: Kit) -> None:
    """A top on four legs; a coffee table and a side table have a low board."""
    x, y, z = k.size
    slab = 0.035 if z > 0.3 else 0.02
    thick = min(0.06, 0.09 * min(x, y))
    k.box((-x / 2, x / 2), (-y / 2, y / 2), (z - slab, z))
    legs(k, z - slab, thick)
    if k.name in ("coffee_table", "stand") and z > 0.3:
        low = 0.14 if k.name == "coffee_table" else 0.2
        # Only the rear two thirds: the floor in front stays free for things under the table.
        k.box((-x / 2 + 0.02, x * 0.12), (-y / 2 + 0.03, y / 2 - 0.03), (low - 0.018, low), shade(k.color, 0.9))
        k.space((-x / 2 + 0.03, x * 0.12), (-y / 2 + 0.09, y / 2 - 0.09), (low, z - slab))
        k.below((x * 0.12, x / 2 - 0.01), (-y / 2 + 0.09, y / 2 - 0.09), z - slab)
    else:
        apron = 0.06
        for sx in (-1, 1):
            a, b = sx * (x / 2 - 0.03), sx * (x / 2 - 0.05)
            k.box(
                (min(a, b), max(a, b)), (-y / 2 + 0.05, y / 2 - 0.05), (z - slab - apron, z - slab), shade(k.color, 0.8)
            )
        if k.name == "console_table":
            k.box((-x / 2 + 0.03, x / 2 - 0.03), (-y / 2 + 0.03, y / 2 - 0.03), (0.3, 0.32), shade(k.color, 0.9))
            k.space((-x / 2 + 0.05, x / 2 - 0.03), (-y / 2 + 0.09, y / 2 - 0.09), (0.32, z - slab - apron))
            k.below((-x / 2 + 0.02, x / 2 - 0.02), (-y / 2 + 0.07, y / 2 - 0.07), 0.3)
        elif k.name == "conference_table":
            k.box((-x * 0.3, x * 0.3), (-y * 0.3, y * 0.3), (0.35, 0.37), shade(k.color, 0.9))
            k.box((-x * 0.05, x * 0.05), (-y * 0.25, y * 0.25), (0, 0.35), shade(k.color, 0.7))
            k.space((-x * 0.3, x * 0.3), (-y * 0.3, y * 0.3), (0.37, z - slab - apron))
            k.below((x * 0.3, x / 2 - 0.06), (-y / 2 + 0.09, y / 2 - 0.09), z - slab - apron)
            k.below((-x / 2 + 0.06, -x * 0.3), (-y / 2 + 0.09, y / 2 - 0.09), z - slab - apron)
        else:
            under_all(k, z - slab - apron, 0.03 + thick)
    k.top_surface(0.01)


@shape("pedestal_table")
def pedestal_table(k: Kit) -> None:
    """A round top on one foot."""
    x, y, z = k.size
    k.cyl((-x / 2, x / 2), (-y / 2, y / 2), (z - 0.035, z))
    k.cyl((-0.05, 0.05), (-0.05, 0.05), (0.03, z - 0.035), shade(k.color, 0.75))
    k.cyl((-x * 0.26, x * 0.26), (-y * 0.26, y * 0.26), (0, 0.03), shade(k.color, 0.75))
    half = 0.345
    k.surface((-x * half, x * half), (-y * half, y * half), z)
    k.below((x * 0.26, x * 0.44), (-y * 0.2, y * 0.2), z - 0.035)
    k.below((-x * 0.44, -x * 0.26), (-y * 0.2, y * 0.2), z - 0.035)
    k.below((-x * 0.2, x * 0.2), (y * 0.26, y * 0.44), z - 0.035)
    k.below((-x * 0.2, x * 0.2), (-y * 0.44, -y * 0.26), z - 0.035)


@shape("desk")
def desk(k: Kit) -> None:
    """Legs on one side, open cubbies on the other; the person sits at the front."""
    x, y, z = k.size
    slab, wide = 0.03, min(0.4, 0.34 * y)
    k.box((-x / 2, x / 2), (-y / 2, y / 2), (z - slab, z))
    k.box((-x / 2 + 0.02, x / 2 - 0.02), (-y / 2, -y / 2 + BOARD), (0, z - slab), shade(k.color, 0.85))
    y0, y1 = y / 2 - wide, y / 2
    x0, x1 = -x / 2 + 0.02, x / 2 - 0.02
    k.box((x0, x1), (y0, y0 + BOARD), (0, z - slab), shade(k.color, 0.85))
    k.box((x0, x1), (y1 - BOARD, y1), (0, z - slab), shade(k.color, 0.85))
    k.box((x0, x0 + BOARD), (y0 + BOARD, y1 - BOARD), (0, z - slab), shade(k.color, 0.7))
    inner = (y0 + BOARD, y1 - BOARD)
    levels = (0.06, 0.06 + (z - slab - 0.06) * 0.52)
    for low, high in zip(levels, (levels[1] - BOARD, z - slab), strict=True):
        depth = x1 - 0.01 if low < 0.1 else x1 - 0.08
        k.box((x0 + BOARD, depth), inner, (low - BOARD, low), shade(k.color, 0.9))
        k.space((x0 + BOARD, depth), inner, (low, high))
    k.box((-x / 2 + 0.02, -x / 2 + 0.035), (-y / 2 + BOARD, y0), (z * 0.5, z - slab), shade(k.color, 0.75))
    k.top_surface(0.01)
    k.below((-x / 2 + 0.05, x / 2 - 0.03), (-y / 2 + 0.03, y0 - 0.01), z * 0.5)


@shape("pool_table")
def pool_table(k: Kit) -> None:
    """Green cloth between wooden rails, thick legs, a few balls."""
    x, y, z = k.size
    bed, rail = z * 0.93, 0.09
    wood = (116, 72, 42)
    k.box((-x / 2 + rail, x / 2 - rail), (-y / 2 + rail, y / 2 - rail), (bed - 0.06, bed), (40, 120, 70), CUSHION)
    for s in (-1, 1):
        a, b = sorted((s * x / 2, s * (x / 2 - rail)))
        k.box((a, b), (-y / 2, y / 2), (bed - 0.14, z), wood, Material.WOOD)
        a, b = sorted((s * y / 2, s * (y / 2 - rail)))
        k.box((-x / 2 + rail, x / 2 - rail), (a, b), (bed - 0.14, z), wood, Material.WOOD)
        for t in (-1, 1):
            a, b = sorted((s * (x / 2 - 0.03), s * (x / 2 - 0.17)))
            c, d = sorted((t * (y / 2 - 0.05), t * (y / 2 - 0.19)))
            k.box((a, b), (c, d), (0, bed - 0.14), shade(wood, 0.8), Material.WOOD)
    k.surface((-x / 2 + rail, x / 2 - rail), (-y / 2 + rail, y / 2 - rail), bed)
    under_all(k, bed - 0.14, 0.19)


@shape("bar", "checkout_counter", "reception_desk")
def service_counter(k: Kit) -> None:
    """A closed front towards the guests (-x), an open shelf towards the staff (+x)."""
    x, y, z = k.size
    slab = 0.04
    k.box(
        (-x / 2, x / 2), (-y / 2, y / 2), (z - slab, z), shade(k.color, 0.75) if k.name != "checkout_counter" else DARK
    )
    back = -x / 2 + 0.06
    k.box((back, back + 0.03), (-y / 2 + 0.04, y / 2 - 0.04), (0, z - slab))
    for s in (-1, 1):
        a, b = sorted((s * (y / 2 - 0.04), s * (y / 2 - 0.07)))
        k.box((back + 0.03, x / 2 - 0.06), (a, b), (0, z - slab))
    inner = (-y / 2 + 0.07, y / 2 - 0.07)
    for low, high in ((0.08, z * 0.5 - 0.02), (z * 0.5, z - slab)):
        k.box((back + 0.03, x / 2 - 0.08), inner, (low - 0.02, low), shade(k.color, 0.85))
        k.space((back + 0.03, x / 2 - 0.08), inner, (low, high))
    k.top_surface(0.02)


@shape("counter_slab")
def countertop(k: Kit) -> None:
    """A base unit of any length: stone slab on a closed body with the seams of doors."""
    x, y, z = k.size
    front, body = x / 2, (222, 220, 214)
    if z < 0.3:  # a bare slab, laid on cabinets that stand below it
        k.box((-x / 2, front), (-y / 2, y / 2), (0, z), k.color, Material.CONCRETE)
        k.top_surface(0.01)
        return
    k.box((-x / 2, front), (-y / 2, y / 2), (z - 0.04, z), k.color, Material.CONCRETE)
    k.box((-x / 2, front - 0.03), (-y / 2, y / 2), (0.1, z - 0.04), body)
    k.box((-x / 2, front - 0.08), (-y / 2, y / 2), (0, 0.1), DARK)
    count = max(1, min(6, round(y / 0.55)))
    width = y / count
    for i in range(count):
        low = -y / 2 + i * width
        k.box((front - 0.03, front - 0.012), (low + 0.008, low + width - 0.008), (0.11, z - 0.055), shade(body, 0.93))
        k.box((front - 0.012, front - 0.002), (low + width / 2 - 0.06, low + width / 2 + 0.06), (z - 0.12, z - 0.105),
              DARK, Material.METAL)  # fmt: skip
    k.top_surface(0.01)


@shape("nightstand")
def nightstand(k: Kit) -> None:
    """A drawer front above an open cubby, on short legs."""
    x, y, z = k.size
    leg, slab = 0.11, 0.02
    panel = z - slab - 0.12
    x1 = x / 2 - 0.012
    k.box((-x / 2, x / 2), (-y / 2, y / 2), (z - slab, z))
    k.box((-x / 2, x1), (-y / 2 + 0.01, y / 2 - 0.01), (panel, z - slab), shade(k.color, 0.92))
    k.box((x1, x1 + 0.006), (-y / 2 + 0.03, y / 2 - 0.03), (panel + 0.015, z - slab - 0.01), shade(k.color, 1.15))
    k.box((x1 + 0.006, x / 2), (-0.05, 0.05), (z - slab - 0.07, z - slab - 0.05), DARK, Material.METAL)
    for s in (-1, 1):
        a, b = sorted((s * (y / 2 - 0.01), s * (y / 2 - 0.03)))
        k.box((-x / 2, x1), (a, b), (leg, panel), shade(k.color, 0.92))
    inner = (-y / 2 + 0.03, y / 2 - 0.03)
    k.box((-x / 2, -x / 2 + 0.015), inner, (leg, panel), shade(k.color, 0.7))
    k.box((-x / 2, x1), (-y / 2 + 0.01, y / 2 - 0.01), (leg - 0.02, leg), shade(k.color, 0.92))
    k.space((-x / 2 + 0.015, x1 - 0.005), inner, (leg, panel))
    for sx in (-1, 1):
        for sy in (-1, 1):
            a, b = sorted((sx * (x / 2 - 0.02), sx * (x / 2 - 0.05)))
            c, d = sorted((sy * (y / 2 - 0.02), sy * (y / 2 - 0.05)))
            k.box((a, b), (c, d), (0, leg - 0.02), shade(k.color, 0.6))
    k.below((-x / 2 + 0.05, x / 2 - 0.05), (-y / 2 + 0.05, y / 2 - 0.05), leg - 0.02)
    k.top_surface(0.01)
