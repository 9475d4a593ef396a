"""Books and paper, pens, accessories, jewellery, toiletries, toys, and things for pets."""

from __future__ import annotations

from math import cos, pi, sin

from ucon.objects.kit import (
    BLACK,
    BLUE,
    BROWN,
    COPPER,
    CREAM,
    DARK,
    DARKBROWN,
    GOLD,
    GREEN,
    GREY,
    ORANGE,
    PAPER,
    PINK,
    RED,
    SILVER,
    TAN,
    WHITE,
    YELLOW,
    Kit,
    shade,
    shape,
)  # fmt: skip
from ucon.objects.model import Material
from ucon.objects.shapes.generic import open_box, ring, torus
from ucon.objects.shapes.vessels import round_space

METAL = Material.METAL
SHEET = Material.PAPER
FABRIC = Material.FABRIC
FULL = ((-0.5, 0.5), (-0.5, 0.5))


@shape("book")
def book(k: Kit) -> None:
    """Cover, white page block, spine at -y; a folder, a game and a puzzle are boxes with print."""
    x, y, z = k.size
    k.unit()
    if k.name in ("board_game", "jigsaw_puzzle"):
        k.box(*FULL, (0, 0.96), (70, 110, 180) if k.name == "jigsaw_puzzle" else RED, SHEET)
        for i, color in enumerate((YELLOW, GREEN, WHITE, ORANGE)):
            x0, y0 = -0.4 + 0.42 * (i % 2), -0.4 + 0.42 * (i // 2)
            k.box((x0, x0 + 0.36), (y0, y0 + 0.36), (0.96, 1.0), color, SHEET)
    elif k.name == "folder":
        k.box(*FULL, (0, 0.08), (220, 180, 60), SHEET)
        k.box((-0.5, 0.46), (-0.46, 0.46), (0.08, 0.9), PAPER, SHEET)
        k.box((-0.5, 0.44), (-0.5, 0.5), (0.9, 1), (236, 198, 76), SHEET)
        k.box((0.44, 0.5), (0.1, 0.44), (0.04, 0.1), (220, 180, 60), SHEET)
    else:
        cover = {"magazine": (210, 70, 110), "notebook": (40, 42, 48)}.get(k.name, k.color)
        k.box(*FULL, (0, 0.12), cover, SHEET)
        k.box((-0.47, 0.47), (-0.46, 0.48), (0.12, 0.86), PAPER, SHEET)
        k.box((-0.5, 0.5), (-0.5, -0.45), (0.1, 0.88), cover, SHEET)
        k.box((-0.5, 0.5), (-0.5, 0.5), (0.86, 0.98), cover, SHEET)
        accent = (240, 220, 120) if k.name != "magazine" else WHITE
        k.box((0.2, 0.36), (-0.3, 0.36), (0.98, 1.0), accent, SHEET)
        if k.name == "magazine":
            k.box((-0.36, 0.1), (-0.3, 0.36), (0.98, 1.0), (90, 150, 200), SHEET)
        elif k.name == "notebook":
            k.box((-0.5, 0.5), (0.3, 0.36), (0.98, 1.0), (200, 60, 50), SHEET)
        else:
            k.box((-0.1, 0.06), (-0.2, 0.26), (0.98, 1.0), accent, SHEET)
    k.surface((-x * 0.47, x * 0.47), (-y * 0.47, y * 0.47), z)


def _newspaper(k: Kit) -> None:
    k.box(*FULL, (0, 0.9), (226, 224, 214), SHEET)
    k.box((0.3, 0.44), (-0.44, 0.44), (0.9, 1.0), (40, 40, 44), SHEET)
    k.box((0.0, 0.26), (0.02, 0.44), (0.9, 1.0), (120, 124, 130), SHEET)
    for i in range(3):
        k.box((-0.44 + 0.13 * i, -0.36 + 0.13 * i), (-0.44, 0.44), (0.9, 0.98), (170, 170, 166), SHEET)
    k.box((0.06, 0.24), (-0.44, -0.04), (0.9, 0.98), (170, 170, 166), SHEET)


def _envelope(k: Kit) -> None:
    k.box(*FULL, (0, 0.6), k.color, SHEET)
    along_x = k.size[0] > k.size[1]
    k.rod((-0.5, 0.5 if along_x else -0.5, 0.7), (0, 0, 0.7), (0.002, 0.006), (150, 140, 120))
    k.rod((0.5 if along_x else -0.5, 0.5, 0.7), (0, 0, 0.7), (0.002, 0.006), (150, 140, 120))
    k.box((-0.42, -0.26), (-0.4, -0.24), (0.6, 1.0), RED, SHEET)


def _lined(k: Kit) -> None:
    """Sheets with lines of text."""
    k.box(*FULL, (0, 0.9), PAPER if k.name != "notepad" else (244, 214, 90), SHEET)
    for i in range(4):
        x0 = -0.38 + 0.18 * i
        k.box((x0, x0 + 0.06), (-0.36, 0.36 - 0.1 * (i % 2)), (0.9, 1.0), (90, 100, 130), SHEET)
    if k.name == "notepad":
        k.box((0.4, 0.5), (-0.5, 0.5), (0.9, 1.0), (190, 60, 50), SHEET)
    elif k.name == "legal_document":
        k.cyl((-0.44, -0.3), (0.2, 0.42), (0.9, 1.0), RED)


def _sticky(k: Kit) -> None:
    k.box(*FULL, (0, 0.9), k.color, SHEET)
    k.box((-0.5, 0.5), (-0.5, 0.5), (0.9, 1.0), shade(k.color, 1.2), SHEET)
    k.box((-0.1, 0.1), (-0.3, 0.3), (0.99, 1.005), (90, 90, 110), SHEET)


def _disc_case(k: Kit) -> None:
    k.box(*FULL, (0, 0.7), (60, 62, 70))
    k.cyl((-0.42, 0.42), (-0.42, 0.42), (0.7, 0.9), (206, 214, 226), METAL)
    k.cyl((-0.1, 0.1), (-0.1, 0.1), (0.9, 1.0), DARK)


def _picture_card(k: Kit) -> None:
    k.box(*FULL, (0, 0.7), WHITE, SHEET)
    k.box((-0.02, 0.44), (-0.44, 0.44), (0.7, 1.0), (130, 190, 230), SHEET)
    k.box((-0.44, -0.02), (-0.44, 0.44), (0.7, 1.0), (230, 200, 140), SHEET)
    k.cyl((0.16, 0.34), (0.1, 0.3), (0.9, 1.02), YELLOW, SHEET)


def _filter_cone(k: Kit) -> None:
    k.cyl((-0.2, 0.2), (-0.2, 0.2), (0, 0.96), None, SHEET, taper=2.5)
    k.cyl((-0.44, 0.44), (-0.44, 0.44), (0.96, 1.0), shade(k.color, 0.8), SHEET)


def _wrapping(k: Kit) -> None:
    k.box(*FULL, (0, 0.9), k.color, SHEET)
    for i in range(4):
        y0 = -0.46 + 0.25 * i
        k.box((-0.5, 0.5), (y0, y0 + 0.08), (0.9, 1.0), (250, 220, 120), SHEET)


def _card(k: Kit) -> None:
    k.box(*FULL, (0, 0.5), k.color, SHEET)
    k.box((-0.48, 0.46), (-0.47, 0.47), (0.5, 1.0), shade(k.color, 1.15), SHEET)


_PAPERS = {
    "newspaper": _newspaper, "envelope": _envelope, "letter": _lined, "legal_document": _lined, "paper_sheet": _lined,
    "notepad": _lined, "post_it": _sticky, "sticky_note": _sticky, "postage_stamp": _picture_card, "dvd": _disc_case,
    "postcard": _picture_card, "paper_coffee_filter": _filter_cone, "wrapping_paper": _wrapping, "cardstock": _card,
    "wax_paper": _card, "folderal": _picture_card,
}  # fmt: skip


@shape("paper_flat")
def paper(k: Kit) -> None:
    """Sheets, cards, envelopes, newspapers."""
    k.unit()
    _PAPERS[k.name](k)
    if k.category.support:
        x, y, z = k.size
        k.surface((-x * 0.46, x * 0.46), (-y * 0.46, y * 0.46), z)


@shape("pen_stick")
def pen(k: Kit) -> None:
    """Along x: body, tip and end."""
    k.unit()
    body, tip, end = {
        "pencil": (YELLOW, TAN, PINK), "colored_pencil": ((200, 60, 120), TAN, (200, 60, 120)),
        "marker": ((40, 40, 46), RED, RED), "pen": (BLUE, SILVER, DARK),
    }[k.name]  # fmt: skip
    k.box((-0.38, 0.34), (-0.5, 0.5), (0, 1), body)
    k.cyl((0.34, 0.5), (-0.5, 0.5), (0, 1), tip, None, axis="x", taper=0.2 if k.name != "marker" else 0.8)
    k.box((-0.5, -0.38), (-0.5, 0.5), (0, 1), end)


def _calculator(k: Kit) -> None:
    k.box(*FULL, (0, 0.8))
    k.box((0.22, 0.44), (-0.4, 0.4), (0.8, 0.9), (160, 190, 150))
    for i in range(3):
        for j in range(3):
            x0, y0 = -0.44 + 0.21 * i, -0.4 + 0.28 * j
            k.box((x0, x0 + 0.15), (y0, y0 + 0.22), (0.8, 1.0), (200, 202, 206) if j < 2 else ORANGE)


def _organizer(k: Kit) -> None:
    x, y, z = k.size
    open_box(k, 0.006, z=(0, 0.7 * z))
    k.box((-0.003, 0.003), (-y / 2 + 0.006, y / 2 - 0.006), (0.006, 0.7 * z))
    for i, color in enumerate((YELLOW, RED, BLUE)):
        y0 = -y * 0.3 + i * y * 0.2
        k.box((-x * 0.3, -x * 0.3 + 0.008), (y0, y0 + 0.008), (0.006, z - 0.01 * i), color)
    space = k.compartments.pop().box
    k.space((0.004, space[3]), (space[1], space[4]), (space[2], space[5]))


def _holder(k: Kit) -> None:
    x, y, z = k.size
    top = 0.74 * z
    ring(k, x / 2, y / 2, (0.006, top), 0.004)
    k.cyl((-x / 2, x / 2), (-y / 2, y / 2), (0, 0.006))
    for i, color in enumerate((YELLOW, RED, BLUE, GREEN)):
        a = 2 * pi * i / 4 + 0.4
        cx, cy = 0.4 * x * cos(a), 0.4 * y * sin(a)
        k.box((cx - 0.004, cx + 0.004), (cy - 0.004, cy + 0.004), (0.006, z - 0.012 * i), color)
    round_space(k, x * 0.34, y * 0.34, 0.006, top)


def _pencil_box(k: Kit) -> None:
    open_box(k, 0.005)
    x, y, z = k.size
    k.box((x / 2 - 0.001, x / 2), (-y * 0.3, y * 0.3), (0.3 * z, 0.7 * z), YELLOW)
    k.box((-x * 0.2, -x * 0.2 + 0.006), (-y * 0.45, y * 0.4), (0.005, 0.011), RED)
    space = k.compartments.pop().box
    k.space((space[0], space[3]), (space[1], space[4]), (0.012, space[5]))


def _tape(k: Kit) -> None:
    torus(k, 0.38, 0.24, (0, 1), (150, 152, 156))
    torus(k, 0.26, 0.06, (0.0, 0.98), TAN)


def _shears(k: Kit) -> None:
    for s in (-1, 1):
        k.rod((-0.1, -0.06 * s, 0.5), (0.5, 0.16 * s, 0.5), (0.006, 0.012), SILVER, METAL)
        k.ball((-0.5, -0.14), (min(0.06 * s, 0.5 * s), max(0.06 * s, 0.5 * s)), (0, 1), RED)


@shape("stationery_small")
def desk_thing(k: Kit) -> None:
    """Calculator, organiser, pencil holder and box, tape, scissors."""
    hollow = {"desk_organizer": _organizer, "pencil_holder": _holder, "pencil_box": _pencil_box}.get(k.name)
    if hollow is not None:
        hollow(k)
        return
    k.unit()
    {"calculator": _calculator, "duct_tape": _tape, "shears": _shears}[k.name](k)
    if k.category.support:
        x, y, z = k.size
        k.surface((-x * 0.4, x * 0.4), (-y * 0.4, y * 0.4), z)


def _keys(k: Kit) -> None:
    torus(k, 0.2, 0.06, (0.2, 0.6), SILVER, METAL, count=6)
    for dx, dy in ((0.45, 0.1), (0.3, -0.42), (0.35, 0.45)):
        k.rod((0.12, dy * 0.3, 0.4), (dx, dy, 0.3), (0.008, 0.014), GOLD, METAL)
    k.box((-0.5, -0.15), (-0.24, 0.24), (0, 1), RED)


def _coin(k: Kit) -> None:
    """Drawn as thick as wide, so that it can be seen at all: a pile of three."""
    color = COPPER if k.name == "penny" else SILVER
    for i, (dx, dy) in enumerate(((0.04, 0.0), (-0.04, 0.03), (0.02, -0.04))):
        span = (0.34 * i, 0.34 * i + 0.3)
        k.cyl((-0.44 + dx, 0.44 + dx), (-0.44 + dy, 0.44 + dy), span, shade(color, 1 - 0.12 * (i % 2)), METAL)
        k.cyl((-0.38 + dx, 0.38 + dx), (-0.38 + dy, 0.38 + dy), (span[1], span[1] + 0.04), shade(color, 0.6), METAL)


def _wallet(k: Kit) -> None:
    k.box((-0.5, 0.5), (-0.5, 0.5), (0, 0.46), k.color)
    k.box((-0.44, 0.44), (-0.44, 0.5), (0.46, 0.56), GREEN)
    k.box((-0.5, 0.5), (-0.5, 0.46), (0.56, 1.0), shade(k.color, 0.85))


def _bank_card(k: Kit) -> None:
    k.box(*FULL, (0, 0.8), k.color)
    k.box((0.2, 0.36), (-0.5, 0.5), (0.8, 1.0), BLACK)
    k.box((-0.2, 0.02), (-0.36, -0.16), (0.8, 1.0), GOLD)


def _note(k: Kit) -> None:
    k.box(*FULL, (0, 0.8), (120, 164, 116), SHEET)
    k.cyl((-0.3, 0.3), (-0.16, 0.16), (0.8, 1.0), (206, 222, 196), SHEET)


def _collar(k: Kit) -> None:
    torus(k, 0.44, 0.1, (0, 0.7), RED)
    k.cyl((0.38, 0.5), (-0.1, 0.1), (0, 1), GOLD, METAL, axis="x")


def _lighter(k: Kit) -> None:
    k.box((-0.5, 0.5), (-0.5, 0.3), (0, 1), RED)
    k.box((-0.5, 0.5), (0.3, 0.5), (0.1, 0.9), SILVER, METAL)


def _cigarette(k: Kit) -> None:
    k.cyl((-0.5, 0.1), (-0.5, 0.5), (0, 1), WHITE, axis="x")
    k.cyl((0.1, 0.5), (-0.5, 0.5), (0, 1), ORANGE, axis="x")


def _pipe(k: Kit) -> None:
    k.cyl((0.1, 0.5), (-0.5, 0.5), (0, 1.0), BROWN, Material.WOOD)
    k.cyl((0.16, 0.44), (-0.3, 0.3), (0.96, 1.01), BLACK)
    k.rod((-0.5, 0, 0.6), (0.2, 0, 0.3), 0.01, BLACK)


_POCKET = {
    "key_chain": _keys, "nickel": _coin, "penny": _coin, "quarter": _coin, "wallet": _wallet, "credit_card": _bank_card,
    "money": _note, "dog_collar": _collar, "lighter": _lighter, "cigarette": _cigarette, "tobacco_pipe": _pipe,
}  # fmt: skip


@shape("wallet")
def pocket_thing(k: Kit) -> None:
    """What people carry in pockets."""
    k.unit()
    _POCKET[k.name](k)


@shape("glasses")
def glasses(k: Kit) -> None:
    """Two lenses and two temples."""
    k.unit()
    lens = (40, 44, 50) if k.name == "sunglasses" else (180, 206, 220)
    for s in (-1, 1):
        c, d = sorted((s * 0.48, s * 0.06))
        k.cyl((0.38, 0.5), (c, d), (0, 1), lens, Material.GLASS, axis="x")
        k.box((-0.5, 0.4), (s * 0.48 - 0.03, s * 0.48 + 0.03), (0.6, 0.8), BLACK)
        k.box((0.36, 0.42), (c, d), (0.8, 1.0), BLACK)
    k.box((0.4, 0.46), (-0.1, 0.1), (0.6, 0.8), BLACK)


def _ring(k: Kit) -> None:
    torus(k, 0.36, 0.2, (0, 0.5), GOLD, METAL)
    if k.name == "ring":
        k.ball((0.1, 0.5), (-0.2, 0.2), (0.3, 1.0), (190, 226, 240), Material.GLASS)


def _necklace(k: Kit) -> None:
    torus(k, 0.42, 0.06, (0, 0.8), GOLD, METAL, count=10)
    k.ball((0.36, 0.5), (-0.1, 0.1), (0, 1.0), (200, 50, 70))


def _watch(k: Kit) -> None:
    torus(k, 0.4, 0.16, (0, 0.6), DARKBROWN)
    k.cyl((0.1, 0.5), (-0.34, 0.34), (0.2, 1.0), SILVER, METAL)
    k.cyl((0.16, 0.44), (-0.24, 0.24), (0.98, 1.02), WHITE)


def _gem(k: Kit) -> None:
    color = {"jade": (70, 160, 110), "pearl": (244, 238, 228)}.get(k.name, (190, 226, 240))
    if k.name == "diamond":
        k.cyl((-0.1, 0.1), (-0.1, 0.1), (0, 0.6), color, Material.GLASS, taper=5.0)
        k.cyl(*FULL, (0.6, 1.0), shade(color, 1.3), Material.GLASS, taper=0.6)
    else:
        k.ball(*FULL, (0, 1), color)
        k.ball((0.1, 0.36), (-0.2, 0.1), (0.55, 0.9), shade(color, 1.5))


def _bow(k: Kit) -> None:
    k.ball((-0.5, -0.02), (-0.5, 0.5), (0, 1), RED, FABRIC)
    k.ball((0.02, 0.5), (-0.5, 0.5), (0, 1), RED, FABRIC)
    k.ball((-0.12, 0.12), (-0.3, 0.3), (0.1, 0.9), (150, 20, 30), FABRIC)


def _snow_globe(k: Kit) -> None:
    k.cyl((-0.45, 0.45), (-0.45, 0.45), (0, 0.25), DARKBROWN, Material.WOOD)
    k.ball(*FULL, (0.16, 1.0), (196, 224, 240), Material.GLASS)
    k.cyl((0.2, 0.49), (-0.2, 0.2), (0.3, 0.75), (60, 130, 70), None, taper=0.2)


_JEWELS = {
    "ring": _ring, "bracelet": _ring, "necklace": _necklace, "watch": _watch, "diamond": _gem, "jade": _gem,
    "pearl": _gem, "bow": _bow, "snow_globe": _snow_globe,
}  # fmt: skip


@shape("jewelry_tiny")
def jewel(k: Kit) -> None:
    """Jewellery, larger than life where it would be too small to see."""
    k.unit()
    _JEWELS[k.name](k)


def _toothbrush(k: Kit) -> None:
    k.box((-0.5, 0.5), (-0.4, 0.4), (0, 0.5), BLUE)
    k.box((0.28, 0.48), (-0.5, 0.5), (0.5, 1.0), WHITE)


def _toilet_paper(k: Kit) -> None:
    k.cyl(*FULL, (0, 1), (246, 244, 240), SHEET)
    k.cyl((-0.18, 0.18), (-0.18, 0.18), (0.99, 1.01), (150, 120, 90), SHEET)


def _lipstick(k: Kit) -> None:
    k.cyl(*((-0.5, 0.5), (-0.5, 0.1)), (0, 1), BLACK, axis="y")
    k.cyl((-0.42, 0.42), (0.1, 0.26), (0.08, 0.92), GOLD, METAL, axis="y")
    k.cyl((-0.34, 0.34), (0.26, 0.5), (0.16, 0.84), RED, axis="y", taper=0.7)


def _razor(k: Kit) -> None:
    k.box((-0.5, 0.3), (-0.16, 0.16), (0.2, 0.6), (60, 130, 190))
    k.box((0.26, 0.5), (-0.5, 0.5), (0, 1), SILVER, METAL)
    k.box((0.49, 0.51), (-0.4, 0.4), (0.3, 0.6), DARK)


def _inhaler(k: Kit) -> None:
    k.box((-0.5, 0.5), (-0.5, -0.1), (0, 0.9), BLUE)
    k.cyl((-0.4, 0.3), (-0.1, 0.5), (0.05, 0.95), SILVER, METAL, axis="y")
    k.box((0.2, 0.5), (-0.5, -0.2), (0, 1), (150, 190, 230))


def _bandage(k: Kit) -> None:
    k.cyl((-0.5, 0.5), (-0.5, 0.5), (0, 1), (236, 212, 184), FABRIC, axis="x")
    k.cyl((-0.51, 0.51), (-0.2, 0.2), (0.3, 0.7), (200, 60, 60), axis="x")


def _clipper(k: Kit) -> None:
    k.box((-0.5, 0.4), (-0.5, 0.5), (0, 0.5), SILVER, METAL)
    k.rod((-0.45, 0, 0.95), (0.36, 0, 0.5), (0.004, 0.012), GREY, METAL)
    k.box((0.4, 0.5), (-0.5, 0.5), (0.1, 0.7), SILVER, METAL)


def _denture(k: Kit) -> None:
    for z0 in (0.0, 0.52):
        k.cyl(*FULL, (z0, z0 + 0.48), (226, 120, 130))
        k.box((0.3, 0.5), (-0.36, 0.36), (z0 + 0.14, z0 + 0.36), WHITE)


def _diaper(k: Kit) -> None:
    k.box((-0.5, 0.5), (-0.5, 0.5), (0, 0.7), WHITE, FABRIC)
    k.ball((-0.4, 0.4), (-0.44, 0.44), (0.2, 1.0), (244, 246, 248), FABRIC)
    for s in (-1, 1):
        k.box((0.2, 0.44), (s * 0.4 - 0.1, s * 0.4 + 0.1), (0.7, 0.9), (130, 180, 220), FABRIC)


def _loofah(k: Kit) -> None:
    k.ball(*FULL, (0, 0.8))
    for i in range(4):
        a = 2 * pi * i / 4
        k.ball(
            (0.3 * cos(a) - 0.2, 0.3 * cos(a) + 0.2),
            (0.3 * sin(a) - 0.2, 0.3 * sin(a) + 0.2),
            (0.2, 0.7),
            shade(k.color, 1.2),
        )
    k.box((-0.02, 0.02), (-0.12, 0.12), (0.75, 1.0), WHITE)


def _soap_dish(k: Kit) -> None:
    k.box(*FULL, (0, 0.5), WHITE)
    for s in (-1, 1):
        k.box((s * 0.46 - 0.04, s * 0.46 + 0.04), (-0.5, 0.5), (0.5, 1.0), WHITE)
        k.box((-0.42, 0.42), (s * 0.47 - 0.03, s * 0.47 + 0.03), (0.5, 1.0), WHITE)
    k.box((-0.3, 0.3), (-0.3, 0.3), (0.5, 0.6), (200, 206, 210))


_TOILETRIES = {
    "toothbrush": _toothbrush, "toilet_paper": _toilet_paper, "lipstick": _lipstick, "razor": _razor,
    "inhaler": _inhaler, "bandage": _bandage, "clipper": _clipper, "denture": _denture, "diaper": _diaper,
    "loofah": _loofah, "soap_dish": _soap_dish,
}  # fmt: skip


@shape("toiletry_small")
def toiletry(k: Kit) -> None:
    """Small things from the bathroom shelf."""
    k.unit()
    _TOILETRIES[k.name](k)


@shape("doll_soft")
def doll(k: Kit) -> None:
    """Sitting: head with ears or hair, body, arms and legs."""
    k.unit()
    bear = k.name == "teddy_bear"
    fur = (156, 104, 62) if bear else (236, 196, 168)
    body = fur if bear else (226, 96, 150)
    k.ball((-0.36, 0.14), (-0.3, 0.3), (0, 0.62), body, FABRIC)
    k.ball((-0.34, 0.2), (-0.26, 0.26), (0.52, 0.96), fur, FABRIC)
    for s in (-1, 1):
        k.rod((0.0, s * 0.16, 0.1), (0.44, s * 0.32, 0.1), 0.2 * k.size[2], fur, FABRIC, kind="cylinder")
        k.ball((0.3, 0.5), (s * 0.32 - 0.12, s * 0.32 + 0.12), (0, 0.3), shade(fur, 0.9) if bear else WHITE, FABRIC)
        k.rod((-0.1, s * 0.26, 0.5), (0.1, s * 0.46, 0.26), 0.16 * k.size[2], fur, FABRIC, kind="cylinder")
        if bear:
            k.ball((-0.12, 0.02), (s * 0.2 - 0.1, s * 0.2 + 0.1), (0.82, 1.0), shade(fur, 0.85), FABRIC)
        k.ball((0.14, 0.22), (s * 0.1 - 0.03, s * 0.1 + 0.03), (0.74, 0.82), BLACK)
    if bear:
        k.ball((0.1, 0.3), (-0.12, 0.12), (0.58, 0.76), (216, 176, 128), FABRIC)
        k.ball((0.24, 0.32), (-0.04, 0.04), (0.68, 0.76), BLACK)
    else:
        k.ball((-0.42, 0.1), (-0.3, 0.3), (0.62, 1.0), (120, 70, 36), FABRIC)


def _globe(k: Kit) -> None:
    k.cyl((-0.3, 0.3), (-0.3, 0.3), (0, 0.06), BROWN, Material.WOOD)
    k.box((-0.04, 0.04), (-0.04, 0.04), (0.06, 0.2), GOLD, METAL)
    k.ball(*FULL, (0.16, 1.0), (60, 120, 190))
    for x0, y0, z0 in ((0.1, -0.3, 0.5), (0.1, 0.1, 0.3), (-0.2, 0.2, 0.6), (-0.45, -0.3, 0.4), (0.0, -0.2, 0.74)):
        k.ball((x0, x0 + 0.36), (y0, y0 + 0.3), (z0, z0 + 0.24), (80, 150, 80))


def _dice(k: Kit) -> None:
    k.box(*FULL, (0, 1), (246, 244, 240))
    for x0, y0 in ((-0.3, -0.3), (0.14, 0.14), (-0.08, -0.08)):
        k.cyl((x0, x0 + 0.18), (y0, y0 + 0.18), (0.99, 1.01), BLACK)
    for y0, z0 in ((-0.3, 0.14), (0.12, 0.66)):
        k.cyl((0.49, 0.51), (y0, y0 + 0.18), (z0, z0 + 0.18), BLACK, axis="x")
    k.cyl((-0.09, 0.09), (0.49, 0.51), (0.4, 0.6), RED, axis="y")


def _toy_car(k: Kit) -> None:
    k.box((-0.5, 0.5), (-0.46, 0.46), (0.16, 0.56), RED)
    k.box((-0.3, 0.16), (-0.42, 0.42), (0.56, 0.9), (150, 200, 226), Material.GLASS)
    k.box((-0.3, 0.1), (-0.42, 0.42), (0.9, 1.0), RED)
    for fx in (-0.3, 0.3):
        for s in (-1, 1):
            c, d = sorted((s * 0.5, s * 0.36))
            k.cyl((fx - 0.13, fx + 0.13), (c, d), (0, 0.36), BLACK, axis="y")
    for side in (-0.3, 0.3):
        k.cyl((0.49, 0.51), (side - 0.1, side + 0.1), (0.32, 0.5), YELLOW, axis="x")


def _toy_figure(k: Kit) -> None:
    k.box((-0.2, 0.2), (-0.24, 0.24), (0.3, 0.7), BLUE)
    k.ball((-0.24, 0.24), (-0.2, 0.2), (0.64, 1.0), (236, 190, 150))
    for s in (-1, 1):
        k.box((-0.5, 0.5), (s * 0.14 - 0.1, s * 0.14 + 0.1), (0, 0.3), RED)
        k.box((-0.1, 0.12), (s * 0.4 - 0.1, s * 0.4 + 0.1), (0.34, 0.66), YELLOW)


def _hourglass(k: Kit) -> None:
    for x0 in (-0.5, 0.4):
        k.cyl((x0, x0 + 0.1), (-0.5, 0.5), (0, 1), (150, 104, 62), Material.WOOD, axis="x")
    k.cyl((-0.4, 0.0), (-0.4, 0.4), (0.1, 0.9), (226, 200, 140), Material.GLASS, axis="x", taper=0.2)
    k.cyl((0.0, 0.4), (-0.08, 0.08), (0.42, 0.58), (206, 226, 234), Material.GLASS, axis="x", taper=5.0)
    for y0, z0 in ((-0.44, 0.5), (0.4, 0.5)):
        k.box((-0.4, 0.4), (y0, y0 + 0.05), (z0 - 0.03, z0 + 0.03), (150, 104, 62), Material.WOOD)


def _dreidel(k: Kit) -> None:
    k.box(*FULL, (0.3, 0.75), BLUE)
    k.cyl((-0.1, 0.1), (-0.1, 0.1), (0, 0.3), BLUE, None, taper=4.5)
    k.cyl((-0.08, 0.08), (-0.08, 0.08), (0.75, 1.0), TAN)
    k.box((0.49, 0.52), (-0.2, 0.2), (0.4, 0.66), GOLD)


def _seashell(k: Kit) -> None:
    for i in range(5):
        a = -0.8 + 0.4 * i
        tip = (0.4 * cos(a), 0.42 * sin(a), 0.5)
        color = shade((230, 190, 160), 0.9 + 0.06 * i)
        k.rod((-0.44, 0, 0.4), tip, (0.5 * k.size[2], 0.024), color, kind="sphere")
    k.ball((-0.5, 0.3), (-0.3, 0.3), (0, 0.7), (240, 214, 186))


def _blocks(k: Kit) -> None:
    colors = (RED, YELLOW, (60, 120, 200), GREEN)
    k.box((-0.5, 0.0), (-0.5, 0.0), (0, 0.5), colors[0])
    k.box((-0.5, 0.0), (0.0, 0.5), (0, 0.5), colors[1])
    k.box((0.0, 0.5), (-0.3, 0.3), (0, 0.5), colors[2])
    k.box((-0.4, 0.1), (-0.25, 0.25), (0.5, 1.0), colors[3])


def _abacus(k: Kit) -> None:
    for s in (-1, 1):
        c, d = sorted((s * 0.5, s * 0.44))
        k.box((-0.2, 0.2), (c, d), (0.06, 1), (170, 124, 78), Material.WOOD)
    k.box((-0.2, 0.2), (-0.44, 0.44), (0.94, 1), (170, 124, 78), Material.WOOD)
    k.box((-0.5, 0.5), (-0.5, 0.5), (0, 0.06), (170, 124, 78), Material.WOOD)
    for i, color in enumerate((RED, YELLOW, GREEN, BLUE)):
        z0 = 0.16 + 0.2 * i
        k.box((-0.04, 0.04), (-0.44, 0.44), (z0 + 0.04, z0 + 0.07), GREY)
        k.cyl((-0.3, 0.3), (-0.36 + 0.1 * i, 0.1 + 0.1 * i), (z0, z0 + 0.12), color, axis="y")


def _mock_up(k: Kit) -> None:
    k.box(*FULL, (0, 0.06), GREEN)
    k.box((-0.36, 0.36), (-0.4, 0.1), (0.06, 0.6), CREAM)
    k.wedge((-0.42, 0.0), (-0.44, 0.14), (0.6, 1.0), RED)
    k.wedge((0.0, 0.42), (-0.44, 0.14), (0.6, 1.0), RED, flip=True)
    k.box((0.36, 0.38), (-0.24, -0.06), (0.06, 0.4), BROWN)
    k.ball((-0.2, 0.3), (0.2, 0.5), (0.1, 0.6), (60, 130, 60))


def _beach(k: Kit) -> None:
    k.box((-0.5, 0.0), (-0.1, 0.1), (0.2, 0.8), RED)
    k.ball((-0.1, 0.5), (-0.5, 0.5), (0, 1), YELLOW)


_TOYS = {
    "globe": _globe, "dice": _dice, "toy_dice": _dice, "toy_car": _toy_car, "toy_figure": _toy_figure,
    "hourglass": _hourglass, "dreidel": _dreidel, "seashell": _seashell, "toy": _blocks, "alphabet_abacus": _abacus,
    "classroom_mock_up": _mock_up, "beach_toy": _beach,
}  # fmt: skip


@shape("toy_small")
def toy(k: Kit) -> None:
    """Toys and curios."""
    k.unit()
    _TOYS[k.name](k)


@shape("pet_box")
def pet_house(k: Kit) -> None:
    """Bird cage, bird feeder, chicken coop."""
    x, y, z = k.size
    if k.name == "chicken_coop":
        k.box((-x / 2 + 0.1, x / 2 - 0.1), (-y / 2 + 0.1, y / 2 - 0.1), (0.35 * z, 0.4 * z))
        k.box((-x / 2 + 0.1, -x / 2 + 0.14), (-y / 2 + 0.1, y / 2 - 0.1), (0.4 * z, 0.72 * z))
        for s in (-1, 1):
            c, d = sorted((s * (y / 2 - 0.1), s * (y / 2 - 0.14)))
            k.box((-x / 2 + 0.14, x / 2 - 0.1), (c, d), (0.4 * z, 0.72 * z))
            for fx in (-x / 2 + 0.1, x / 2 - 0.16):
                k.box((fx, fx + 0.06), (c, d), (0, 0.35 * z), shade(k.color, 0.7))
        k.wedge((-x / 2, 0.0), (-y / 2, y / 2), (0.72 * z, z), (150, 60, 50))
        k.wedge((0.0, x / 2), (-y / 2, y / 2), (0.72 * z, z), (150, 60, 50), flip=True)
        k.space((-x / 2 + 0.16, x / 2 - 0.12), (-y / 2 + 0.16, y / 2 - 0.16), (0.4 * z, 0.7 * z))
        return
    k.unit()
    if k.name == "birdcage":
        k.cyl(*FULL, (0, 0.08), (90, 140, 180))
        for i in range(8):
            a = 2 * pi * i / 8
            u, v = 0.46 * cos(a), 0.46 * sin(a)
            k.path([(u, v, 0.08), (u, v, 0.7)], 0.008, GOLD, METAL)
        k.cyl((-0.48, 0.48), (-0.48, 0.48), (0.7, 0.92), GOLD, METAL, taper=0.25)
        k.ball((-0.12, 0.12), (-0.1, 0.1), (0.9, 1.0), GOLD, METAL)
        k.ball((-0.14, 0.2), (-0.12, 0.12), (0.25, 0.5), (240, 210, 60))
        k.box((-0.03, 0.03), (-0.44, 0.44), (0.22, 0.26), BROWN, Material.WOOD)
        return
    k.box(*FULL, (0, 0.08), BROWN, Material.WOOD)
    k.box((-0.32, 0.32), (-0.32, 0.32), (0.08, 0.62), (222, 196, 130), Material.GLASS)
    k.wedge((-0.5, 0.0), (-0.5, 0.5), (0.62, 0.94), (150, 60, 50))
    k.wedge((0.0, 0.5), (-0.5, 0.5), (0.62, 0.94), (150, 60, 50), flip=True)
    k.box((-0.06, 0.06), (-0.06, 0.06), (0.9, 1.0), DARK)
    k.cyl((0.3, 0.5), (-0.04, 0.04), (0.12, 0.18), TAN, axis="x")


def _glass_shards(k: Kit) -> None:
    for i, (x0, y0) in enumerate(((-0.5, -0.4), (-0.1, -0.5), (0.0, 0.1), (-0.4, 0.2))):
        k.wedge(
            (x0, x0 + 0.5), (y0, y0 + 0.4), (0, 1 - 0.2 * (i % 2)), (190, 220, 230), Material.GLASS, flip=bool(i % 2)
        )


def _feather(k: Kit) -> None:
    k.ball((-0.2, 0.5), (-0.5, 0.5), (0.2, 0.8), (240, 240, 244))
    k.rod((-0.5, 0, 0.2), (0.4, 0, 0.9), 0.004, (180, 160, 130))


def _leaf(k: Kit) -> None:
    k.ball((-0.5, 0.5), (-0.36, 0.5), (0, 0.9), (80, 150, 60), Material.PLANT)
    k.rod((0, -0.5, 0.5), (0, 0.44, 0.9), 0.004, (120, 90, 50))


def _pebble(k: Kit) -> None:
    k.ball((-0.5, 0.5), (-0.5, 0.5), (0, 1), None, Material.CONCRETE)
    k.ball((-0.4, 0.3), (-0.3, 0.48), (0.1, 0.98), shade(k.color, 1.15), Material.CONCRETE)


def _pellet(k: Kit) -> None:
    for x0, y0, z0 in ((-0.5, -0.5, 0), (0.0, -0.5, 0), (-0.5, 0.0, 0), (0.0, 0.0, 0), (-0.25, -0.25, 0.5)):
        k.cyl((x0, x0 + 0.5), (y0, y0 + 0.5), (z0, z0 + 0.5), shade(k.color, 0.85 + 0.05 * len(k.parts)))


def _bulb(k: Kit) -> None:
    k.ball(*FULL, (0, 0.8), BROWN)
    k.cyl((-0.14, 0.14), (-0.14, 0.14), (0.7, 1.0), (120, 160, 80), None, taper=0.3)


def _cone(k: Kit) -> None:
    for i in range(4):
        r = 0.5 - 0.11 * i
        k.cyl((-r, r), (-r, r), (0.24 * i, 0.24 * i + 0.28), shade(BROWN, 0.9 + 0.08 * (i % 2)), None, taper=0.7)


def _cube(k: Kit) -> None:
    k.box(*FULL, (0, 1), (130, 132, 138), Material.CONCRETE)
    k.box((-0.4, 0.4), (-0.4, 0.4), (0.98, 1.01), (156, 158, 164), Material.CONCRETE)


_SEEDS = {
    "broken_glass": _glass_shards, "feather": _feather, "leaf": _leaf, "pebble": _pebble, "pellet": _pellet,
    "daffodil_bulb": _bulb, "pine_cone": _cone, "whiskey_stone": _cube,
}  # fmt: skip


@shape("seed_tiny")
def garden_bit(k: Kit) -> None:
    """Bulbs, cones, stones, leaves."""
    k.unit()
    _SEEDS[k.name](k)
