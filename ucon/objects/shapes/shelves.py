"""Beds, shelves, racks and carts."""

from __future__ import annotations

from ucon.objects.kit import Kit, shape
from ucon.objects.model import Material
from ucon.objects.palette import BLACK, DARK, GREY, RED, SILVER, WHITE, shade
from ucon.objects.shapes.cabinets import hang_below
from ucon.objects.shapes.generic import open_box

CUSHION = Material.FABRIC


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
