"""Long fruit and vegetables: roots, stalks, pods, bananas."""

from __future__ import annotations

from itertools import pairwise

from ucon.objects.kit import Kit, shape
from ucon.objects.palette import DARKGREEN, RGB, TAN, YELLOW, shade
from ucon.objects.shapes.produce import LEAF, PLANT, STEM, WHOLE


def _one_banana(k: Kit) -> None:
    _banana(k, 0.0, 0.0, 1.0)


def _bunch_of_bananas(k: Kit) -> None:
    for i in range(3):
        _banana(k, (i - 1) * 0.3, 0.12 * (i % 2), 0.6)


def _bell_pepper(k: Kit) -> None:
    k.ball((-0.5, 0.4), (-0.5, 0.1), (0, 0.95))
    k.ball((-0.5, 0.4), (-0.1, 0.5), (0, 0.95), shade(k.color, 0.92))
    k.cyl((0.34, 0.55), (-0.08, 0.08), (0.5, 0.66), LEAF, axis="x")


def _pineapple(k: Kit) -> None:
    k.ball((-0.5, 0.2), (-0.5, 0.5), (0, 1), (196, 146, 62))
    for i in range(3):
        x0 = -0.36 + 0.2 * i
        k.cyl((x0, x0 + 0.03), (-0.46, 0.46), (0.04, 0.96), (146, 100, 44), axis="x")
    for dy, dz in ((0, 0.5), (-0.3, 0.8), (0.3, 0.8), (0.0, 0.95), (0, 0.2)):
        k.rod((0.14, 0, 0.5), (0.5, dy, dz), 0.02, DARKGREEN, PLANT)


def _asparagus(k: Kit) -> None:
    x, y, _ = k.size
    _bundle(k, x >= y)


def _pear(k: Kit) -> None:
    k.ball((-0.5, 0.15), (-0.5, 0.5), (0, 1))
    k.ball((-0.15, 0.42), (-0.3, 0.3), (0.2, 0.8))
    k.cyl((0.38, 0.5), (-0.04, 0.04), (0.45, 0.55), STEM, axis="x")


def _sweet_corn(k: Kit) -> None:
    k.ball((-0.45, 0.45), (-0.3, 0.5), (0.05, 1.0), (240, 200, 70))
    k.ball((-0.5, 0.2), (-0.5, 0.1), (0, 0.8), (120, 170, 80), PLANT)
    k.ball((-0.2, 0.5), (-0.5, 0.05), (0, 0.85), (104, 154, 70), PLANT)


def _clove(k: Kit) -> None:
    name = k.name
    k.ball(*WHOLE, (0, 0.9), (236, 230, 216) if name == "garlic_clove" else None)
    k.cyl((-0.1, 0.1), (-0.1, 0.1), (0.7, 1.0), LEAF if name == "chili" else TAN, None, taper=0.3)


def _butternut_squash(k: Kit) -> None:
    k.ball((-0.5, 0.05), (-0.5, 0.5), (0, 1))
    k.cyl((-0.2, 0.44), (-0.32, 0.32), (0.18, 0.82), None, None, axis="x")
    k.cyl((0.42, 0.5), (-0.08, 0.08), (0.4, 0.6), STEM, axis="x")


def _any_root(k: Kit) -> None:
    x, y, _ = k.size
    _root(k, x >= y)


def _banana(k: Kit, y0: float, z0: float, width: float) -> None:
    """Bent in the plane of the table: three segments with dark ends."""
    w = 0.16 * width + 0.06
    points = [(-0.48, 0.3), (-0.2, -0.12), (0.16, -0.2), (0.44, 0.22)]
    t = 0.8 * min(k.size[2] * (1.0 if width > 0.9 else 0.4), 0.05)
    for (ax, ay), (bx, by) in pairwise(points):
        ay, by = y0 + ay * 0.8, y0 + by * 0.8
        k.rod((ax, ay, z0 + 0.4), (bx, by, z0 + 0.4), t, YELLOW, None, kind="cylinder")
    end = points[-1]
    k.rod((end[0], y0 + end[1] * 0.8, z0 + 0.4), (end[0] + 0.04, y0 + end[1] * 0.8 + w, z0 + 0.42), t * 0.4, STEM)


def _bundle(k: Kit, along_x: bool) -> None:
    tip = {"green_onion": (240, 240, 226), "celery": (150, 190, 90), "asparagus": (70, 104, 66)}.get(k.name, k.color)
    for i in range(3):
        side = -0.34 + 0.34 * i
        span = (side - 0.16, side + 0.16)
        z = (0, 1) if i == 1 else (0, 0.85)
        color = shade(k.color, 0.9 + 0.08 * i)
        if along_x:
            k.cyl((-0.5, 0.3), span, z, color, PLANT, axis="x")
            k.cyl((0.28, 0.5), span, z, tip, PLANT, axis="x", taper=0.5 if k.name != "celery" else 1.0)
        else:
            k.cyl(span, (-0.5, 0.3), z, color, PLANT, axis="y")
            k.cyl(span, (0.28, 0.5), z, tip, PLANT, axis="y", taper=0.4)


def _root(k: Kit, along_x: bool) -> None:
    """A tapering body with a green or brown end."""
    end = {"carrot": LEAF, "eggplant": LEAF, "beet": LEAF, "chili_pepper": LEAF, "baguette": None, "pickle": None}
    color = end.get(k.name, STEM)
    taper = {"carrot": 0.3, "chili_pepper": 0.2, "beet": 0.2}.get(k.name)
    axis = "x" if along_x else "y"

    def span(low: float, high: float, half: float, z: tuple[float, float], what: RGB | None, shrink: float) -> None:
        a, b = ((low, high), (-half, half)) if along_x else ((-half, half), (low, high))
        k.cyl(a, b, z, what, None, axis=axis, taper=shrink)

    if taper is not None:
        span(-0.3, 0.5, 0.5, (0, 1), None, taper)
        span(-0.5, -0.28, 0.3, (0.2, 0.8), color, 1.0)
        return
    ends = (-0.5, 0.5) if color is None else (-0.5, 0.42)
    if along_x:
        k.ball(ends, (-0.5, 0.5), (0, 1))
        k.cyl((-0.32, 0.26), (-0.46, 0.46), (0.03, 0.97), None, None, axis="x")
    else:
        k.ball((-0.5, 0.5), ends, (0, 1))
        k.cyl((-0.46, 0.46), (-0.32, 0.26), (0.03, 0.97), None, None, axis="y")
    if color is not None:
        span(0.38, 0.5, 0.2, (0.36, 0.64), color, 0.7)
    if k.name == "baguette":
        for i in range(4):
            y0 = -0.3 + 0.17 * i
            k.box((-0.3, 0.3), (y0, y0 + 0.05), (0.9, 1.0), (236, 206, 150))


_LONG = {
    "banana": _one_banana,
    "bunch_of_bananas": _bunch_of_bananas,
    "bell_pepper": _bell_pepper,
    "pineapple": _pineapple,
    "asparagus": _asparagus,
    "green_bean": _asparagus,
    "green_onion": _asparagus,
    "celery": _asparagus,
    "pea_pod": _asparagus,
    "pear": _pear,
    "sweet_corn": _sweet_corn,
    "garlic_clove": _clove,
    "date": _clove,
    "chili": _clove,
    "butternut_squash": _butternut_squash,
}


@shape("food_long")
def long_food(k: Kit) -> None:
    """Long food, laid along x or y, whichever is longer."""
    k.unit()
    _LONG.get(k.name, _any_root)(k)
