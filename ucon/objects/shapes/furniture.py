"""Tables, seats, beds, shelves: furniture without joints."""

from __future__ import annotations

from ucon.objects.kit import BLACK, DARK, GOLD, GREY, RED, SILVER, WHITE, Kit, shade, shape
from ucon.objects.model import Material
from ucon.objects.shapes.cabinets import hang_below
from ucon.objects.shapes.generic import open_box

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


@shape("bed")
def bed(k: Kit) -> None:
    """Headboard at the back, mattress, blanket, two pillows; free below the frame."""
    x, y, z = k.size
    seat = min(0.55, 0.6 * z)
    clear = min(0.28, 0.5 * seat)
    wood = (136, 94, 60)
    k.box((-x / 2, -x / 2 + 0.06), (-y / 2, y / 2), (0, z), wood, Material.WOOD)
    k.box((-x / 2 + 0.06, x / 2 - 0.03), (-y / 2 + 0.01, y / 2 - 0.01), (clear, clear + 0.08), wood, Material.WOOD)
    k.box(
        (-x / 2 + 0.06, x / 2 - 0.05),
        (-y / 2 + 0.02, y / 2 - 0.02),
        (clear + 0.08, seat - 0.012),
        (246, 244, 238),
        CUSHION,
    )
    blanket = (108, 136, 172) if k.color[0] > 225 else k.color
    k.box((-x * 0.18, x / 2), (-y / 2, y / 2), (clear + 0.1, seat), blanket, CUSHION)
    k.box((-x * 0.24, -x * 0.18), (-y / 2, y / 2), (clear + 0.1, seat), shade(blanket, 1.5), CUSHION)
    count = 2 if y > 1.15 else 1
    for i in range(count):
        middle = (i - (count - 1) / 2) * y * 0.46
        k.box((-x / 2 + 0.08, -x / 2 + 0.46), (middle - y * 0.42 / count, middle + y * 0.42 / count),
              (seat - 0.012, seat + 0.09), WHITE, CUSHION)  # fmt: skip
    for sy in (-1, 1):
        c, d = sorted((sy * (y / 2 - 0.02), sy * (y / 2 - 0.09)))
        k.box((x / 2 - 0.1, x / 2 - 0.03), (c, d), (0, clear), shade(wood, 0.7), Material.WOOD)
    k.surface((-x * 0.18, x / 2 - 0.03), (-y / 2 + 0.03, y / 2 - 0.03), seat)
    k.below((-x / 2 + 0.08, x / 2 - 0.1), (-y / 2 + 0.03, y / 2 - 0.03), clear)


@shape("crib")
def crib(k: Kit) -> None:
    """A cot: mattress between barred sides."""
    x, y, z = k.size
    base = 0.4 * z
    k.box((-x / 2 + 0.03, x / 2 - 0.03), (-y / 2 + 0.03, y / 2 - 0.03), (base - 0.1, base), (186, 206, 226), CUSHION)
    for s in (-1, 1):
        a, b = sorted((s * y / 2, s * (y / 2 - 0.03)))
        k.box((-x / 2, x / 2), (a, b), (0, z))
        c, d = sorted((s * x / 2, s * (x / 2 - 0.03)))
        k.box((c, d), (-y / 2 + 0.03, y / 2 - 0.03), (z * 0.78, z * 0.84))
        for i in range(4):
            yy = (-0.36 + 0.24 * i) * y
            k.box((c, d), (yy - 0.015, yy + 0.015), (base - 0.06, z * 0.78))
    k.space((-x / 2 + 0.03, x / 2 - 0.03), (-y / 2 + 0.03, y / 2 - 0.03), (base, z * 0.95))
    k.surface((-x / 2 + 0.05, x / 2 - 0.05), (-y / 2 + 0.05, y / 2 - 0.05), base)
    k.below((-x / 2 + 0.03, x / 2 - 0.03), (-y / 2 + 0.05, y / 2 - 0.05), base - 0.11)


@shape("sauna_bench")
def sauna_bench(k: Kit) -> None:
    """Two wide wooden steps."""
    x, y, z = k.size
    for i, (high, start) in enumerate(((0.35, 0.0), (0.7, -0.5))):
        x0, x1 = start * x, (0.5 if i == 0 else 0.0) * x
        k.box((x0, x1), (-y / 2, y / 2), (high * z - 0.05, high * z))
        k.box((x1 - 0.06, x1 - 0.03), (-y / 2 + 0.1, y / 2 - 0.1), (0, high * z - 0.05), shade(k.color, 0.7))
    k.box((-x / 2, -x / 2 + 0.04), (-y / 2, y / 2), (0, z), shade(k.color, 0.85))
    k.surface((0.05, x / 2 - 0.05), (-y / 2 + 0.05, y / 2 - 0.05), 0.35 * z)


@shape("sofa")
def sofa(k: Kit) -> None:
    """Back, arms, seat cushions, feet; a hand's breadth free below."""
    x, y, z = k.size
    arm, back, clear, seat = 0.16, 0.24, 0.12, 0.52 * z
    k.box((-x / 2, x / 2 - 0.02), (-y / 2, y / 2), (clear, seat - 0.13), shade(k.color, 0.82))
    k.box((-x / 2, -x / 2 + back), (-y / 2 + arm, y / 2 - arm), (seat - 0.13, z), shade(k.color, 0.93))
    for s in (-1, 1):
        a, b = sorted((s * y / 2, s * (y / 2 - arm)))
        k.box((-x / 2, x / 2 - 0.02), (a, b), (seat - 0.13, z * 0.76), shade(k.color, 0.9))
        for fx in (-x / 2 + 0.04, x / 2 - 0.12):
            c, d = sorted((s * (y / 2 - 0.03), s * (y / 2 - 0.09)))
            k.box((fx, fx + 0.06), (c, d), (0, clear), (60, 44, 34), Material.WOOD)
    count = 3 if y > 1.7 else 2 if y > 1.1 else 1
    width = (y - 2 * arm) / count
    for i in range(count):
        low = -y / 2 + arm + i * width
        k.box((-x / 2 + back, x / 2), (low + 0.004, low + width - 0.004), (seat - 0.13, seat), shade(k.color, 1.1))
    k.surface((-x / 2 + back + 0.02, x / 2 - 0.02), (-y / 2 + arm + 0.01, y / 2 - arm - 0.01), seat, z)
    k.below((-x / 2 + 0.12, x / 2 - 0.14), (-y / 2 + 0.1, y / 2 - 0.1), clear)


@shape("armchair")
def armchair(k: Kit) -> None:
    """A small sofa."""
    x, y, z = k.size
    arm, back, clear, seat = 0.13, 0.2, 0.15, 0.5 * z
    k.box((-x / 2, x / 2 - 0.02), (-y / 2, y / 2), (clear, seat - 0.12), shade(k.color, 0.82), CUSHION)
    k.box((-x / 2, -x / 2 + back), (-y / 2 + 0.02, y / 2 - 0.02), (seat - 0.12, z), shade(k.color, 0.95), CUSHION)
    for s in (-1, 1):
        a, b = sorted((s * y / 2, s * (y / 2 - arm)))
        k.box((-x / 2 + back, x / 2 - 0.02), (a, b), (seat - 0.12, z * 0.72), shade(k.color, 0.9), CUSHION)
        for fx in (-x / 2 + 0.04, x / 2 - 0.1):
            c, d = sorted((s * (y / 2 - 0.03), s * (y / 2 - 0.07)))
            k.box((fx, fx + 0.04), (c, d), (0, clear), (60, 44, 34), Material.WOOD)
    k.box((-x / 2 + back, x / 2), (-y / 2 + arm, y / 2 - arm), (seat - 0.12, seat), shade(k.color, 1.12), CUSHION)
    k.surface((-x / 2 + back + 0.01, x / 2 - 0.02), (-y / 2 + arm + 0.01, y / 2 - arm - 0.01), seat, z)
    k.below((-x / 2 + 0.1, x / 2 - 0.12), (-y / 2 + 0.08, y / 2 - 0.08), clear)


@shape("straight_chair", "highchair")
def straight_chair(k: Kit) -> None:
    """Four legs, seat, two posts with slats."""
    x, y, z = k.size
    high = k.name == "highchair"
    seat = (0.62 if high else 0.52) * z
    thick = 0.035
    k.box((-x / 2 + 0.01, x / 2), (-y / 2, y / 2), (seat - 0.035, seat))
    for s in (-1, 1):
        c, d = sorted((s * (y / 2 - 0.01), s * (y / 2 - 0.01 - thick)))
        k.box((x / 2 - 0.05, x / 2 - 0.05 + thick), (c, d), (0, seat - 0.035), shade(k.color, 0.8))
        k.box((-x / 2, -x / 2 + thick), (c, d), (0, z), shade(k.color, 0.8))
    k.box((-x / 2, -x / 2 + 0.02), (-y / 2 + 0.045, y / 2 - 0.045), (z * 0.84, z), k.color)
    k.box((-x / 2, -x / 2 + 0.02), (-y / 2 + 0.045, y / 2 - 0.045), (z * 0.66, z * 0.75), k.color)
    if high:
        k.box((x * 0.1, x / 2), (-y / 2, y / 2), (z * 0.78, z * 0.81), shade(k.color, 0.9))
        for s in (-1, 1):
            c, d = sorted((s * y / 2, s * (y / 2 - 0.02)))
            k.box((-x / 2 + 0.035, x * 0.3), (c, d), (z * 0.74, z * 0.78), shade(k.color, 0.8))
    front = x * 0.1 if high else x / 2 - 0.01
    k.surface((-x / 2 + 0.045, front), (-y / 2 + 0.02, y / 2 - 0.02), seat, 0.4)
    k.below((-x / 2 + 0.05, x / 2 - 0.06), (-y / 2 + 0.055, y / 2 - 0.055), seat - 0.035)


@shape("garden_chair")
def garden_chair(k: Kit) -> None:
    """A slatted garden seat with arms, as wide as it is."""
    x, y, z = k.size
    seat, thick = 0.52 * z, 0.05
    for i in range(3):
        x0 = -x / 2 + 0.06 + i * (x - 0.06) / 3
        k.box((x0, x0 + (x - 0.06) / 3 - (0.012 if i < 2 else 0)), (-y / 2, y / 2), (seat - 0.03, seat))
    for low in (0.66, 0.85):
        k.box((-x / 2 + 0.01, -x / 2 + 0.035), (-y / 2 + 0.05, y / 2 - 0.05), (z * low, z * (low + 0.13)))
    for s in (-1, 1):
        c, d = sorted((s * y / 2, s * (y / 2 - thick)))
        k.box((-x / 2, -x / 2 + thick), (c, d), (0, z), shade(k.color, 0.8))
        k.box((x / 2 - 0.07, x / 2 - 0.02), (c, d), (0, seat + 0.2), shade(k.color, 0.8))
        k.box((-x / 2 + thick, x / 2), (c, d), (seat + 0.2, seat + 0.23), shade(k.color, 0.9))
    k.surface((-x / 2 + 0.07, x / 2 - 0.01), (-y / 2 + 0.07, y / 2 - 0.07), seat, 0.5)
    k.below((-x / 2 + 0.06, x / 2 - 0.08), (-y / 2 + 0.07, y / 2 - 0.07), seat - 0.03)


@shape("eames_chair")
def lounge_chair(k: Kit) -> None:
    """A reclined lounge chair on a star foot with a footrest in front."""
    x, y, z = k.size
    seat = 0.45 * z
    leather = (52, 44, 40)
    k.box((-x * 0.26, x * 0.14), (-y * 0.42, y * 0.42), (seat - 0.12, seat), leather, CUSHION)
    k.wedge((-x * 0.5, -x * 0.26), (-y * 0.42, y * 0.42), (seat - 0.12, z), leather, CUSHION, flip=True)
    for s in (-1, 1):
        c, d = sorted((s * y / 2, s * y * 0.42))
        k.box((-x * 0.3, x * 0.1), (c, d), (seat - 0.04, seat + 0.14), (130, 84, 52), Material.WOOD)
    k.cyl((-x * 0.1, -x * 0.02), (-0.04, 0.04), (0.05, seat - 0.12), SILVER, Material.METAL)
    k.cyl((-x * 0.24, x * 0.12), (-y * 0.3, y * 0.3), (0, 0.05), DARK, Material.METAL)
    k.box((x * 0.24, x / 2), (-y * 0.36, y * 0.36), (seat * 0.6, seat * 0.85), leather, CUSHION)
    k.cyl((x * 0.33, x * 0.41), (-0.04, 0.04), (0, seat * 0.6), SILVER, Material.METAL)
    k.surface((-x * 0.25, x * 0.13), (-y * 0.38, y * 0.38), seat, 0.4)
    k.below((x * 0.14, x * 0.24), (-y * 0.3, y * 0.3), seat * 0.8)


@shape("swivel_chair")
def swivel_chair(k: Kit) -> None:
    """An office chair: star foot with castors, column, padded seat and back, arms."""
    x, y, z = k.size
    seat = 0.5 * z
    for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1)):
        k.rod((0, 0, 0.09), (dx * (x / 2 - 0.04), dy * (y / 2 - 0.04), 0.06), 0.045, DARK)
        ex, ey = dx * (x / 2 - 0.03), dy * (y / 2 - 0.03)
        k.ball((ex - 0.03, ex + 0.03), (ey - 0.03, ey + 0.03), (0, 0.06), BLACK)
    k.cyl((-0.03, 0.03), (-0.03, 0.03), (0.09, seat - 0.09), GREY, Material.METAL)
    k.box((-x * 0.36, x * 0.4), (-y * 0.4, y * 0.4), (seat - 0.09, seat), (58, 60, 66), CUSHION)
    k.box((-x * 0.46, -x * 0.36), (-y * 0.38, y * 0.38), (seat + 0.08, z), (58, 60, 66), CUSHION)
    k.box((-x * 0.44, -x * 0.38), (-0.04, 0.04), (seat - 0.06, seat + 0.08), DARK)
    for s in (-1, 1):
        c, d = sorted((s * y * 0.4, s * y * 0.46))
        k.box((-x * 0.2, x * 0.22), (c, d), (seat + 0.17, seat + 0.2), BLACK)
        k.box((-0.03, 0.03), (c, d), (seat - 0.06, seat + 0.17), BLACK)
    k.surface((-x * 0.34, x * 0.38), (-y * 0.38, y * 0.38), seat, 0.4)
    k.below((0.06, x * 0.38), (0.05, y * 0.36), seat - 0.1)
    k.below((0.06, x * 0.38), (-y * 0.36, -0.05), seat - 0.1)


@shape("stool")
def stool(k: Kit) -> None:
    """A round seat on four legs; the music stool has a padded seat on a column."""
    x, y, z = k.size
    music = k.name == "music_stool"
    k.cyl((-x / 2, x / 2), (-y / 2, y / 2), (z - 0.07, z), k.color, CUSHION if music else None)
    for sx in (-1, 1):
        for sy in (-1, 1):
            k.rod(
                (sx * x * 0.26, sy * y * 0.26, z - 0.07),
                (sx * x * 0.33, sy * y * 0.33, 0.012),
                0.03,
                shade(k.color, 0.8),
            )
    k.cyl((-x * 0.3, x * 0.3), (-y * 0.3, y * 0.3), (0.3 * z, 0.3 * z + 0.02), shade(k.color, 0.7))
    k.surface((-x * 0.34, x * 0.34), (-y * 0.34, y * 0.34), z)
    k.below((-x * 0.28, x * 0.28), (-y * 0.28, y * 0.28), 0.3 * z)


@shape("bench")
def bench(k: Kit) -> None:
    """A plank seat on two side frames; higher benches have a back."""
    x, y, z = k.size
    back = z > 0.6
    seat = 0.45 if back else z
    k.box((-x / 2, x / 2), (-y / 2, y / 2), (seat - 0.05, seat))
    for s in (-1, 1):
        for fx in (-x / 2 + 0.02, x / 2 - 0.08):
            c, d = sorted((s * (y / 2 - 0.06), s * (y / 2 - 0.14)))
            k.box((fx, fx + 0.06), (c, d), (0, seat - 0.05), shade(k.color, 0.75))
    k.box((-0.02, 0.02), (-y / 2 + 0.14, y / 2 - 0.14), (seat - 0.11, seat - 0.05), shade(k.color, 0.75))
    if back:
        k.box((-x / 2, -x / 2 + 0.03), (-y / 2, y / 2), (seat + 0.12, z))
        for s in (-1, 1):
            c, d = sorted((s * (y / 2 - 0.08), s * (y / 2 - 0.14)))
            k.box((-x / 2, -x / 2 + 0.03), (c, d), (seat, seat + 0.12), shade(k.color, 0.75))
    k.surface((-x / 2 + (0.04 if back else 0.01), x / 2 - 0.01), (-y / 2 + 0.01, y / 2 - 0.01), seat)
    k.below((-x / 2 + 0.02, x / 2 - 0.02), (-y / 2 + 0.16, y / 2 - 0.16), seat - 0.11)


@shape("ottoman")
def ottoman(k: Kit) -> None:
    """A padded block on short feet."""
    x, y, z = k.size
    clear = 0.1
    k.box((-x / 2 + 0.01, x / 2 - 0.01), (-y / 2 + 0.01, y / 2 - 0.01), (clear, z - 0.1), shade(k.color, 0.85), CUSHION)
    k.box((-x / 2, x / 2), (-y / 2, y / 2), (z - 0.1, z), shade(k.color, 1.1), CUSHION)
    legs(k, clear, 0.05, 0.02, Material.WOOD)
    under_all(k, clear, 0.08)
    k.top_surface(0.02)


@shape("hammock")
def hammock(k: Kit) -> None:
    """Cloth slung between two stands."""
    x, y, z = k.size
    low = 0.42 * z
    for s in (-1, 1):
        c, d = sorted((s * y / 2, s * (y / 2 - 0.06)))
        k.box((-0.03, 0.03), (c, d), (0.05, z), (124, 86, 54), Material.WOOD)
        k.box((-x / 2, x / 2), (c, d), (0, 0.05), (124, 86, 54), Material.WOOD)
        k.rod((0, s * (y / 2 - 0.04), z * 0.93), (0, s * y * 0.38, z * 0.7), 0.02, WHITE)
        k.rod((0, s * y * 0.39, z * 0.72), (0, s * y * 0.2, low - 0.01), (0.02, x * 0.7), k.color, CUSHION)
    k.box((-x * 0.38, x * 0.38), (-y * 0.21, y * 0.21), (low - 0.02, low), k.color, CUSHION)
    k.surface((-x * 0.36, x * 0.36), (-y * 0.17, y * 0.17), low, 0.5)
    k.below((-x * 0.4, x * 0.4), (-y * 0.3, y * 0.3), low - 0.03)


@shape("shelf_open", "magazine_rack")
def bookshelf(k: Kit) -> None:
    """Sides, back and boards, open in front."""
    x, y, z = k.size
    board = 0.022
    leg = 0.09 if k.name == "shelf" else 0.1
    count = max(2, min(5, round((z - leg) / 0.38)))
    k.box((-x / 2, -x / 2 + 0.012), (-y / 2 + board, y / 2 - board), (leg, z), shade(k.color, 0.72))
    for s in (-1, 1):
        c, d = sorted((s * y / 2, s * (y / 2 - board)))
        k.box((-x / 2, x / 2), (c, d), (0, z))
    inner = (-y / 2 + board, y / 2 - board)
    height = (z - leg - board) / count
    for i in range(count + 1):
        low = leg + i * height
        k.box((-x / 2 + 0.012, x / 2), inner, (low, low + board), shade(k.color, 1.08))
        if i < count:
            k.space((-x / 2 + 0.014, x / 2 - 0.012), inner, (low + board, low + height))
    if k.name == "grocery_shelf":
        k.box((x / 2 - 0.01, x / 2), inner, (z - 0.1, z - 0.02), RED)
    k.surface((-x / 2 + 0.01, x / 2 - 0.01), (-y / 2 + board, y / 2 - board), z, 0.4)
    if k.name == "shelf":
        k.below((-x / 2 + 0.01, x / 2), inner, leg)


@shape("shelf_wall")
def wall_shelf(k: Kit) -> None:
    """A board on the wall with a shallow tray below it."""
    x, y, z = k.size
    board = 0.02
    k.box((-x / 2, x / 2), (-y / 2, y / 2), (z - board, z))
    k.box((-x / 2, x / 2), (-y / 2, y / 2), (0, board * 0.6), shade(k.color, 0.9))
    k.box((-x / 2, -x / 2 + 0.012), (-y / 2 + 0.02, y / 2 - 0.02), (board * 0.6, z - board), shade(k.color, 0.7))
    for s in (-1, 1):
        c, d = sorted((s * y / 2, s * (y / 2 - 0.02)))
        k.box((-x / 2, x / 2), (c, d), (board * 0.6, z - board), shade(k.color, 0.85))
    k.space((-x / 2 + 0.014, x / 2 - 0.005), (-y / 2 + 0.02, y / 2 - 0.02), (board * 0.6, z - board))
    k.surface((-x / 2 + 0.01, x / 2 - 0.01), (-y / 2 + 0.01, y / 2 - 0.01), z, 0.5)
    hang_below(k, 0.4)


@shape("display_case")
def display_case(k: Kit) -> None:
    """A shop counter: wooden base, shelves open to the staff, pale glass around."""
    x, y, z = k.size
    base, wall, glass = 0.3 * z, 0.015, (206, 226, 232)
    k.box((-x / 2, x / 2), (-y / 2, y / 2), (0, base), (124, 88, 60), Material.WOOD)
    k.box((-x / 2, -x / 2 + wall), (-y / 2, y / 2), (base, z), glass, Material.GLASS)
    for s in (-1, 1):
        c, d = sorted((s * y / 2, s * (y / 2 - wall)))
        k.box((-x / 2 + wall, x / 2), (c, d), (base, z), glass, Material.GLASS)
    k.box((-x / 2 + wall, x / 2), (-y / 2 + wall, y / 2 - wall), (z - wall, z), glass, Material.GLASS)
    middle = base + (z - base) * 0.5
    inner = (-y / 2 + wall, y / 2 - wall)
    k.box((-x / 2 + wall, x / 2 - 0.1), inner, (middle - 0.012, middle), (222, 234, 238), Material.GLASS)
    k.space((-x / 2 + wall, x / 2 - 0.01), inner, (base, middle - 0.012))
    k.space((-x / 2 + wall, x / 2 - 0.1), inner, (middle, z - wall))
    k.top_surface(0.02)


@shape("coatrack")
def coatrack(k: Kit) -> None:
    """A pole with hooks on a round foot."""
    x, y, z = k.size
    k.cyl((-x / 2, x / 2), (-y / 2, y / 2), (0, 0.03), shade(k.color, 0.8))
    k.cyl((-0.022, 0.022), (-0.022, 0.022), (0.03, z))
    for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1)):
        k.rod((0, 0, z * 0.88), (dx * x * 0.42, dy * y * 0.42, z * 0.97), 0.025)
    k.rod((0.16, 0.05, z * 0.9), (0.1, 0.04, z * 0.45), (0.05, 0.22), (70, 84, 110), CUSHION)


@shape("hall_tree")
def hall_tree(k: Kit) -> None:
    """A seat with cubbies below, a panel with hooks, a hat shelf on top."""
    x, y, z = k.size
    seat = 0.26 * z
    board = 0.025
    k.box((-x / 2, -x / 2 + board), (-y / 2, y / 2), (0, z), shade(k.color, 0.9))
    k.box((-x / 2 + board, x / 2), (-y / 2, y / 2), (seat - 0.04, seat))
    k.box((-x / 2 + board, x / 2), (-y / 2, y / 2), (0, 0.05), shade(k.color, 0.8))
    for i in range(4):
        low = -y / 2 + i * (y - board) / 3
        k.box((-x / 2 + board, x / 2 - 0.01), (low, low + board), (0.05, seat - 0.04), shade(k.color, 0.85))
        if i < 3:
            span = (low + board, low + (y - board) / 3)
            k.space((-x / 2 + board, x / 2 - 0.015), span, (0.05, seat - 0.04))
    k.box((-x / 2 + board, x * 0.2), (-y / 2, y / 2), (z - board, z))
    for i in range(4):
        yy = (-0.36 + 0.24 * i) * y
        k.box(
            (-x / 2 + board, -x / 2 + board + 0.07),
            (yy - 0.012, yy + 0.012),
            (z * 0.76, z * 0.79),
            DARK,
            Material.METAL,
        )
    k.surface((-x / 2 + board + 0.01, x / 2 - 0.01), (-y / 2 + 0.01, y / 2 - 0.01), seat, 0.9)


@shape("serving_cart")
def serving_cart(k: Kit) -> None:
    """Two trays between posts on wheels."""
    x, y, z = k.size
    low, high = 0.2, z - 0.1
    for level in (low, high):
        k.box((-x / 2, x / 2), (-y / 2 + 0.06, y / 2), (level - 0.025, level), (206, 180, 140), Material.WOOD)
    for sx in (-1, 1):
        a, b = sorted((sx * x / 2, sx * (x / 2 - 0.025)))
        for sy in (-1, 1):
            c = -y / 2 + 0.06 if sy < 0 else y / 2 - 0.025
            d = c + 0.025
            top = z if sy < 0 else high - 0.025
            k.box((a, b), (c, d), (0.08, top), SILVER, Material.METAL)
            k.cyl((a, b), (d - 0.08, d), (0, 0.08), BLACK, axis="x")
    k.box((-x / 2, x / 2), (-y / 2, -y / 2 + 0.025), (z - 0.025, z), SILVER, Material.METAL)
    for sx in (-1, 1):
        a, b = sorted((sx * x / 2, sx * (x / 2 - 0.025)))
        k.box((a, b), (-y / 2 + 0.025, -y / 2 + 0.085), (z - 0.025, z), SILVER, Material.METAL)
    k.space((-x / 2 + 0.03, x / 2 - 0.03), (-y / 2 + 0.1, y / 2 - 0.03), (low, high - 0.025))
    k.surface((-x / 2 + 0.02, x / 2 - 0.02), (-y / 2 + 0.1, y / 2 - 0.01), high, 0.6)


@shape("shopping_cart")
def shopping_cart(k: Kit) -> None:
    """A basket of steel on wheels, handle at the back."""
    x, y, z = k.size
    base = 0.45 * z
    open_box(k, 0.012, (-x * 0.4, x / 2), None, (base, z * 0.92), SILVER, Material.METAL)
    k.box((-x / 2, -x * 0.46), (-y / 2, y / 2), (z * 0.95, z), RED)
    for s in (-1, 1):
        yy = s * (y / 2 - 0.04)
        k.rod((-x * 0.48, yy, z * 0.96), (-x * 0.36, yy, 0.1), 0.025, GREY, Material.METAL)
        k.rod((x * 0.4, yy, base), (x * 0.4, yy, 0.1), 0.025, GREY, Material.METAL)
        for fx in (-0.36, 0.4):
            k.cyl((fx * x - 0.05, fx * x + 0.05), (yy - 0.02, yy + 0.02), (0, 0.1), BLACK, axis="y")
    k.box((-x * 0.38, x * 0.42), (-y * 0.4, y * 0.4), (0.12, 0.14), SILVER, Material.METAL)
    k.below((-x * 0.3, x * 0.3), (-y * 0.38, y * 0.38), 0.11)


@shape("infant_seat")
def infant_seat(k: Kit) -> None:
    """A bucket seat with a padded back, belt and handle."""
    k.unit()
    k.wedge((-0.5, 0.0), (-0.5, 0.5), (0.0, 0.8), k.color, CUSHION, flip=True)
    k.box((0.0, 0.5), (-0.45, 0.45), (0.0, 0.28), shade(k.color, 0.7))
    k.box((-0.1, 0.46), (-0.34, 0.34), (0.28, 0.36), (96, 120, 150), CUSHION)
    k.box((-0.4, -0.2), (-0.34, 0.34), (0.5, 1.0), (96, 120, 150), CUSHION)
    for s in (-1, 1):
        c, d = sorted((s * 0.5, s * 0.38))
        k.box((-0.3, 0.4), (c, d), (0.2, 0.55), shade(k.color, 0.85))
    k.rod((-0.2, 0.12, 0.8), (0.3, 0.05, 0.38), 0.03, RED)
