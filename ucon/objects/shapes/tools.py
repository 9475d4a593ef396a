"""Tools, cleaning things, cutlery and kitchen utensils."""

from __future__ import annotations

from ucon.objects.kit import (
    BLACK,
    BLUE,
    DARK,
    DARKBROWN,
    GREY,
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
from ucon.objects.shapes.cabinets import hang_below
from ucon.objects.shapes.generic import torus

METAL = Material.METAL
GRAIN = Material.WOOD
HANDLE = (150, 104, 62)


@shape("broom_stick")
def broom(k: Kit) -> None:
    """Standing: bristles or strands below, a long stick above; a squeegee lies."""
    x, y, z = k.size
    if k.name == "squeegee":
        k.unit()
        k.box((-0.5, 0.3), (-0.05, 0.05), (0.2, 0.8), BLUE)
        k.box((0.26, 0.44), (-0.5, 0.5), (0.1, 1.0), BLUE)
        k.box((0.44, 0.5), (-0.5, 0.5), (0, 0.6), BLACK)
        return
    k.cyl((-0.014, 0.014), (-0.014, 0.014), (0.14, z), (196, 150, 96), GRAIN)
    if k.name == "mop":
        k.box((-0.03, 0.03), (-y * 0.3, y * 0.3), (0.14, 0.2), RED)
        for i in range(5):
            y0 = (-0.5 + 0.2 * i) * y
            k.box(
                (-x / 2, x / 2),
                (y0, y0 + 0.19 * y),
                (0, 0.16 - 0.02 * (i % 2)),
                shade((206, 206, 200), 0.88 + 0.06 * (i % 3)),
            )
        return
    k.box((-x * 0.3, x * 0.3), (-y / 2, y / 2), (0.14, 0.19), RED)
    for i in range(4):
        y0 = (-0.5 + 0.25 * i) * y
        k.box((-x / 2, x / 2), (y0, y0 + 0.245 * y), (0, 0.14), shade((222, 186, 96), 0.9 + 0.05 * (i % 2)))


def _dustpan(k: Kit) -> None:
    k.box((-0.1, 0.5), (-0.5, 0.5), (0, 0.3))
    k.box((-0.14, -0.06), (-0.5, 0.5), (0, 1.0))
    for s in (-1, 1):
        c, d = sorted((s * 0.5, s * 0.44))
        k.box((-0.1, 0.4), (c, d), (0, 0.8))
    k.box((-0.5, -0.1), (-0.1, 0.1), (0.4, 0.9), shade(k.color, 0.8))


def _eraser(k: Kit) -> None:
    k.box((-0.5, 0.5), (-0.5, 0.5), (0, 0.5), (90, 90, 96), Material.FABRIC)
    k.box((-0.5, 0.5), (-0.46, 0.46), (0.5, 1.0), HANDLE, GRAIN)


def _paintbrush(k: Kit) -> None:
    k.box((-0.5, 0.1), (-0.3, 0.3), (0.2, 0.8), HANDLE, GRAIN)
    k.box((0.1, 0.22), (-0.5, 0.5), (0, 1.0), SILVER, METAL)
    k.box((0.22, 0.5), (-0.45, 0.45), (0.1, 0.9), RED)


def _pipe_cleaner(k: Kit) -> None:
    k.box((-0.5, 0.5), (-0.1, 0.1), (0.4, 0.6), SILVER)
    for i in range(5):
        x0 = -0.4 + 0.17 * i
        k.ball((x0, x0 + 0.18), (-0.5, 0.5), (0, 1), (240, 240, 240) if i % 2 else (210, 220, 230), Material.FABRIC)


def _scraper(k: Kit) -> None:
    k.box((-0.5, 0.1), (-0.25, 0.25), (0, 1), (220, 120, 40))
    k.box((0.1, 0.5), (-0.5, 0.5), (0.3, 0.5), SILVER, METAL)


def _scrub(k: Kit) -> None:
    k.ball((-0.5, 0.5), (-0.5, 0.5), (0.35, 1.0), BLUE)
    k.box((-0.45, 0.45), (-0.42, 0.42), (0, 0.6), WHITE)


_BRUSHES = {
    "dustpan": _dustpan, "blackboard_eraser": _eraser, "paintbrush": _paintbrush, "pipe_cleaner": _pipe_cleaner,
    "scraper": _scraper, "scrub_brush": _scrub,
}  # fmt: skip


@shape("brush_small")
def brush(k: Kit) -> None:
    """Handle and bristles."""
    k.unit()
    _BRUSHES[k.name](k)


@shape("sponge")
def sponge(k: Kit) -> None:
    """A yellow block with a green scouring face; steel wool; sandpaper."""
    k.unit()
    if k.name == "steel_wool":
        for i in range(3):
            x0 = -0.5 + 0.32 * i
            k.ball((x0, x0 + 0.36), (-0.5, 0.5), (0, 1), shade((150, 152, 158), 0.9 + 0.06 * i), METAL)
    elif k.name == "emery_paper":
        k.box((-0.5, 0.5), (-0.5, 0.5), (0, 0.5), TAN, Material.PAPER)
        k.box((-0.48, 0.48), (-0.48, 0.48), (0.5, 1), (120, 66, 44), Material.CONCRETE)
    else:
        k.box((-0.5, 0.5), (-0.5, 0.5), (0, 0.7), (240, 208, 60))
        k.box((-0.5, 0.5), (-0.5, 0.5), (0.7, 1), (50, 130, 70))
    x, y, z = k.size
    if k.name != "steel_wool":
        k.surface((-x * 0.45, x * 0.45), (-y * 0.45, y * 0.45), z)


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


@shape("iron")
def iron(k: Kit) -> None:
    """A pointed sole, body and handle."""
    k.unit()
    k.box((-0.5, 0.2), (-0.5, 0.5), (0, 0.12), SILVER, METAL)
    k.cyl((-0.1, 0.5), (-0.46, 0.46), (0, 0.12), SILVER, METAL)
    k.box((-0.48, 0.1), (-0.44, 0.44), (0.12, 0.5), (70, 130, 200))
    k.ball((-0.2, 0.42), (-0.42, 0.42), (0.0, 0.6), (70, 130, 200))
    k.box((-0.5, -0.36), (-0.16, 0.16), (0.5, 0.9), WHITE)
    k.box((-0.5, 0.2), (-0.16, 0.16), (0.84, 1.0), WHITE)
    k.rod((0.12, 0, 0.88), (0.22, 0, 0.5), 0.03, WHITE)


@shape("ironing_board")
def ironing_board(k: Kit) -> None:
    """A padded board on crossed legs."""
    x, y, z = k.size
    k.box((-x / 2, x * 0.3), (-y / 2, y / 2), (z - 0.04, z), k.color, Material.FABRIC)
    k.cyl((x * 0.1, x / 2), (-y * 0.46, y * 0.46), (z - 0.04, z), k.color, Material.FABRIC)
    for s in (-1, 1):
        k.rod((-x * 0.34, s * y * 0.3, 0.03), (x * 0.3, s * y * 0.12, z - 0.05), 0.025, SILVER, METAL)
        k.rod((x * 0.34, s * y * 0.3, 0.03), (-x * 0.3, s * y * 0.12, z - 0.05), 0.025, SILVER, METAL)
    for fx in (-0.36, 0.36):
        k.box((fx * x - 0.015, fx * x + 0.015), (-y * 0.36, y * 0.36), (0, 0.03), DARK)
    k.surface((-x / 2 + 0.02, x * 0.3), (-y / 2 + 0.02, y / 2 - 0.02), z)
    k.below((x * 0.4, x * 0.49), (-y * 0.3, y * 0.3), z * 0.8)
    k.below((-x * 0.48, -x * 0.4), (-y * 0.3, y * 0.3), z * 0.8)


@shape("lawn_mower")
def lawn_mower(k: Kit) -> None:
    """A red deck on wheels, engine, grass box and a push bar."""
    x, y, z = k.size
    k.box((-x * 0.02, x * 0.46), (-y * 0.42, y * 0.42), (0.1, 0.28), RED)
    k.box((x * 0.1, x * 0.34), (-y * 0.26, y * 0.26), (0.28, 0.42), DARK)
    k.box((-x * 0.26, -x * 0.02), (-y * 0.36, y * 0.36), (0.12, 0.4), (50, 54, 52), Material.FABRIC)
    for fx in (0.03, 0.41):
        for s in (-1, 1):
            c, d = sorted((s * y / 2, s * y * 0.4))
            k.cyl((fx * x - 0.09, fx * x + 0.09), (c, d), (0, 0.18), BLACK, axis="y")
    for s in (-1, 1):
        k.rod((-x * 0.0, s * y * 0.36, 0.24), (-x * 0.48, s * y * 0.36, z - 0.02), 0.025, GREY, METAL)
    k.box((-x / 2, -x / 2 + 0.03), (-y * 0.4, y * 0.4), (z - 0.04, z), BLACK)
    k.box((x * 0.46, x / 2), (-y * 0.3, y * 0.3), (0.12, 0.24), shade(RED, 0.8))
    k.surface((x * 0.12, x * 0.32), (-y * 0.22, y * 0.22), 0.42)


@shape("watering_can")
def watering_can(k: Kit) -> None:
    """Body, spout with a rose, handle; along y."""
    k.unit()
    k.cyl((-0.5, 0.5), (-0.34, 0.1), (0, 0.7))
    k.cyl((-0.4, 0.4), (-0.28, 0.04), (0.7, 0.72), DARK)
    k.rod((0, 0.08, 0.15), (0, 0.44, 0.8), 0.03)
    k.rod((0, 0.41, 0.76), (0, 0.48, 0.88), 0.06, shade(k.color, 0.8))
    k.path([(0, -0.3, 0.2), (0, -0.48, 0.4), (0, -0.44, 0.75), (0, -0.3, 0.7)], 0.018, shade(k.color, 0.8))
    k.path([(0, -0.3, 0.7), (0, -0.15, 0.98), (0, 0.06, 0.7)], 0.018, shade(k.color, 0.8))


@shape("hose_coil")
def hose(k: Kit) -> None:
    """Coils lying on each other with a brass end."""
    k.unit()
    torus(k, 0.4, 0.2, (0, 0.6), k.color)
    torus(k, 0.36, 0.2, (0.4, 1.0), shade(k.color, 1.15), count=6)
    k.rod((0.2, 0.36, 0.5), (0.4, 0.5, 0.6), 0.025, (208, 168, 62), METAL)


@shape("hair_dryer")
def hair_dryer(k: Kit) -> None:
    """Barrel with nozzle and a handle below."""
    k.unit()
    k.cyl((-0.5, 0.26), (-0.5, 0.5), (0.55, 1.0), (60, 60, 66), axis="x")
    k.cyl((0.24, 0.5), (-0.36, 0.36), (0.62, 0.92), SILVER, METAL, axis="x", taper=0.7)
    k.rod((-0.14, 0, 0.6), (-0.04, 0, 0.0), 0.04, RED)
    k.cyl((-0.51, -0.48), (-0.4, 0.4), (0.6, 0.94), GREY, axis="x")


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


@shape("firework")
def firework(k: Kit) -> None:
    """A rocket with a stick, or a sparkler."""
    k.unit()
    if k.name == "sparkler":
        k.box((-0.5, 0.0), (-0.3, 0.3), (0.2, 0.8), SILVER, METAL)
        k.box((0.0, 0.5), (-0.5, 0.5), (0, 1), (120, 120, 126))
        return
    k.box((-0.5, 0.3), (0.2, 0.4), (0.1, 0.3), TAN)
    k.cyl((-0.2, 0.3), (-0.5, 0.5), (0, 1), RED, axis="x")
    k.cyl((0.3, 0.5), (-0.5, 0.5), (0, 1), YELLOW, axis="x", taper=0.0)
    k.cyl((0.0, 0.1), (-0.505, 0.505), (-0.005, 1.005), BLUE, axis="x")


@shape("barrel")
def keg(k: Kit) -> None:
    """A steel keg with two rings."""
    k.unit()
    k.cyl((-0.48, 0.48), (-0.48, 0.48), (0, 0.96), SILVER, METAL)
    for z0 in (0.22, 0.66):
        k.cyl((-0.5, 0.5), (-0.5, 0.5), (z0, z0 + 0.08), GREY, METAL)
    k.cyl((-0.42, 0.42), (-0.42, 0.42), (0.96, 1.0), GREY, METAL)
    k.cyl((-0.08, 0.08), (-0.08, 0.08), (0.95, 1.004), BLACK)


@shape("soap_bar")
def soap(k: Kit) -> None:
    """A rounded bar with a stamped oval."""
    k.unit()
    k.box((-0.4, 0.4), (-0.44, 0.44), (0, 0.9))
    k.ball((-0.5, 0.5), (-0.5, 0.5), (0, 0.95))
    k.cyl((-0.26, 0.26), (-0.26, 0.26), (0.9, 1.0), shade(k.color, 0.85))
