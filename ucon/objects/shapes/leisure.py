"""Music and sports."""

from __future__ import annotations

from ucon.objects.kit import Kit, shape
from ucon.objects.model import Material
from ucon.objects.palette import BLACK, BROWN, DARK, DARKBROWN, GREY, RED, SILVER, TAN, WHITE, shade

METAL = Material.METAL


@shape("guitar")
def guitar(k: Kit) -> None:
    """Lying: two round bouts, sound hole, dark neck, head."""
    k.unit()
    wood = (186, 116, 56)
    k.cyl((-0.5, -0.16), (-0.5, 0.5), (0, 0.85), wood, Material.WOOD)
    k.cyl((-0.24, 0.06), (-0.38, 0.38), (0, 0.85), shade(wood, 1.08), Material.WOOD)
    k.box((-0.32, -0.1), (-0.28, 0.28), (0, 0.84), wood, Material.WOOD)
    k.cyl((-0.2, -0.08), (-0.16, 0.16), (0.85, 0.88), BLACK)
    k.box((-0.4, -0.36), (-0.22, 0.22), (0.85, 0.95), DARKBROWN)
    k.box((-0.1, 0.4), (-0.07, 0.07), (0.5, 0.98), DARKBROWN)
    k.box((0.38, 0.5), (-0.12, 0.12), (0.5, 0.95), (60, 40, 28))
    for s in (-1, 1):
        k.box((-0.38, 0.4), (s * 0.04 - 0.01, s * 0.04 + 0.01), (0.97, 1.0), SILVER)
    if k.name == "violin":
        k.rod((-0.45, 0.34, 0.3), (0.4, 0.44, 0.3), 0.01, BROWN)


@shape("horn")
def horn(k: Kit) -> None:
    """Brass along its longest side: bell, tube, valves or slide, mouthpiece."""
    k.unit()
    along_x = k.size[0] >= k.size[1]
    brass = (216, 172, 60)

    def at(u: float, v: float, w: float) -> tuple[float, float, float]:
        return (u, v, w) if along_x else (v, u, w)

    t = 0.12 * min(k.size)
    if along_x:
        k.cyl((0.2, 0.5), (-0.22, 0.22), (0.2, 0.8), brass, METAL, axis="x", taper=2.2)
    else:
        k.cyl((-0.22, 0.22), (0.2, 0.5), (0.2, 0.8), brass, METAL, axis="y", taper=2.2)
    k.rod(at(-0.46, 0.0, 0.5), at(0.25, 0.0, 0.5), 2 * t, brass, METAL)
    k.rod(at(-0.2, -0.36, 0.45), at(0.16, -0.36, 0.45), 1.6 * t, brass, METAL)
    k.rod(at(-0.2, -0.36, 0.45), at(-0.2, 0.0, 0.5), 1.6 * t, brass, METAL)
    k.rod(at(0.16, -0.36, 0.45), at(0.16, 0.0, 0.5), 1.6 * t, brass, METAL)
    for i in range(3):
        p = at(-0.12 + 0.09 * i, -0.18, 0.45)
        k.rod((p[0], p[1], 0.2), (p[0], p[1], 0.9), 1.8 * t, SILVER, METAL)
    k.rod(at(-0.5, 0.0, 0.5), at(-0.44, 0.0, 0.5), 2.6 * t, SILVER, METAL)


@shape("cymbal")
def cymbal(k: Kit) -> None:
    """A brass disc on a stand with three feet."""
    k.unit()
    k.cyl((-0.5, 0.5), (-0.5, 0.5), (0.92, 0.97), (220, 180, 70), METAL, taper=0.5)
    k.cyl((-0.06, 0.06), (-0.06, 0.06), (0.95, 1.0), BLACK)
    k.cyl((-0.03, 0.03), (-0.03, 0.03), (0.1, 0.95), SILVER, METAL)
    for dx, dy in ((0.44, 0.0), (-0.3, 0.4), (-0.3, -0.4)):
        k.rod((0, 0, 0.25), (dx, dy, 0.01), 0.02, SILVER, METAL)


@shape("piano")
def piano(k: Kit) -> None:
    """An upright: body at the back, keyboard shelf in front with white and black keys, legs, pedals."""
    x, y, z = k.size
    keys = 0.62 * z
    black = (34, 30, 30)
    k.box((-x / 2, -x * 0.08), (-y / 2, y / 2), (0.0, z - 0.03), black)
    k.box((-x / 2, 0.0), (-y / 2, y / 2), (z - 0.03, z), shade(black, 1.15))
    k.box((-x * 0.08, x / 2), (-y / 2, y / 2), (keys - 0.08, keys), black)
    for s in (-1, 1):
        c, d = sorted((s * y / 2, s * (y / 2 - 0.07)))
        k.box((-x * 0.08, x / 2), (c, d), (keys, keys + 0.1), black)
        k.box((x / 2 - 0.1, x / 2 - 0.03), (c, d), (0, keys - 0.08), black)
    k.box((x * 0.1, x / 2 - 0.03), (-y / 2 + 0.07, y / 2 - 0.07), (keys, keys + 0.02), (248, 246, 240))
    for i in range(5):
        y0 = -y / 2 + 0.12 + i * (y - 0.24) / 5
        k.box((x * 0.1, x * 0.3), (y0, y0 + 0.5 * (y - 0.24) / 5), (keys + 0.02, keys + 0.032), BLACK)
    k.box((-x * 0.08, -x * 0.04), (-0.3, 0.3), (z * 0.74, z * 0.92), (70, 50, 40), Material.WOOD)
    k.surface((-x / 2 + 0.01, -0.01), (-y / 2 + 0.02, y / 2 - 0.02), z)
    k.below((-x * 0.06, x / 2 - 0.02), (-y / 2 + 0.09, y / 2 - 0.09), keys - 0.09)


@shape("ball")
def ball(k: Kit) -> None:
    """Seams, patches or finger holes."""
    k.unit()
    k.ball((-0.5, 0.5), (-0.5, 0.5), (0, 1))
    if k.name == "soccer_ball":
        for x0, y0, z0 in (
            (0.5, 0, 0.5),
            (-0.5, 0, 0.5),
            (0, 0.5, 0.5),
            (0, -0.5, 0.5),
            (0, 0, 1.0),
            (0.34, 0.34, 0.86),
        ):
            u, v, w = x0 * 0.82, y0 * 0.82, 0.5 + (z0 - 0.5) * 0.82
            k.ball((u - 0.14, u + 0.14), (v - 0.14, v + 0.14), (w - 0.14, w + 0.14), BLACK)
    elif k.name in ("baseball", "tennis_ball"):
        color = RED if k.name == "baseball" else WHITE
        for x0 in (-0.26, 0.2):
            k.cyl((x0, x0 + 0.06), (-0.445, 0.445), (0.055, 0.945), color, axis="x")
    else:
        for y0, z0 in ((-0.12, 0.9), (0.06, 0.9), (-0.03, 0.76)):
            k.ball((0.0 + (0.95 - z0), 0.12 + (0.95 - z0)), (y0, y0 + 0.1), (z0 - 0.02, z0 + 0.09), GREY)


@shape("stick_long")
def stick(k: Kit) -> None:
    """Bats, clubs, rackets, skis, rods: long things lying down."""
    k.unit()
    name = k.name
    if name == "baseball_bat":
        k.cyl((-0.5, -0.46), (-0.4, 0.4), (0.1, 0.9), DARKBROWN, axis="x")
        k.cyl((-0.46, -0.1), (-0.26, 0.26), (0.24, 0.76), BLACK, axis="x")
        k.cyl((-0.12, 0.5), (-0.3, 0.3), (0.2, 0.8), None, None, axis="x", taper=1.65)
    elif name == "golf_club":
        k.box((-0.5, -0.28), (-0.3, -0.1), (0.1, 0.9), BLACK)
        k.box((-0.28, 0.44), (-0.26, -0.14), (0.3, 0.7), SILVER, METAL)
        k.box((0.4, 0.5), (-0.3, 0.5), (0, 1), GREY, METAL)
    elif name == "hockey_stick":
        k.box((-0.4, -0.1), (-0.5, 0.36), (0.2, 0.8), BLACK)
        k.rod((-0.25, 0.34, 0.5), (0.45, 0.48, 0.5), 0.05, (210, 180, 120), Material.WOOD)
        k.box((-0.42, -0.08), (-0.5, -0.34), (0.1, 0.9), WHITE)
    elif name == "tennis_racket":
        rim = ((0.0, -0.3), (0.0, 0.3), (0.14, 0.5), (0.36, 0.5), (0.5, 0.3), (0.5, -0.3), (0.36, -0.5), (0.14, -0.5))
        for (ax, ay), (bx, by) in zip(rim, (*rim[1:], rim[0]), strict=True):
            k.rod((ax, ay * 0.96, 0.5), (bx, by * 0.96, 0.5), 0.02, RED)
        k.box((0.02, 0.48), (-0.4, 0.4), (0.42, 0.58), (226, 230, 226))
        k.rod((-0.2, 0, 0.5), (0.02, 0.1, 0.5), 0.015, RED)
        k.rod((-0.2, 0, 0.5), (0.02, -0.1, 0.5), 0.015, RED)
        k.box((-0.5, -0.18), (-0.06, 0.06), (0, 1), BLACK)
    elif name == "ski":
        for s in (-1, 1):
            c, d = sorted((s * 0.5, s * 0.1))
            k.box((c, d), (-0.5, 0.42), (0, 0.4), k.color)
            k.rod((s * 0.3, 0.41, 0.2), (s * 0.3, 0.5, 0.9), (0.012, 0.035), k.color)
            k.box((c, d), (-0.1, 0.1), (0.4, 1.0), BLACK)
    else:
        k.rod((0, -0.5, 0.3), (0, 0.5, 0.3), 0.014, DARK)
        k.box((-0.3, 0.3), (-0.5, -0.32), (0.1, 0.6), TAN)
        k.cyl((-0.5, 0.5), (-0.32, -0.26), (0, 1.0), SILVER, METAL, axis="y")
        for y0 in (-0.1, 0.12, 0.34):
            k.box((-0.25, 0.25), (y0, y0 + 0.012), (0.15, 0.6), RED)


@shape("board_wheels")
def longboard(k: Kit) -> None:
    """A deck along y on four wheels."""
    k.unit()
    k.box((-0.42, 0.42), (-0.4, 0.4), (0.55, 0.8), (150, 100, 60), Material.WOOD)
    for s in (-1, 1):
        c, d = sorted((s * 0.3, s * 0.5))
        k.cyl((-0.42, 0.42), (c, d), (0.55, 0.8), (150, 100, 60), Material.WOOD)
        for t in (-1, 1):
            a, b = sorted((t * 0.5, t * 0.26))
            k.cyl((a, b), (s * 0.3 - 0.05, s * 0.3 + 0.05), (0, 0.5), (220, 90, 50), axis="x")
        k.box((-0.4, 0.4), (s * 0.3 - 0.02, s * 0.3 + 0.02), (0.2, 0.55), GREY, METAL)
    k.box((-0.34, 0.34), (-0.4, 0.4), (0.8, 1.0), DARK)


@shape("punching_bag")
def punching_bag(k: Kit) -> None:
    """A red bag on a round foot."""
    k.unit()
    k.cyl((-0.5, 0.5), (-0.5, 0.5), (0, 0.14), BLACK)
    k.cyl((-0.1, 0.1), (-0.1, 0.1), (0.14, 0.36), SILVER, METAL)
    k.cyl((-0.4, 0.4), (-0.4, 0.4), (0.34, 1.0), RED)
    for z0 in (0.46, 0.84):
        k.cyl((-0.41, 0.41), (-0.41, 0.41), (z0, z0 + 0.03), BLACK)


@shape("treadmill")
def treadmill(k: Kit) -> None:
    """A belt in a frame, two posts, a console; the runner steps on from +x."""
    x, y, z = k.size
    deck = 0.14
    k.box((-x / 2, x / 2), (-y * 0.32, y * 0.32), (0.03, deck), (40, 40, 42))
    for s in (-1, 1):
        c, d = sorted((s * y / 2, s * y * 0.32))
        k.box((-x / 2, x / 2), (c, d), (0, deck + 0.02), GREY)
        k.rod((-x * 0.36, s * (y / 2 - 0.05), deck), (-x * 0.42, s * (y / 2 - 0.05), z - 0.12), 0.06, DARK)
        k.box((-x * 0.42, -x * 0.1), (s * (y / 2 - 0.05) - 0.02, s * (y / 2 - 0.05) + 0.02), (z * 0.76, z * 0.8), BLACK)
    k.box((-x / 2, -x * 0.38), (-y / 2, y / 2), (z - 0.16, z), DARK)
    k.box((-x * 0.38, -x * 0.375), (-y * 0.3, y * 0.3), (z - 0.13, z - 0.03), (90, 170, 210), Material.GLASS)
    k.box((-x / 2, -x * 0.3), (-y * 0.32, y * 0.32), (deck, deck + 0.09), DARK)
    k.surface((-x * 0.28, x / 2 - 0.05), (-y * 0.3, y * 0.3), deck)
