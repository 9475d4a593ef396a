"""Small electric things, each with its own face: keyboards, phones, cameras, clocks, scales."""

from __future__ import annotations

from ucon.objects.kit import Kit, shape
from ucon.objects.model import Material
from ucon.objects.palette import BLACK, BLUE, CREAM, DARK, GOLD, GREEN, GREY, RED, SILVER, WHITE, shade
from ucon.objects.shapes.electronics import GLOW, METAL


def _keyboard(k: Kit) -> None:
    k.box((-0.5, 0.5), (-0.5, 0.5), (0, 0.6))
    for i in range(4):
        x0 = -0.42 + 0.22 * i
        k.box((x0, x0 + 0.16), (-0.46, 0.46), (0.6, 1.0), (72, 74, 80))


def _mouse(k: Kit) -> None:
    k.ball((-0.5, 0.5), (-0.5, 0.5), (-0.7, 1.0))
    k.box((-0.1, 0.4), (-0.03, 0.03), (0.5, 1.0), GREY)


def _mousepad(k: Kit) -> None:
    k.box((-0.5, 0.5), (-0.5, 0.5), (0, 0.9), (40, 60, 90), Material.FABRIC)
    k.box((-0.48, 0.48), (-0.48, 0.48), (0.9, 1.0), BLACK, Material.FABRIC)


def _tablet(k: Kit) -> None:
    k.box((-0.5, 0.5), (-0.5, 0.5), (0, 0.85))
    k.box((-0.43, 0.43), (-0.44, 0.44), (0.85, 1.0), GLOW, Material.GLASS)


def _radio(k: Kit) -> None:
    k.box((-0.5, 0.4), (-0.5, 0.5), (0, 0.8), (140, 90, 54), Material.WOOD)
    k.cyl((0.4, 0.46), (-0.42, -0.06), (0.12, 0.68), CREAM, axis="x")
    k.box((0.4, 0.46), (0.04, 0.42), (0.46, 0.68), (240, 220, 160))
    for y0 in (0.1, 0.28):
        k.cyl((0.4, 0.5), (y0, y0 + 0.12), (0.14, 0.32), GOLD, METAL, axis="x")
    k.rod((-0.3, 0.3, 0.8), (-0.3, 0.48, 1.0), 0.006, SILVER)


def _phone(k: Kit) -> None:
    k.wedge((-0.5, 0.5), (-0.5, 0.5), (0, 0.6), k.color, None, flip=True)
    k.box((-0.4, 0.3), (-0.44, -0.2), (0.4, 0.7), DARK)
    k.box((-0.48, 0.4), (-0.48, -0.16), (0.7, 1.0), shade(k.color, 1.2))
    for i in range(3):
        k.box((-0.1 + 0.16 * i, 0.0 + 0.16 * i), (-0.05, 0.4), (0.3, 0.5 - 0.08 * i), WHITE)
    k.box((-0.42, -0.2), (-0.05, 0.4), (0.5, 0.66), (150, 190, 160))


def _camera(k: Kit) -> None:
    k.box((-0.5, 0.1), (-0.5, 0.5), (0, 0.8))
    k.box((-0.4, 0.0), (-0.2, 0.2), (0.8, 1.0))
    k.cyl((0.1, 0.5), (-0.28, 0.28), (0.1, 0.7), DARK, axis="x")
    k.cyl((0.48, 0.51), (-0.2, 0.2), (0.2, 0.6), (90, 110, 160), Material.GLASS, axis="x")
    k.cyl((-0.3, -0.1), (0.3, 0.44), (0.8, 0.88), RED)
    k.box((0.1, 0.14), (0.3, 0.46), (0.5, 0.66), WHITE)


def _webcam(k: Kit) -> None:
    k.cyl((-0.4, 0.4), (-0.4, 0.4), (0, 0.1))
    k.box((-0.06, 0.06), (-0.06, 0.06), (0.1, 0.45), GREY)
    k.ball((-0.5, 0.5), (-0.5, 0.5), (0.4, 1.0))
    k.cyl((0.35, 0.52), (-0.2, 0.2), (0.58, 0.84), (90, 130, 180), Material.GLASS, axis="x")


def _flashlight(k: Kit) -> None:
    k.cyl((-0.5, 0.2), (-0.32, 0.32), (0.18, 0.82), None, None, axis="x")
    k.cyl((0.16, 0.46), (-0.36, 0.36), (0.14, 0.86), SILVER, METAL, axis="x", taper=1.35)
    k.cyl((0.46, 0.5), (-0.46, 0.46), (0.04, 0.96), (250, 240, 180), axis="x")
    k.box((-0.1, 0.04), (-0.1, 0.1), (0.8, 0.92), RED)


def _scale(k: Kit) -> None:
    k.box((-0.5, 0.5), (-0.5, 0.5), (0, 0.6), DARK)
    k.box((-0.5, 0.3), (-0.48, 0.48), (0.6, 1.0), (210, 214, 218), METAL)
    k.box((0.34, 0.46), (-0.2, 0.2), (0.6, 0.8), (150, 200, 160))


def _modem(k: Kit) -> None:
    k.box((-0.5, 0.5), (-0.5, 0.5), (0, 0.7))
    for s in (-0.34, 0.3):
        k.rod((s, 0, 0.7), (s * 1.2, 0, 1.0), 0.012, BLACK)
    for i in range(3):
        k.box((0.49, 0.52), (-0.3, 0.3), (0.2 + 0.14 * i, 0.26 + 0.14 * i), (90, 220, 120))


def _alarm_clock(k: Kit) -> None:
    k.box((-0.5, 0.4), (-0.5, 0.5), (0, 0.9))
    k.box((0.4, 0.44), (-0.42, 0.42), (0.2, 0.78), (60, 20, 20))
    for i in range(4):
        y0 = -0.34 + 0.18 * i
        k.box((0.44, 0.5), (y0, y0 + 0.1), (0.3, 0.68), (255, 70, 60))
    k.box((-0.2, 0.2), (-0.2, 0.2), (0.9, 1.0), SILVER)


def _terminal(k: Kit) -> None:
    k.wedge((-0.5, 0.5), (-0.5, 0.5), (0, 1.0), k.color, None, flip=True)
    k.box((-0.5, -0.2), (-0.36, 0.36), (0.5, 1.02), (150, 190, 210))
    for i in range(3):
        k.box((-0.06 + 0.16 * i, 0.06 + 0.16 * i), (-0.34, 0.34), (0.2, 0.66 - 0.15 * i), (220, 220, 220))


def _battery(k: Kit) -> None:
    k.cyl((-0.5, 0.5), (-0.5, 0.5), (0, 0.64), BLACK)
    k.cyl((-0.5, 0.5), (-0.5, 0.5), (0.64, 0.92), (206, 140, 60), METAL)
    k.cyl((-0.2, 0.2), (-0.2, 0.2), (0.92, 1.0), SILVER, METAL)


def _charger(k: Kit) -> None:
    k.box((-0.5, 0.3), (-0.5, 0.5), (0, 0.8), WHITE)
    for s in (-0.2, 0.2):
        k.box((0.3, 0.5), (s - 0.06, s + 0.06), (0.3, 0.5), SILVER, METAL)
    k.rod((-0.3, 0, 0.8), (-0.1, 0.3, 1.0), 0.006, GREY)


def _thermometer(k: Kit) -> None:
    k.cyl((-0.5, -0.2), (-0.5, 0.5), (0, 1), WHITE)
    k.box((-0.45, -0.26), (-0.3, 0.3), (0.95, 1.02), (120, 160, 130))
    k.box((-0.22, 0.5), (-0.1, 0.1), (0.3, 0.6), SILVER, METAL)


def _filter(k: Kit) -> None:
    if k.name == "water_filter":
        k.cyl((-0.5, 0.5), (-0.5, 0.5), (0.1, 0.85), (226, 232, 238))
        k.cyl((-0.5, 0.5), (-0.5, 0.5), (0.85, 1.0), BLUE)
        k.cyl((-0.3, 0.3), (-0.3, 0.3), (0, 0.1), BLUE)
        return
    k.box((-0.5, 0.5), (-0.5, 0.5), (0, 0.9), WHITE)
    for i in range(5):
        y0 = -0.44 + 0.19 * i
        k.box((-0.44, 0.44), (y0, y0 + 0.1), (0.9, 1.0), (170, 190, 200))
    k.box((-0.51, 0.51), (-0.51, 0.51), (0.4, 0.5), BLUE)


def _scanner(k: Kit) -> None:
    k.box((-0.5, 0.5), (-0.5, 0.5), (0, 0.6))
    k.box((-0.5, 0.46), (-0.48, 0.48), (0.62, 1.0), shade(k.color, 0.7))
    k.box((0.49, 0.51), (0.2, 0.4), (0.2, 0.45), GREEN)


def _cup_holder(k: Kit) -> None:
    k.box((-0.5, -0.3), (-0.5, 0.5), (0, 1))
    k.box((-0.3, 0.5), (-0.5, 0.5), (0, 0.12))
    for s in (-0.25, 0.25):
        k.cyl((-0.25, 0.45), (s - 0.22, s + 0.22), (0.12, 0.55), DARK)
        k.cyl((-0.2, 0.4), (s - 0.18, s + 0.18), (0.55, 0.57), (10, 10, 10))


def _puck(k: Kit) -> None:
    k.cyl((-0.5, 0.5), (-0.5, 0.5), (0, 0.7), WHITE, None, taper=0.8)
    k.ball((-0.2, 0.2), (-0.2, 0.2), (0.5, 1.0), DARK)


def _stirrer(k: Kit) -> None:
    k.box((-0.5, 0.5), (-0.5, 0.5), (0, 0.75))
    k.cyl((-0.4, 0.3), (-0.38, 0.38), (0.75, 1.0), (206, 210, 214), METAL)
    k.cyl((0.5, 0.54), (-0.2, 0.0), (0.2, 0.5), BLUE, axis="x")


def _fax(k: Kit) -> None:
    k.wedge((-0.5, 0.5), (-0.5, 0.5), (0, 1), k.color, None, flip=True)
    k.box((-0.3, 0.0), (-0.4, 0.1), (0.6, 1.0), WHITE)
    k.box((-0.3, 0.3), (0.2, 0.4), (0.4, 0.9), DARK)


_DEVICES = {
    "keyboard": _keyboard, "mouse": _mouse, "mousepad": _mousepad, "tablet": _tablet, "radio": _radio,
    "desk_phone": _phone, "digital_camera": _camera, "webcam": _webcam, "flashlight": _flashlight,
    "digital_scale": _scale, "modem": _modem, "alarm_clock": _alarm_clock, "credit_card_terminal": _terminal,
    "battery": _battery, "charger": _charger, "meat_thermometer": _thermometer, "air_filter": _filter,
    "water_filter": _filter, "scanner": _scanner, "cup_holder": _cup_holder, "motion_sensor": _puck,
    "magnetic_stirrer": _stirrer, "facsimile": _fax,
}  # fmt: skip


@shape("device_small")
def device(k: Kit) -> None:
    """Small electric things, each with its own face."""
    k.unit()
    _DEVICES[k.name](k)
    x, y, z = k.size
    if k.category.support:
        half = 0.3 if k.name == "radio" else 0.42
        top = 0.8 * z if k.name == "radio" else z
        k.surface((-x * half, x * 0.25), (-y * half, y * (0.2 if k.name == "radio" else half)), top)
