"""Books, paper, pens and what stands on a desk."""

from __future__ import annotations

from math import cos, pi, sin

from ucon.objects.kit import Kit, shape
from ucon.objects.model import Material
from ucon.objects.palette import BLUE, DARK, GREEN, ORANGE, PAPER, PINK, RED, SILVER, TAN, WHITE, YELLOW, shade
from ucon.objects.shapes.generic import open_box, ring, torus
from ucon.objects.shapes.hollow import round_space

METAL = Material.METAL
SHEET = Material.PAPER

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
