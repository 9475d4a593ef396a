"""Cans, boxes, cartons, shakers, cups and bags."""

from __future__ import annotations

from ucon.objects.kit import Kit, shape
from ucon.objects.model import Material
from ucon.objects.palette import (
    BROWN,
    CREAM,
    DARKBROWN,
    GREEN,
    ORANGE,
    PAPER,
    RED,
    RGB,
    SILVER,
    TAN,
    WHITE,
    YELLOW,
    shade,
)
from ucon.objects.shapes.bottles import label_color

GLASS = Material.GLASS


@shape("can")
def can(k: Kit) -> None:
    """A metal can: soda cans are printed all over, food cans have a paper label."""
    k.unit()
    if k.has("soda"):
        k.cyl((-0.42, 0.42), (-0.42, 0.42), (0, 0.06), SILVER, Material.METAL)
        k.cyl((-0.5, 0.5), (-0.5, 0.5), (0.06, 0.9), k.color, Material.METAL)
        k.box((0.4, 0.505), (-0.14, 0.14), (0.2, 0.8), WHITE)
        k.cyl((-0.5, 0.5), (-0.5, 0.5), (0.9, 0.97), SILVER, Material.METAL, taper=0.85)
        k.box((-0.1, 0.2), (-0.08, 0.08), (0.97, 1.0), SILVER, Material.METAL)
        return
    k.cyl((-0.5, 0.5), (-0.5, 0.5), (0, 0.12), SILVER, Material.METAL)
    k.cyl((-0.48, 0.48), (-0.48, 0.48), (0.12, 0.88), k.color if k.color != SILVER else (196, 60, 50), Material.PAPER)
    k.box((0.38, 0.49), (-0.3, 0.3), (0.3, 0.7), label_color(k), Material.PAPER)
    k.cyl((-0.5, 0.5), (-0.5, 0.5), (0.88, 1.0), SILVER, Material.METAL)
    k.cyl((-0.42, 0.42), (-0.42, 0.42), (0.99, 1.004), (160, 162, 166), Material.METAL)
    if k.has("dog_food"):
        k.ball((0.45, 0.51), (-0.12, 0.12), (0.4, 0.6), BROWN)


@shape("box")
def printed_box(k: Kit) -> None:
    """A cardboard box with a printed front."""
    k.unit()
    if k.has("can_of"):
        k.cyl((-0.5, 0.5), (-0.5, 0.5), (0, 0.9), None, Material.PAPER)
        k.cyl((-0.505, 0.505), (-0.505, 0.505), (0.3, 0.6), label_color(k), Material.PAPER)
        k.cyl((-0.5, 0.5), (-0.5, 0.5), (0.9, 1.0), CREAM)
        return
    k.material = Material.PAPER
    if k.name == "pizza_box":
        k.box((-0.5, 0.5), (-0.5, 0.5), (0, 0.98))
        k.cyl((-0.3, 0.3), (-0.3, 0.3), (0.98, 1.0), RED, Material.PAPER)
        k.cyl((-0.24, 0.24), (-0.24, 0.24), (0.99, 1.01), (238, 190, 90), Material.PAPER)
        k.box((0.49, 0.5), (-0.2, 0.2), (0.2, 0.8), shade(k.color, 0.8))
        return
    if k.name == "box_of_chocolates":
        k.box((-0.5, 0.5), (-0.5, 0.5), (0, 0.9), DARKBROWN)
        k.box((-0.5, 0.5), (-0.06, 0.06), (0.9, 0.94), RED)
        k.box((-0.07, 0.07), (-0.5, 0.5), (0.9, 0.94), RED)
        k.ball((-0.14, 0.14), (-0.16, 0.0), (0.88, 1.0), RED)
        k.ball((-0.14, 0.14), (0.0, 0.16), (0.88, 1.0), RED)
        return
    if k.size[2] < 0.6 * min(k.size[0], k.size[1]):
        _label_up(k)
        return
    accent = label_color(k)
    k.box((-0.49, 0.49), (-0.5, 0.5), (0, 1))
    k.box((0.49, 0.5), (-0.44, 0.44), (0.62, 0.92), accent, Material.PAPER)
    k.ball((0.44, 0.5), (-0.3, 0.3), (0.12, 0.5), _motif(k), Material.PAPER)
    k.box((-0.5, -0.49), (-0.44, 0.44), (0.62, 0.92), accent, Material.PAPER)


def _motif(k: Kit) -> RGB:
    motifs = {
        "cereal": (230, 180, 90), "corn": (240, 200, 70), "pasta": (240, 210, 120), "candy": (230, 60, 120),
        "cocoa": DARKBROWN, "oat": (216, 190, 140), "granola": (180, 130, 70), "raisin": (90, 40, 80),
        "cream_cheese": WHITE, "feta": (70, 120, 190), "hummus": (230, 200, 150), "butter": (250, 230, 130),
        "margarine": (250, 240, 170), "lasagna": (210, 90, 50), "sugar": (90, 150, 210), "baking": (210, 60, 50),
    }  # fmt: skip
    return next((color for word, color in motifs.items() if k.has(word)), shade(k.color, 0.6))


def _label_up(k: Kit) -> None:
    k.box((-0.5, 0.5), (-0.5, 0.5), (0, 0.985))
    k.box((0.05, 0.42), (-0.42, 0.42), (0.985, 1.0), label_color(k), Material.PAPER)
    k.box((-0.42, -0.05), (-0.26, 0.26), (0.985, 1.0), _motif(k), Material.PAPER)


@shape("gable_carton")
def carton(k: Kit) -> None:
    """A drink carton with a gable top and a cap; the moving carton has its own shape."""
    k.unit()
    k.material = Material.PAPER
    stripe = {"orange": ORANGE, "milk": (60, 120, 200), "pineapple": (240, 200, 60), "cream": (90, 150, 210),
              "chicken": (206, 70, 50), "yogurt": (220, 90, 140)}  # fmt: skip
    color = next((c for word, c in stripe.items() if k.has(word)), RED)
    base = k.color if sum(k.color) < 650 else (244, 244, 240)
    if k.has("ice_cream", "yogurt"):
        k.cyl((-0.5, 0.5), (-0.5, 0.5), (0.0, 0.86), base, taper=1.0)
        k.cyl((-0.505, 0.505), (-0.505, 0.505), (0.3, 0.6), PAPER if sum(base) < 600 else color)
        k.cyl((-0.5, 0.5), (-0.5, 0.5), (0.86, 1.0), WHITE)
        return
    k.box((-0.5, 0.5), (-0.5, 0.5), (0, 0.74), base)
    k.box((-0.505, 0.505), (-0.505, 0.505), (0.2, 0.5), color if color != base else WHITE)
    k.wedge((-0.5, 0.0), (-0.5, 0.5), (0.74, 0.93), shade(base, 0.94))
    k.wedge((0.0, 0.5), (-0.5, 0.5), (0.74, 0.93), shade(base, 0.94), flip=True)
    k.box((-0.03, 0.03), (-0.5, 0.5), (0.9, 1.0), base)
    k.cyl((0.2, 0.36), (-0.14, 0.14), (0.8, 0.9), color)


@shape("shaker")
def shaker(k: Kit) -> None:
    """A glass shaker of spice with a holed lid."""
    k.unit()
    salt = k.name in ("salt_shaker", "pepper_shaker")
    k.cyl((-0.5, 0.5), (-0.5, 0.5), (0, 0.72), None, GLASS if not salt else None, taper=0.9)
    if not salt:
        k.cyl((-0.5, 0.5), (-0.5, 0.5), (0.2, 0.52), PAPER, Material.PAPER)
    top = {"parmesan": GREEN, "salt": SILVER, "pepper": SILVER, "cinnamon": RED, "paprika": RED}
    color = next((c for word, c in top.items() if k.has(word)), (40, 110, 60))
    k.cyl((-0.45, 0.45), (-0.45, 0.45), (0.72, 0.94), color, Material.METAL if salt else None)
    k.ball((-0.42, 0.42), (-0.42, 0.42), (0.88, 1.0), color, Material.METAL if salt else None)


@shape("cup_small")
def yogurt_cup(k: Kit) -> None:
    """A small plastic cup, wider at the top, with a foil lid."""
    k.unit()
    k.cyl((-0.36, 0.36), (-0.36, 0.36), (0, 0.92), WHITE, None, taper=1.3)
    k.cyl((-0.43, 0.43), (-0.43, 0.43), (0.34, 0.66), (222, 90, 140), Material.PAPER)
    k.cyl((-0.5, 0.5), (-0.5, 0.5), (0.92, 1.0), SILVER, Material.METAL)


@shape("bag_sack")
def sack(k: Kit) -> None:
    """Pillow bags, paper sacks with a folded top, trays of meat, and rubbish bags with a knot."""
    x, y, z = k.size
    k.unit()
    if k.has("rubbish"):
        k.ball((-0.5, 0.5), (-0.5, 0.5), (-0.15, 0.85))
        k.ball((-0.4, 0.3), (-0.3, 0.45), (0.1, 0.85), shade(k.color, 1.1))
        k.cyl((-0.06, 0.06), (-0.06, 0.06), (0.8, 0.9), (220, 190, 60))
        k.cyl((-0.06, 0.06), (-0.06, 0.06), (0.88, 1.0), k.color, None, taper=2.2)
        return
    if k.name == "tea_bag":
        k.box((-0.5, 0.2), (-0.5, 0.5), (0, 0.5), (206, 190, 150), Material.PAPER)
        k.box((-0.4, 0.1), (-0.36, 0.36), (0.5, 0.62), (120, 96, 60), Material.PAPER)
        k.box((0.2, 0.4), (-0.02, 0.02), (0.2, 0.26), WHITE)
        k.box((0.36, 0.5), (-0.26, 0.26), (0, 1.0), k.color, Material.PAPER)
        return
    if k.has("bag_of_oranges"):
        for i in range(6):
            x0, y0, z0 = -0.5 + 0.46 * (i % 2), -0.5 + 0.33 * (i % 3), 0.0 if i < 4 else 0.36
            k.ball((x0, x0 + 0.54), (y0, y0 + 0.4), (z0, z0 + 0.56), ORANGE)
        k.cyl((-0.08, 0.08), (-0.08, 0.08), (0.7, 1.0), (200, 60, 50))
        return
    if k.has("ground_beef"):
        k.box((-0.5, 0.5), (-0.5, 0.5), (0, 0.5), WHITE)
        k.box((-0.42, 0.42), (-0.44, 0.44), (0.5, 0.94), (190, 60, 60))
        k.box((-0.1, 0.3), (-0.2, 0.2), (0.94, 1.0), YELLOW, Material.PAPER)
        return
    if k.has("bread"):
        k.box((-0.5, 0.5), (-0.4, 0.34), (0, 0.7), (206, 160, 104))
        k.ball((-0.5, 0.5), (-0.42, 0.36), (0.45, 1.0), (186, 130, 74))
        k.cyl((-0.12, 0.12), (0.34, 0.5), (0.3, 0.6), (60, 110, 190), None, axis="y", taper=1.6)
        k.box((-0.51, 0.51), (-0.15, 0.1), (0.02, 0.66), RED, Material.PAPER)
        return
    flat = z < 0.6 * min(x, y) or k.size[2] < 0.05
    accent = label_color(k)
    if flat:
        k.ball((-0.5, 0.5), (-0.46, 0.46), (0.0, 0.96))
        k.box((-0.46, 0.46), (-0.5, -0.42), (0.3, 0.56), shade(k.color, 0.8))
        k.box((-0.46, 0.46), (0.42, 0.5), (0.3, 0.56), shade(k.color, 0.8))
        k.cyl((-0.24, 0.24), (-0.22, 0.22), (0.9, 1.0), accent)
        return
    chips = k.has("chip", "popcorn")
    soft = Material.PLAIN if chips else Material.PAPER
    k.box((-0.5, 0.5), (-0.5, 0.5), (0.06, 0.74), None, soft)
    k.box((-0.42, 0.42), (-0.46, 0.46), (0, 0.06), None, soft)
    k.wedge((-0.5, 0.0), (-0.5, 0.5), (0.74, 0.92), shade(k.color, 0.92), soft)
    k.wedge((0.0, 0.5), (-0.5, 0.5), (0.74, 0.92), shade(k.color, 0.92), soft, flip=True)
    k.box((-0.06, 0.06), (-0.5, 0.5), (0.9, 1.0), shade(k.color, 0.75), soft)
    k.box((0.5, 0.51), (-0.36, 0.36), (0.4, 0.68), accent, Material.PAPER)
    k.ball((0.44, 0.53), (-0.28, 0.28), (0.1, 0.36), _content(k))


def _content(k: Kit) -> RGB:
    contents = {
        "rice": (250, 246, 230), "flour": (230, 200, 140), "sugar": (110, 170, 220), "cocoa": (90, 54, 34),
        "tea": (120, 150, 70), "popcorn": (250, 236, 170), "chip": (240, 200, 90), "seed": (90, 80, 60),
        "pasta": (240, 210, 110), "mulch": (110, 80, 50), "soil": (100, 140, 70), "cheese": (250, 220, 120),
    }  # fmt: skip
    return next((color for word, color in contents.items() if k.has(word)), TAN)
