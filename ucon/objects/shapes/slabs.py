"""Flat food: meat, fish, seafood, cheese, slices of bread and cake."""

from __future__ import annotations

from ucon.objects.kit import Kit, shape
from ucon.objects.model import Material
from ucon.objects.palette import BROWN, CREAM, DARKBROWN, ORANGE, RED, TAN, WHITE, YELLOW, shade
from ucon.objects.shapes.meals import WHOLE


@shape("food_slab")
def slab_food(k: Kit) -> None:
    """Meat, fish, cheese, bread and cake."""
    k.unit()
    name = k.name
    if name in ("bacon", "brisket", "lamb", "steak", "pork_chop", "ham_hock", "virginia_ham"):
        _meat(k)
    elif name in ("trout", "salmon"):
        _fish(k)
    elif name in ("shrimp", "crab", "clam", "oyster"):
        _seafood(k)
    elif name in ("bread_slice", "toast", "french_toast"):
        k.box((-0.5, 0.3), (-0.46, 0.46), (0, 1), (150, 96, 52))
        k.ball((0.0, 0.5), (-0.5, 0.5), (0, 1), (150, 96, 52))
        k.box((-0.44, 0.34), (-0.4, 0.4), (0.02, 1.03), (238, 212, 160) if name != "toast" else (214, 160, 96))
    elif name in ("swiss_cheese", "cheddar"):
        (k.wedge if name == "cheddar" else k.box)((-0.5, 0.5), (-0.5, 0.5), (0, 1))
        for x0, y0 in ((-0.3, -0.2), (0.1, 0.1), (0.2, -0.36)):
            if name == "swiss_cheese":
                k.cyl((x0, x0 + 0.2), (y0, y0 + 0.2), (0.98, 1.02), (206, 160, 60))
    elif name in ("butter", "feta", "paraffin_wax", "pizza_dough", "white_chocolate"):
        _block(k)
    elif name == "club_sandwich":
        for i, color in enumerate(((222, 180, 116), (90, 160, 70), (230, 130, 120), (240, 210, 90), (222, 180, 116))):
            k.box((-0.5, 0.5), (-0.5, 0.5), (0.2 * i, 0.2 * i + 0.2), color)
    elif name == "sushi":
        k.cyl(*WHOLE, (0, 0.9), (30, 44, 34))
        k.cyl((-0.42, 0.42), (-0.42, 0.42), (0.9, 0.95), WHITE)
        k.cyl((-0.16, 0.16), (-0.16, 0.16), (0.95, 1.0), ORANGE)
    else:
        layers = {"tiramisu": (CREAM, BROWN), "lasagna": (RED, YELLOW), "brownie": (DARKBROWN, (50, 30, 20)),
                  "fruitcake": (BROWN, RED), "half_apple_pie": (TAN, (190, 130, 70))}  # fmt: skip
        low, high = layers.get(name, (k.color, shade(k.color, 1.2)))
        k.box(*WHOLE, (0, 0.6), low)
        k.box((-0.48, 0.48), (-0.48, 0.48), (0.6, 0.9), high)
        k.box((-0.3, 0.2), (-0.3, 0.3), (0.9, 1.0), shade(high, 0.85))


def _meat(k: Kit) -> None:
    fat = (240, 220, 206)
    if k.name == "bacon":
        for i in range(5):
            y0 = -0.5 + 0.2 * i
            k.box((-0.5, 0.5), (y0, y0 + 0.2), (0, 1 - 0.1 * (i % 2)), (170, 50, 46) if i % 2 == 0 else fat)
    elif k.name in ("ham_hock", "virginia_ham"):
        k.ball((-0.5, 0.3), (-0.5, 0.5), (0, 1), (206, 120, 110))
        k.cyl((-0.36, -0.1), (-0.44, 0.44), (0.06, 0.94), (220, 150, 136), axis="x")
        k.cyl((0.2, 0.5), (-0.12, 0.12), (0.36, 0.64), CREAM, axis="x")
    else:
        color = (
            (160, 50, 46)
            if k.name in ("steak", "lamb")
            else (210, 130, 120)
            if k.name == "pork_chop"
            else (120, 70, 46)
        )
        k.ball((-0.5, 0.5), (-0.5, 0.5), (-0.5, 1.0), fat)
        k.ball((-0.4, 0.46), (-0.44, 0.44), (-0.4, 1.04), color)
        k.cyl((-0.3, -0.12), (-0.1, 0.1), (0.8, 1.0), CREAM)


def _fish(k: Kit) -> None:
    if k.name == "salmon":
        k.box((-0.5, 0.5), (-0.5, 0.5), (0, 0.3), (150, 150, 156))
        k.box((-0.5, 0.5), (-0.48, 0.48), (0.3, 1.0), (236, 130, 96))
        for i in range(3):
            x0 = -0.3 + 0.25 * i
            k.box((x0, x0 + 0.03), (-0.48, 0.48), (0.98, 1.01), (250, 190, 160))
        return
    k.ball((-0.3, 0.5), (-0.5, 0.5), (0, 1), (130, 140, 140), Material.METAL)
    k.box((-0.5, -0.34), (-0.42, 0.42), (0.3, 0.6), (104, 112, 112))
    k.rod((-0.4, 0, 0.5), (-0.2, 0, 0.5), (0.012, 0.02), (120, 128, 128))
    k.ball((0.34, 0.4), (-0.3, 0.3), (0.6, 0.9), (20, 20, 20))


def _seafood(k: Kit) -> None:
    if k.name == "crab":
        k.ball((-0.3, 0.3), (-0.32, 0.32), (0, 1), (210, 80, 46))
        for s in (-1, 1):
            for i in range(2):
                k.rod((-0.1 + 0.14 * i, s * 0.25, 0.4), (-0.2 + 0.14 * i, s * 0.5, 0.1), 0.012, (190, 66, 40))
            k.rod((0.2, s * 0.25, 0.4), (0.4, s * 0.4, 0.5), 0.016, (210, 80, 46))
            k.ball((0.3, 0.52), (s * 0.34 - 0.12, s * 0.34 + 0.12), (0.2, 0.8), (226, 96, 60))
    elif k.name == "shrimp":
        for i, (x0, y0) in enumerate(((-0.3, 0.2), (-0.1, -0.1), (0.15, -0.1), (0.3, 0.2))):
            k.ball((x0 - 0.2, x0 + 0.2), (y0 - 0.3, y0 + 0.3), (0, 1 - 0.1 * i), (240, 150 - 10 * (i % 2), 130))
    else:
        k.ball(*WHOLE, (0, 1), k.color)
        k.ball((-0.4, 0.4), (-0.4, 0.4), (0.3, 1.02), shade(k.color, 1.4))


def _block(k: Kit) -> None:
    if k.name == "pizza_dough":
        k.ball(*WHOLE, (-0.4, 1.0), (238, 222, 186))
    elif k.name == "butter":
        k.box((-0.5, 0.5), (-0.5, 0.5), (0, 0.9), (248, 226, 120))
        k.box((-0.5, 0.5), (-0.5, -0.1), (-0.0, 1.0), (222, 226, 232), Material.PAPER)
    elif k.name == "white_chocolate":
        k.box(*WHOLE, (0, 0.7), (244, 230, 196))
        for i in range(3):
            for j in range(2):
                k.box(
                    (-0.45 + 0.48 * j, -0.05 + 0.48 * j),
                    (-0.46 + 0.32 * i, -0.18 + 0.32 * i),
                    (0.7, 1.0),
                    (250, 240, 212),
                )
    else:
        k.box(*WHOLE, (0, 1))
        k.box((-0.4, 0.4), (-0.4, 0.4), (0.99, 1.01), shade(k.color, 0.9))
