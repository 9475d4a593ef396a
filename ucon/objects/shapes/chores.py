"""Things for cleaning, ironing and the garden, and a few that fit nowhere else."""

from __future__ import annotations

from ucon.objects.kit import Kit, shape
from ucon.objects.model import Material
from ucon.objects.palette import BLACK, BLUE, DARK, GREY, RED, SILVER, TAN, WHITE, YELLOW, shade
from ucon.objects.shapes.generic import torus

METAL = Material.METAL
GRAIN = Material.WOOD
HANDLE = (150, 104, 62)


@shape("broom_stick")
def broom(k: Kit) -> None:
    """Standing, with bristles or strands below and a long stick above; a squeegee lies flat."""
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
