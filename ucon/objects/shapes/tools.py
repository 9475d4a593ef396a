"""Tools with handles, and building material."""

from __future__ import annotations

from ucon.objects.kit import Kit, shape
from ucon.objects.model import Material
from ucon.objects.palette import BLACK, DARK, GREY, RED, SILVER, WHITE, YELLOW, shade
from ucon.objects.shapes.cabinets import hang_below
from ucon.objects.shapes.generic import torus

METAL = Material.METAL
GRAIN = Material.WOOD
HANDLE = (150, 104, 62)


def _axe(k: Kit) -> None:
    k.box((-0.5, 0.5), (-0.5, -0.3), (0.2, 0.8), HANDLE, GRAIN)
    k.box((0.26, 0.46), (-0.5, 0.2), (0.0, 1.0), (170, 60, 50), METAL)
    k.box((0.22, 0.5), (0.2, 0.5), (0.3, 0.7), SILVER, METAL)


def _hammer(k: Kit) -> None:
    k.box((-0.5, 0.4), (-0.12, 0.12), (0.25, 0.75), HANDLE, GRAIN)
    k.box((0.32, 0.5), (-0.28, 0.3), (0, 1), DARK, METAL)
    k.cyl((0.34, 0.48), (0.3, 0.5), (0.1, 0.9), GREY, METAL, axis="y")
    k.box((0.36, 0.46), (-0.5, -0.28), (0.3, 0.7), GREY, METAL)


def _hoe(k: Kit) -> None:
    k.rod((-0.3, -0.5, 0.3), (-0.3, 0.46, 0.3), 0.026, HANDLE, GRAIN)
    k.box((-0.5, 0.5), (0.42, 0.46), (0, 1), GREY, METAL)
    k.rod((-0.3, 0.4, 0.4), (0.0, 0.44, 0.6), 0.02, GREY, METAL)


def _rake(k: Kit) -> None:
    k.rod((-0.5, 0, 0.7), (0.36, 0, 0.7), 0.026, HANDLE, GRAIN)
    k.box((0.34, 0.38), (-0.5, 0.5), (0.5, 0.9), (60, 130, 70))
    for i in range(8):
        y0 = -0.5 + 0.135 * i
        k.box((0.38, 0.5), (y0, y0 + 0.05), (0, 0.9), (60, 130, 70))


def _shovel(k: Kit) -> None:
    k.rod((-0.44, 0, 0.6), (0.2, 0, 0.6), 0.026, HANDLE, GRAIN)
    k.box((-0.5, -0.44), (-0.4, 0.4), (0.3, 1.0), BLACK)
    k.box((0.16, 0.42), (-0.5, 0.5), (0.1, 0.5), GREY, METAL)
    k.ball((0.32, 0.5), (-0.5, 0.5), (0.1, 0.5), GREY, METAL)


def _trowel(k: Kit) -> None:
    k.cyl((-0.5, -0.06), (-0.36, 0.36), (0.1, 1.0), (60, 140, 70), axis="x")
    k.box((-0.06, 0.06), (-0.12, 0.12), (0.3, 0.6), SILVER, METAL)
    k.ball((0.0, 0.5), (-0.5, 0.5), (0.1, 0.6), SILVER, METAL)


def _pruner(k: Kit) -> None:
    for s in (-1, 1):
        k.rod((-0.5, 0.36 * s, 0.5), (0.1, 0.05 * s, 0.5), 0.014, RED)
        k.rod((0.1, -0.04 * s, 0.5), (0.5, 0.24 * s, 0.5), (0.006, 0.018), SILVER, METAL)
    k.cyl((0.06, 0.16), (-0.14, 0.14), (0, 1), SILVER, METAL)


_LONG_TOOLS = {
    "axe": _axe, "hammer": _hammer, "hoe": _hoe, "rake": _rake, "shovel": _shovel, "trowel": _trowel, "pruner": _pruner,
}  # fmt: skip


@shape("tool_stick")
def long_tool(k: Kit) -> None:
    """Tools with a handle, lying."""
    k.unit()
    _LONG_TOOLS[k.name](k)


def _coil(k: Kit) -> None:
    torus(k, 0.4, 0.22, (0, 0.6), k.color, k.material)
    torus(k, 0.34, 0.2, (0.4, 1.0), shade(k.color, 0.85), k.material)


def _log(k: Kit) -> None:
    along_x = k.size[0] > k.size[1]
    axis = "x" if along_x else "y"
    k.cyl((-0.5, 0.5), (-0.5, 0.5), (0, 1), (112, 78, 52), GRAIN, axis=axis)
    for s in (-1, 1):
        c, d = sorted((s * 0.5, s * 0.505))
        spans = ((c, d), (-0.42, 0.42)) if along_x else ((-0.42, 0.42), (c, d))
        k.cyl(*spans, (0.08, 0.92), (216, 176, 120), GRAIN, axis=axis)


def _tire(k: Kit) -> None:
    torus(k, 0.38, 0.26, (0, 1), BLACK)
    k.cyl((-0.26, 0.26), (-0.26, 0.26), (0.1, 0.9), SILVER, METAL)
    k.cyl((-0.3, 0.3), (-0.3, 0.3), (0.4, 0.5), WHITE)


def _tile(k: Kit) -> None:
    k.box((-0.5, 0.5), (-0.5, 0.5), (0, 0.8), shade(k.color, 0.85), Material.TILE)
    k.box(
        (-0.47, 0.47),
        (-0.47, 0.47),
        (0.8, 1.0),
        (150, 190, 210) if k.name == "ceramic_tile" else k.color,
        Material.TILE,
    )


def _pallet(k: Kit) -> None:
    for i in range(5):
        x0 = -0.5 + 0.21 * i
        k.box((x0, x0 + 0.16), (-0.5, 0.5), (0.85, 1.0), k.color, GRAIN)
    for y0 in (-0.5, -0.06, 0.38):
        k.box((-0.5, 0.5), (y0, y0 + 0.12), (0.12, 0.85), shade(k.color, 0.85), GRAIN)
        k.box((-0.5, 0.5), (y0, y0 + 0.12), (0, 0.12), shade(k.color, 0.75), GRAIN)


def _mousetrap(k: Kit) -> None:
    k.box((-0.5, 0.5), (-0.5, 0.5), (0, 0.5), k.color, GRAIN)
    k.box((-0.4, 0.0), (-0.4, -0.3), (0.5, 1.0), SILVER, METAL)
    k.box((-0.4, 0.0), (0.3, 0.4), (0.5, 1.0), SILVER, METAL)
    k.box((-0.05, 0.05), (-0.4, 0.4), (0.5, 1.0), SILVER, METAL)
    k.box((0.2, 0.34), (-0.15, 0.15), (0.5, 0.9), YELLOW)


def _hook(k: Kit) -> None:
    k.box((-0.5, -0.3), (-0.3, 0.3), (0, 1), SILVER, METAL)
    k.box((-0.3, 0.4), (-0.1, 0.1), (0.1, 0.4), SILVER, METAL)
    k.box((0.3, 0.5), (-0.5, 0.5), (0.1, 0.8), SILVER, METAL)
    hang_below(k, 0.3)


def _plain_wood(k: Kit) -> None:
    k.box((-0.5, 0.5), (-0.5, 0.5), (0, 0.9), k.color, GRAIN if k.name == "plywood" else Material.CONCRETE)
    k.box(
        (-0.46, 0.46),
        (-0.46, 0.46),
        (0.9, 1.0),
        shade(k.color, 1.1),
        GRAIN if k.name == "plywood" else Material.CONCRETE,
    )


def _line(k: Kit) -> None:
    along_x = k.size[0] > k.size[1]
    for i in range(6):
        a = -0.5 + i / 6
        span = (a, a + 1 / 6 + 0.002)
        color = shade(k.color, 0.8 + 0.2 * (i % 2))
        k.box(span if along_x else (-0.5, 0.5), (-0.5, 0.5) if along_x else span, (0, 1), color)


_MISC = {
    "copper_wire": _coil, "log": _log, "firewood": _log, "whitewall_tire": _tire, "ceramic_tile": _tile, "tile": _tile,
    "pallet": _pallet, "mousetrap": _mousetrap, "hook": _hook, "plywood": _plain_wood, "paving_stone": _plain_wood,
    "rope": _coil, "bicycle_chain": _line,
}  # fmt: skip


@shape("tool_misc")
def building_material(k: Kit) -> None:
    """Wire, logs, tyres, tiles, pallets."""
    k.unit()
    _MISC[k.name](k)
    if k.category.support:
        x, y, z = k.size
        k.surface((-x * 0.46, x * 0.46), (-y * 0.46, y * 0.46), z)


@shape("ladder")
def ladder(k: Kit) -> None:
    """Two rails with rungs, standing."""
    x, y, z = k.size
    for s in (-1, 1):
        c, d = sorted((s * y / 2, s * (y / 2 - 0.035)))
        k.box((x * 0.2, x / 2), (c, d), (0, z), SILVER, METAL)
        k.rod((x * 0.3, s * (y / 2 - 0.02), z - 0.1), (-x / 2 + 0.015, s * (y / 2 - 0.02), 0.01), 0.025, SILVER, METAL)
    for i in range(6):
        low = (i + 0.7) * z / 6.6
        k.box(
            (x * 0.22, x * 0.48),
            (-y / 2 + 0.035, y / 2 - 0.035),
            (low, low + 0.03),
            (200, 60, 40) if i == 5 else GREY,
            METAL,
        )
    k.surface((x * 0.22, x * 0.48), (-y / 2 + 0.04, y / 2 - 0.04), 5.7 * z / 6.6 + 0.03)
