"""Cutlery, knives and kitchen utensils."""

from __future__ import annotations

from ucon.objects.kit import Kit, shape
from ucon.objects.model import Material
from ucon.objects.palette import BLACK, DARK, DARKBROWN, GREY, RED, SILVER, WHITE, shade

METAL = Material.METAL
GRAIN = Material.WOOD
HANDLE = (150, 104, 62)


@shape("knife")
def knife(k: Kit) -> None:
    """Blade and handle."""
    k.unit()
    if k.name == "pocketknife":
        k.box((-0.5, 0.1), (-0.5, 0.5), (0, 1), RED)
        k.box((0.1, 0.5), (-0.3, 0.2), (0.3, 0.6), SILVER, METAL)
        k.box((-0.3, -0.1), (-0.12, 0.12), (0.98, 1.02), WHITE)
        return
    wide = 0.5 if k.name == "cleaver" else 0.4
    k.box((-0.5, -0.12), (-0.22, 0.22), (0.0, 1.0), DARKBROWN, GRAIN)
    k.box((-0.12, 0.4), (-wide, 0.5), (0.35, 0.6), SILVER, METAL)
    k.wedge((0.4, 0.5), (-0.2, 0.5), (0.35, 0.6), SILVER, METAL, flip=True)


@shape("knife_block")
def knife_block(k: Kit) -> None:
    """A slanted block with five black handles."""
    k.unit()
    k.wedge((-0.5, 0.1), (-0.5, 0.5), (0, 0.72), HANDLE, GRAIN)
    k.box((0.1, 0.4), (-0.5, 0.5), (0, 0.72), HANDLE, GRAIN)
    for i in range(5):
        y0 = -0.36 + 0.18 * i
        k.rod((0.2, y0, 0.66), (0.46 - 0.1 * (i % 2), y0, 1.0 - 0.06 * (i % 2)), 0.018, BLACK)


def _fork(k: Kit) -> None:
    k.box((-0.5, 0.2), (-0.2, 0.2), (0.3, 0.7), SILVER, METAL)
    k.box((0.18, 0.3), (-0.5, 0.5), (0.2, 0.8), SILVER, METAL)
    for i in range(4):
        y0 = -0.5 + 0.29 * i
        k.box((0.3, 0.5), (y0, y0 + 0.13), (0.3, 0.8), SILVER, METAL)
    k.box((-0.5, -0.42), (-0.34, 0.34), (0.2, 1.0), SILVER, METAL)


def _spoon(k: Kit) -> None:
    color, material = (HANDLE, GRAIN) if k.name == "wooden_spoon" else (SILVER, METAL)
    k.box((-0.5, 0.2), (-0.16, 0.16), (0.3, 0.8), color, material)
    k.ball((0.12, 0.5), (-0.5, 0.5), (0, 1.0), color, material)
    k.ball((0.18, 0.46), (-0.36, 0.36), (0.5, 1.04), shade(color, 0.8), material)


def _table_knife(k: Kit) -> None:
    k.box((-0.5, 0.0), (-0.36, 0.36), (0, 1.0), SILVER, METAL)
    k.box((0.0, 0.5), (-0.5, 0.5), (0.3, 0.7), (214, 216, 220), METAL)


def _ladle(k: Kit) -> None:
    k.rod((-0.5, 0, 0.9), (0.25, 0, 0.5), 0.012, SILVER, METAL)
    k.cyl((0.14, 0.5), (-0.5, 0.5), (0, 0.6), SILVER, METAL, taper=1.2)
    k.cyl((0.16, 0.48), (-0.42, 0.42), (0.58, 0.62), DARK)


def _spatula(k: Kit) -> None:
    k.box((-0.5, -0.1), (-0.2, 0.2), (0.4, 1.0), BLACK)
    k.rod((-0.1, 0, 0.7), (0.2, 0, 0.2), 0.01, SILVER, METAL)
    k.box((0.16, 0.5), (-0.5, 0.5), (0, 0.25), DARK)


def _tongs(k: Kit) -> None:
    for s in (-1, 1):
        k.rod((-0.48, 0.04 * s, 0.5), (0.4, 0.42 * s, 0.5), (0.02, 0.01), SILVER, METAL)
        k.ball((0.34, 0.5), (0.4 * s - 0.14, 0.4 * s + 0.14), (0, 1.0), BLACK)
    k.box((-0.5, -0.42), (-0.14, 0.14), (0.1, 0.9), SILVER, METAL)


def _whisk(k: Kit) -> None:
    k.cyl((-0.5, -0.08), (-0.2, 0.2), (0.3, 0.7), DARK, axis="x")
    for i in range(4):
        dy, dz = ((0.5, 0.0), (-0.5, 0.0), (0.0, 0.5), (0.0, -0.5))[i]
        k.path([(-0.08, 0, 0.5), (0.2, dy * 0.96, 0.5 + dz * 0.96), (0.48, 0, 0.5)], 0.007, SILVER, METAL)


def _pestle(k: Kit) -> None:
    k.cyl((-0.5, 0.3), (-0.3, 0.3), (0.2, 0.8), None, Material.CONCRETE, axis="x", taper=1.3)
    k.ball((0.1, 0.5), (-0.5, 0.5), (0, 1), None, Material.CONCRETE)


def _stick(k: Kit) -> None:
    k.box((-0.5, 0.5), (-0.5, 0.5), (0, 1), k.color, GRAIN)


_UTENSILS = {
    "tablefork": _fork, "tablespoon": _spoon, "teaspoon": _spoon, "wooden_spoon": _spoon, "table_knife": _table_knife,
    "soup_ladle": _ladle, "spatula": _spatula, "tongs": _tongs, "whisk": _whisk, "pestle": _pestle,
    "cookie_stick": _stick,
}  # fmt: skip


@shape("utensil_stick")
def utensil(k: Kit) -> None:
    """Cutlery and cooking tools, lying along x."""
    k.unit()
    _UTENSILS[k.name](k)


@shape("lid_disc")
def lid(k: Kit) -> None:
    """A disc or dome with a knob."""
    k.unit()
    dome = k.name == "cloche"
    k.cyl((-0.5, 0.5), (-0.5, 0.5), (0, 0.2 if not dome else 0.1), SILVER, METAL)
    k.ball((-0.46, 0.46), (-0.46, 0.46), (-0.55 if dome else -0.2, 0.86 if dome else 0.6), (206, 210, 214), METAL)
    k.cyl((-0.08, 0.08), (-0.08, 0.08), (0.55 if not dome else 0.8, 0.9), DARK)
    k.ball((-0.12, 0.12), (-0.12, 0.12), (0.72 if not dome else 0.86, 1.0), DARK)


@shape("teapot")
def teapot(k: Kit) -> None:
    """Belly, spout in front, handle behind, lid."""
    k.unit()
    metal = METAL if k.name == "pewter_teapot" else None
    k.ball((-0.3, 0.28), (-0.5, 0.5), (-0.04, 0.8), k.color, metal)
    k.cyl((-0.2, 0.18), (-0.3, 0.3), (0, 0.1), k.color, metal)
    k.cyl((-0.16, 0.14), (-0.24, 0.24), (0.72, 0.86), shade(k.color, 0.9), metal)
    k.ball((-0.06, 0.04), (-0.08, 0.08), (0.84, 1.0), (70, 110, 170) if metal is None else DARK)
    k.rod((0.2, 0, 0.3), (0.48, 0, 0.74), 0.026, k.color, metal)
    k.path([(-0.24, 0, 0.66), (-0.46, 0, 0.62), (-0.46, 0, 0.3), (-0.26, 0, 0.24)], 0.016, shade(k.color, 0.85), metal)
    k.cyl((-0.2, 0.18), (-0.505, 0.505), (0.36, 0.44), (70, 110, 170) if metal is None else GREY)


@shape("straw")
def straw(k: Kit) -> None:
    """A striped straw; a cork."""
    k.unit()
    if k.name == "cork":
        k.cyl((-0.5, 0.5), (-0.5, 0.5), (0, 1), (206, 166, 116), GRAIN, taper=0.85)
        k.cyl((-0.36, 0.36), (-0.36, 0.36), (0.98, 1.01), (150, 60, 60))
        return
    for i in range(6):
        x0 = -0.5 + i / 6
        k.box((x0, x0 + 1 / 6), (-0.5, 0.5), (0, 1), RED if i % 2 else WHITE)
