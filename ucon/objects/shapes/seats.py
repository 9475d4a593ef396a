"""Sofas, chairs, stools and benches."""

from __future__ import annotations

from ucon.objects.kit import Kit, shape
from ucon.objects.model import Material
from ucon.objects.palette import BLACK, DARK, GREY, RED, SILVER, WHITE, shade
from ucon.objects.shapes.tables import legs, under_all

CUSHION = Material.FABRIC


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
    """A slatted garden seat with arms, spanning its full width."""
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
