"""Cups, glasses, flasks and jugs: vessels for drinking and pouring."""

from __future__ import annotations

from ucon.objects.kit import Kit, shape
from ucon.objects.model import Material
from ucon.objects.palette import BLACK, BROWN, SILVER, shade
from ucon.objects.shapes.generic import ring
from ucon.objects.shapes.hollow import hollow, round_space


@shape("cup_mug")
def cup(k: Kit) -> None:
    """A hollow cup; mugs and teacups have a handle at the side."""
    x, y, z = k.size
    handled = k.name in ("mug", "teacup", "coffee_cup")
    if k.name == "chalice":
        _stem_glass(k, 0.45)
        return
    along_y = y > x
    ear = 0.24 * max(x, y) if handled else 0.0
    rx, ry = (x / 2, (y - ear) / 2) if along_y else ((x - ear) / 2, y / 2)
    cx, cy = (0.0, -ear / 2) if along_y else (-ear / 2, 0.0)
    wall, floor = 0.004, 0.008
    ring(k, rx, ry, (floor, z), wall, sides=8, cx=cx, cy=cy)
    k.cyl((cx - rx * 0.9, cx + rx * 0.9), (cy - ry * 0.9, cy + ry * 0.9), (0, floor + 0.001), shade(k.color, 0.9))
    content = {"mug": (70, 44, 28), "coffee_cup": (60, 36, 22), "teacup": (150, 84, 40)}.get(k.name)
    k.cyl((cx - rx + wall, cx + rx - wall), (cy - ry + wall, cy + ry - wall), (floor, floor + 0.003),
          content or shade(k.color, 0.7))  # fmt: skip
    if handled:
        t = 0.009
        for z0, z1 in ((0.68 * z, 0.8 * z), (0.25 * z, 0.37 * z)):
            _ear(k, along_y, cx, cy, rx, ry, (0.0, ear), (z0, z1), t)
        _ear(k, along_y, cx, cy, rx, ry, (ear - t, ear), (0.37 * z, 0.68 * z), t)
    round_space(k, (rx - wall) * 0.97, (ry - wall) * 0.97, floor + 0.003, z, cx, cy)


def _ear(
    k: Kit, along_y: bool, cx: float, cy: float, rx: float, ry: float, out: tuple[float, float],
    z: tuple[float, float], thick: float,
) -> None:  # fmt: skip
    half = (-thick / 2, thick / 2)
    if along_y:
        k.box(half, (cy + ry - 0.003 + out[0], cy + ry + out[1]), z, shade(k.color, 0.92))
    else:
        k.box((cx + rx - 0.003 + out[0], cx + rx + out[1]), half, z, shade(k.color, 0.92))


def _stem_glass(k: Kit, waist: float) -> None:
    x, y, z = k.size
    low = waist * z
    ring(k, x / 2, y / 2, (low, z), 0.004)
    k.cyl((-x * 0.44, x * 0.44), (-y * 0.44, y * 0.44), (low - 0.01, low + 0.004), shade(k.color, 0.92))
    k.cyl((-0.006, 0.006), (-0.006, 0.006), (0.006, low - 0.01), shade(k.color, 0.9))
    k.cyl((-x * 0.38, x * 0.38), (-y * 0.38, y * 0.38), (0, 0.006))
    round_space(k, (x / 2 - 0.006), (y / 2 - 0.006), low + 0.004, z)


@shape("glass_stem")
def wineglass(k: Kit) -> None:
    """Bowl, stem and foot."""
    _stem_glass(k, 0.5 if k.name == "wineglass" else 0.6)


@shape("glass_tumbler")
def tumbler(k: Kit) -> None:
    """A clear straight glass."""
    x, y, z = k.size
    beer = k.name == "beer_glass"
    hollow(k, x / 2, y / 2, 0.0, z, 0.004, foot=0.95, floor=0.45 * z if beer else 0.012)
    if beer:
        part = k.parts[-2]
        k.parts.remove(part)
        k.cyl((-x * 0.46, x * 0.46), (-y * 0.46, y * 0.46), (0, 0.44 * z), (216, 160, 50), Material.GLASS)


@shape("flask")
def flask(k: Kit) -> None:
    """Round-bellied bottles with a neck."""
    k.unit()
    if k.name == "canteen":
        k.cyl((-0.5, 0.5), (-0.5, 0.5), (0, 0.8), k.color, Material.FABRIC, axis="x")
        k.cyl((-0.2, 0.2), (-0.14, 0.14), (0.76, 0.88), SILVER, Material.METAL)
        k.cyl((-0.26, 0.26), (-0.18, 0.18), (0.86, 1.0), BLACK)
        k.box((-0.52, 0.52), (-0.06, 0.06), (0.0, 0.8), BROWN)
        return
    glass = (190, 216, 222)
    wine = (120, 30, 44) if k.name == "decanter" else (176, 210, 224)
    k.cyl((-0.5, 0.5), (-0.5, 0.5), (0, 0.34), wine, Material.GLASS, taper=0.9)
    k.cyl((-0.45, 0.45), (-0.45, 0.45), (0.34, 0.55), glass, Material.GLASS, taper=0.4)
    k.cyl((-0.18, 0.18), (-0.18, 0.18), (0.55, 0.86), glass, Material.GLASS)
    k.cyl((-0.24, 0.24), (-0.24, 0.24), (0.86, 0.92 if k.name == "decanter" else 1.0), glass, Material.GLASS)
    if k.name == "decanter":
        k.ball((-0.14, 0.14), (-0.14, 0.14), (0.88, 1.0), (214, 232, 238), Material.GLASS)


@shape("jug")
def jug(k: Kit) -> None:
    """A tall open jug with spout and handle."""
    x, y, z = k.size
    ear = 0.22 * x
    rx, ry = (x - ear) / 2, y / 2
    cx = ear / 2 - 0.012
    ring(k, rx - 0.012, ry, (0.02, z), 0.006, cx=cx)
    k.cyl((cx - rx + 0.012, cx + rx - 0.012), (-ry, ry), (0, 0.02), shade(k.color, 0.92))
    k.cyl((cx - rx + 0.02, cx + rx - 0.02), (-ry + 0.01, ry - 0.01), (0.018, 0.024), (170, 206, 222))
    k.box((x / 2 - 0.03, x / 2), (-0.02, 0.02), (z - 0.04, z - 0.004), k.color)
    k.box((-x / 2, cx - rx + 0.016), (-0.012, 0.012), (0.74 * z, 0.82 * z), shade(k.color, 0.88))
    k.box((-x / 2, cx - rx + 0.016), (-0.012, 0.012), (0.22 * z, 0.3 * z), shade(k.color, 0.88))
    k.box((-x / 2, -x / 2 + 0.022), (-0.012, 0.012), (0.3 * z, 0.74 * z), shade(k.color, 0.88))
    round_space(k, rx - 0.024, ry - 0.012, 0.024, z, cx=cx)
