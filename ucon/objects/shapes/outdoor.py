"""Vehicles, playgrounds, fences, trees, stairs and the fireplace."""

from __future__ import annotations

from ucon.objects.kit import Kit, shape
from ucon.objects.model import Material
from ucon.objects.palette import (
    BLACK,
    BLUE,
    BROWN,
    CREAM,
    DARK,
    GREY,
    ORANGE,
    RED,
    SILVER,
    TAN,
    WHITE,
    WOOD,
    YELLOW,
    shade,
)
from ucon.objects.shapes.casework import tub


@shape("fireplace")
def fireplace(k: Kit) -> None:
    """Brick pillars, a mantel, a dark hearth with logs and flames."""
    x, y, z = k.size
    mantel = z - 0.1
    for s in (-1, 1):
        c, d = sorted((s * y * 0.48, s * y * 0.26))
        k.box((-x / 2, x / 2 - 0.08), (c, d), (0, mantel), k.color, Material.TILE)
    k.box((-x / 2, x / 2 - 0.08), (-y * 0.26, y * 0.26), (0.72 * z, mantel), k.color, Material.TILE)
    k.box((-x / 2, -x / 2 + 0.06), (-y * 0.26, y * 0.26), (0, 0.72 * z), (44, 38, 36))
    k.box((-x / 2 + 0.06, x / 2), (-y * 0.26, y * 0.26), (0, 0.05), (80, 76, 74), Material.CONCRETE)
    k.box((-x / 2, x / 2), (-y / 2, y / 2), (mantel, z), (236, 230, 220))
    for i in range(3):
        y0 = (-0.14 + 0.09 * i) * y
        k.cyl((-0.1, 0.1), (y0, y0 + 0.1), (0.05, 0.15), BROWN, Material.WOOD, axis="x")
        k.cyl((-0.08, 0.08), (y0, y0 + 0.14), (0.15, 0.34 + 0.08 * (i == 1)), ORANGE, taper=0.1)
    k.surface((-x / 2 + 0.05, x / 2 - 0.02), (-y / 2 + 0.05, y / 2 - 0.05), z)


@shape("fence")
def fence(k: Kit) -> None:
    """Posts and two rails."""
    x, y, z = k.size
    if k.name == "turnstile":
        for s in (-1, 1):
            c, d = sorted((s * y / 2, s * y * 0.34))
            k.box((-x / 2, x / 2), (c, d), (0, z), SILVER, Material.METAL)
        for i in range(3):
            k.box(
                (-0.03, 0.03),
                (-y * 0.34, -y * 0.02),
                (z * (0.5 + 0.15 * i), z * (0.54 + 0.15 * i)),
                GREY,
                Material.METAL,
            )
        return
    count = max(2, round(y / 0.8) + 1)
    for i in range(count):
        y0 = -y / 2 + i * (y - 0.1) / (count - 1)
        k.box((-x / 2, x / 2), (y0, y0 + 0.1), (0, z))
    for low in (0.35, 0.75):
        k.box((-x * 0.25, x * 0.25), (-y / 2, y / 2), (low * z, low * z + 0.1), shade(k.color, 0.9))
    k.surface((-x / 2, x / 2), (-y / 2, -y / 2 + 0.1), z)


@shape("fire_extinguisher")
def fire_extinguisher(k: Kit) -> None:
    """A red cylinder with a black head and hose."""
    k.unit()
    k.cyl((-0.4, 0.4), (-0.5, 0.3), (0, 0.72), RED)
    k.ball((-0.4, 0.4), (-0.5, 0.3), (0.62, 0.84), RED)
    k.cyl((-0.12, 0.12), (-0.2, 0.0), (0.82, 0.9), BLACK)
    k.box((-0.3, 0.5), (-0.2, 0.0), (0.9, 1.0), BLACK)
    k.path([(0.2, -0.1, 0.9), (0.2, 0.42, 0.8), (0.1, 0.44, 0.3)], 0.018, BLACK)
    k.box((0.36, 0.42), (-0.35, 0.15), (0.3, 0.55), WHITE)


@shape("vehicle")
def vehicle(k: Kit) -> None:
    """Body, cabin with open windows, four wheels, lamps. Along y; the seats can be looked into."""
    x, y, z = k.size
    rv, truck = k.name == "recreational_vehicle", k.name == "pickup_truck"
    wheel = min(0.36, 0.24 * z + 0.02)
    floor = wheel * 0.7
    belt = (0.62 if rv else 0.5 if truck else 0.55) * z
    k.box((-x / 2 + 0.02, x / 2 - 0.02), (-y / 2, y / 2), (floor, belt - 0.14))
    for s in (-1, 1):
        c, d = sorted((s * (x / 2 - 0.02), s * (x / 2 - 0.12)))
        k.box((c, d), (-y / 2, y / 2), (belt - 0.14, belt))
    cabin = (-y * 0.5, y * 0.3) if rv else (-y * 0.12, y * 0.22) if truck else (-y * 0.36, y * 0.2)
    k.box((-x / 2 + 0.12, x / 2 - 0.12), (cabin[1], y / 2), (belt - 0.14, belt))
    if not rv:
        k.box((-x / 2 + 0.12, x / 2 - 0.12), (-y / 2, -y / 2 + 0.1 if truck else cabin[0]), (belt - 0.14, belt))
    for fy in cabin:
        y0 = fy if fy < 0 else fy - 0.1
        for s in (-1, 1):
            c, d = sorted((s * (x / 2 - 0.06), s * (x / 2 - 0.14)))
            k.box((c, d), (y0, y0 + 0.1), (belt, z - 0.08))
    k.box((-x / 2 + 0.06, x / 2 - 0.06), cabin, (z - 0.08, z), shade(k.color, 0.95))
    for s in (-1, 1):
        for fy in (-0.32, 0.3):
            c, d = sorted((s * x / 2, s * (x / 2 - 0.2)))
            k.cyl((c, d), (fy * y - wheel, fy * y + wheel), (0, 2 * wheel * 0.98), BLACK, axis="x")
    k.box((-x * 0.4, x * 0.4), (y / 2 - 0.01, y / 2 + 0.0), (belt - 0.3, belt - 0.2), CREAM)
    inner = (cabin[0] + 0.1, cabin[1] - 0.1)
    k.space((-x / 2 + 0.14, x / 2 - 0.14), inner, (belt - 0.14, z - 0.1))


@shape("boat")
def boat(k: Kit) -> None:
    """A hull pointed at both ends with a dark hollow; a paddle lies on the kayak."""
    k.unit()
    deck = 0.8
    k.ball((-0.5, 0.5), (-0.5, 0.5), (0, deck * 1.1))
    k.box((-0.3, 0.3), (-0.44, 0.44), (0.2, deck), shade(k.color, 0.9))
    kayak = k.name == "kayak"
    k.cyl((-0.12, 0.12) if kayak else (-0.34, 0.3), (-0.34, 0.34), (deck, deck + 0.1), (40, 34, 30))
    k.box((-0.03, 0.03), (-0.44, 0.44), (deck, deck + 0.12), shade(k.color, 0.7))
    k.rod((-0.3, 0.4, 0.95), (0.36, 0.42, 0.95), 0.03, TAN)
    k.box((0.3, 0.4), (0.34, 0.5), (0.9, 1.0), TAN)


@shape("bicycle")
def bicycle(k: Kit) -> None:
    """Two wheels, a frame, saddle and handlebar; along y, front at +y."""
    x, y, z = k.size
    r = 0.32 * z
    for s in (-1, 1):
        cy = s * (y / 2 - r)
        k.cyl((-0.02, 0.02), (cy - r, cy + r), (0, 2 * r), BLACK, axis="x")
        k.cyl((-0.024, 0.024), (cy - r * 0.82, cy + r * 0.82), (0.18 * r, 1.82 * r), (206, 208, 212), axis="x")
    rear, front = -(y / 2 - r), y / 2 - r
    pedal, saddle, head = (0.0, -0.06, r * 0.9), (0.0, rear * 0.4, z * 0.84), (0.0, front * 0.7, z * 0.82)
    for a, b in ((pedal, saddle), (saddle, head), (pedal, head), (pedal, (0, rear, r)), (saddle, (0, rear, r)),
                 (head, (0, front, r))):  # fmt: skip
        k.rod(a, b, 0.035)
    k.box((-0.06, 0.06), (saddle[1] - 0.14, saddle[1] + 0.1), (z * 0.84, z * 0.9), BLACK)
    k.rod(head, (0, front * 0.62, z * 0.98), 0.03, SILVER)
    k.box((-x / 2, x / 2), (front * 0.6, front * 0.6 + 0.03), (z - 0.03, z), BLACK)
    k.box((-0.12, 0.12), (-0.09, -0.03), (r * 0.85, r * 0.95), DARK)


@shape("playground", "sandbox", "swing")
def playground(k: Kit) -> None:
    """A tower with slide, a sandpit, or a swing."""
    x, y, z = k.size
    if k.name == "sandbox":
        ix, iy = tub(k, (-x / 2, x / 2), (-y / 2, y / 2), (0, z), 0.12, 0.6 * z, WOOD, (222, 196, 140))
        k.space(ix, iy, (0.6 * z, 1.5 * z))
        k.surface(ix, iy, 0.6 * z)
        return
    for sx in (-1, 1):
        a, b = sorted((sx * x / 2, sx * (x / 2 - 0.08)))
        for sy in (-1, 1):
            c, d = sorted((sy * y / 2, sy * (y / 2 - 0.08))) if k.name == "swing" else sorted((0.0, sy * 0.08))
            if k.name == "playground":
                c, d = (-y * 0.5, -y * 0.5 + 0.1) if sy < 0 else (0.0, 0.1)
            k.box((a, b), (c, d), (0, z), shade(k.color, 0.8) if k.name == "swing" else RED)
    if k.name == "swing":
        k.box((-x / 2, x / 2), (-y / 2, y / 2), (z - 0.08, z))
        for s in (-1, 1):
            k.box((-0.012, 0.012), (s * 0.2 - 0.012, s * 0.2 + 0.012), (0.5, z - 0.08), GREY)
        k.box((-0.1, 0.1), (-0.24, 0.24), (0.46, 0.5), YELLOW)
        return
    k.box((-x / 2, x / 2), (-y / 2, 0.1), (0.44 * z, 0.48 * z), WOOD, Material.WOOD)
    k.box((-x / 2, x / 2), (-y / 2, 0.1), (0.86 * z, 0.92 * z), BLUE)
    k.rod((0.0, 0.1, 0.46 * z), (0.0, y / 2 - 0.12, 0.08), (0.06, 0.6), YELLOW)
    k.box((-0.3, 0.3), (y / 2 - 0.3, y / 2), (0, 0.06), YELLOW)
    k.surface((-x / 2 + 0.1, x / 2 - 0.1), (-y / 2 + 0.1, -0.1), 0.48 * z, 0.8)


@shape("stairs")
def stairs(k: Kit) -> None:
    """Steps rising towards +y; a railing lies flat: two rails with posts between them."""
    x, y, z = k.size
    if k.name == "railing":
        k.box((-x / 2, x / 2), (-y / 2, -y / 2 + 0.05), (0, z))
        k.box((-x / 2, x / 2), (y / 2 - 0.05, y / 2), (0, z))
        for i in range(6):
            x0 = -x / 2 + i * (x - 0.04) / 5
            k.box((x0, x0 + 0.04), (-y / 2 + 0.05, y / 2 - 0.05), (0.2 * z, 0.8 * z), WHITE)
        k.surface((-x / 2, x / 2), (-y / 2, -y / 2 + 0.05), z)
        return
    count = max(3, min(10, round(z / 0.18)))
    for i in range(count):
        y0 = -y / 2 + i * y / count
        k.box((-x / 2, x / 2), (y0, y0 + y / count), (0, (i + 1) * z / count), shade(k.color, 0.9 + 0.1 * (i % 2)))
    k.surface((-x / 2 + 0.02, x / 2 - 0.02), (-y / 2 + 0.02, -y / 2 + y / count - 0.005), z / count)


@shape("tent")
def tent(k: Kit) -> None:
    """Two sloping sides, closed at the back, open in front."""
    x, y, z = k.size
    for s in (-1, 1):
        k.rod((0, s * (y / 2 - 0.03), 0.02), (0, 0.0, z - 0.02), (0.025, x), k.color, Material.FABRIC)
    k.box((-x / 2, x / 2), (-y / 2, y / 2), (0, 0.01), shade(k.color, 0.6), Material.FABRIC)
    k.box((-x / 2, -x / 2 + 0.02), (-y * 0.3, y * 0.3), (0.01, z * 0.4), shade(k.color, 0.85), Material.FABRIC)
    k.box((-x / 2, -x / 2 + 0.02), (-y * 0.15, y * 0.15), (z * 0.4, z * 0.7), shade(k.color, 0.85), Material.FABRIC)
    k.box((x / 2 - 0.03, x / 2), (-0.02, 0.02), (z * 0.9, z), DARK)
    k.space((-x / 2 + 0.05, x / 2 - 0.05), (-y * 0.22, y * 0.22), (0.01, z * 0.4))
    k.surface((-x / 2 + 0.05, x / 2 - 0.05), (-y * 0.22, y * 0.22), 0.01, z * 0.4)


@shape("tree")
def tree(k: Kit) -> None:
    """A trunk with a round crown; a bush is the crown alone."""
    k.unit()
    if k.name == "bush":
        k.ball((-0.5, 0.3), (-0.5, 0.2), (0, 0.8))
        k.ball((-0.2, 0.5), (-0.2, 0.5), (0, 0.75), shade(k.color, 0.85), Material.PLANT)
        k.ball((-0.35, 0.35), (-0.35, 0.35), (0.2, 1.0), shade(k.color, 1.12), Material.PLANT)
        return
    k.cyl((-0.08, 0.08), (-0.08, 0.08), (0, 0.55), (96, 68, 46), Material.WOOD, taper=0.7)
    k.ball((-0.5, 0.4), (-0.45, 0.4), (0.34, 0.8))
    k.ball((-0.3, 0.5), (-0.3, 0.5), (0.4, 0.82), shade(k.color, 0.88), Material.PLANT)
    k.ball((-0.36, 0.36), (-0.36, 0.36), (0.55, 1.0), shade(k.color, 1.1), Material.PLANT)


@shape("rock")
def rock(k: Kit) -> None:
    """A boulder."""
    k.unit()
    k.ball((-0.5, 0.4), (-0.5, 0.4), (-0.3, 0.9), k.color, Material.CONCRETE)
    k.ball((-0.2, 0.5), (-0.3, 0.5), (-0.2, 0.7), shade(k.color, 0.9), Material.CONCRETE)
    k.box((-0.25, 0.15), (-0.25, 0.15), (0.0, 0.96), shade(k.color, 1.08), Material.CONCRETE)
    x, y, z = k.size
    k.surface((-x * 0.2, x * 0.1), (-y * 0.2, y * 0.1), z)
