"""Bottles, jars, cans, boxes, cartons, bags: packaging whose colour and label tell what is in it."""

from __future__ import annotations

from ucon.objects.kit import (
    BLACK,
    BLUE,
    BROWN,
    CREAM,
    DARK,
    DARKBROWN,
    DARKGREEN,
    GLASSY,
    GOLD,
    GREEN,
    GREY,
    ORANGE,
    PAPER,
    RED,
    RGB,
    SILVER,
    TAN,
    WHITE,
    YELLOW,
    Kit,
    shade,
    shape,
)  # fmt: skip
from ucon.objects.model import Material
from ucon.objects.shapes.generic import ring
from ucon.objects.shapes.vessels import round_space

GLASS = Material.GLASS


def label_color(k: Kit) -> RGB:
    """A label that stands out from the content; equal names have equal labels."""
    palette = (PAPER, (232, 214, 120), (206, 60, 52), (70, 130, 80), (62, 104, 176), (240, 240, 236))
    pick = palette[sum(map(ord, k.name)) % len(palette)]
    contrast = sum(abs(a - b) for a, b in zip(pick, k.color, strict=True))
    if contrast > 150:
        return pick
    return PAPER if sum(k.color) < 480 else (62, 104, 176)


@shape("bottle")
def bottle(k: Kit) -> None:
    """Body, label band, shoulder, neck and cap, in proportions by what it holds."""
    k.unit()
    cap = _cap(k)
    if k.has(
        "wine", "beer", "vodka", "whiskey", "rum_", "champagne", "oil_bottle", "olive_oil", "vinegar", "soy", "vanilla"
    ):
        _slim(k, 0.56, cap, GLASS)
    elif k.has("aspirin", "medicine", "antihistamines", "supplements", "peanut_butter", "salt_bottle"):
        _squat(k, cap)
    elif k.has("lotion", "liquid_soap", "soap_bottle", "shampoo", "cream"):
        _pump(k)
    elif k.has(
        "detergent", "bleach", "softener", "chlorine", "disinfectant", "herbicide", "polish", "floor_wax", "lubricant"
    ):
        _jug(k, cap)
    elif k.has("perfume", "ink", "reagent"):
        _flacon(k, cap)
    elif k.has("ketchup", "catsup", "mustard", "mayonnaise", "sauce", "salsa", "syrup", "glaze"):
        _squeeze(k, cap)
    elif k.has("sunscreen"):
        k.box((-0.5, 0.5), (-0.5, 0.5), (0.18, 1), k.color)
        k.box((-0.4, 0.4), (-0.4, 0.4), (0, 0.18), WHITE)
        k.box((0.45, 0.52), (-0.3, 0.3), (0.4, 0.8), YELLOW)
    elif k.has("milk"):
        _slim(k, 0.62, (60, 110, 190), Material.PLAIN)
    elif k.has("baby"):
        _baby(k)
    else:
        _drink(k, cap)


def _cap(k: Kit) -> RGB:
    if k.has("water", "soda_water"):
        return (50, 110, 190)
    if k.has("wine"):
        return (150, 120, 60)
    if k.has("cola", "pop", "soda", "hot_sauce"):
        return RED if sum(k.color) < 300 else WHITE
    if k.has("beer", "vodka"):
        return GOLD
    return WHITE if sum(k.color) < 500 else (60, 110, 180) if k.color[2] > 180 else DARKGREEN


def _slim(k: Kit, shoulder: float, cap: RGB, material: Material) -> None:
    k.cyl((-0.5, 0.5), (-0.5, 0.5), (0, 0.12), None, material)
    k.cyl((-0.5, 0.5), (-0.5, 0.5), (0.12, shoulder - 0.1), label_color(k), Material.PAPER)
    k.cyl((-0.5, 0.5), (-0.5, 0.5), (shoulder - 0.1, shoulder), None, material)
    k.cyl((-0.5, 0.5), (-0.5, 0.5), (shoulder, shoulder + 0.15), None, material, taper=0.4)
    k.cyl((-0.2, 0.2), (-0.2, 0.2), (shoulder + 0.15, 0.92), None, material)
    k.cyl((-0.22, 0.22), (-0.22, 0.22), (0.9, 1.0), cap)


def _squat(k: Kit, cap: RGB) -> None:
    lid = WHITE if sum(k.color) < 560 else (70, 110, 180)
    k.cyl((-0.5, 0.5), (-0.5, 0.5), (0, 0.14))
    k.cyl((-0.5, 0.5), (-0.5, 0.5), (0.14, 0.62), label_color(k), Material.PAPER)
    k.cyl((-0.5, 0.5), (-0.5, 0.5), (0.62, 0.76), None, None, taper=0.85)
    k.cyl((-0.45, 0.45), (-0.45, 0.45), (0.76, 1.0), lid if lid != k.color else cap)


def _pump(k: Kit) -> None:
    k.cyl((-0.5, 0.5), (-0.5, 0.5), (0, 0.62))
    k.box((0.36, 0.51), (-0.24, 0.24), (0.14, 0.5), label_color(k), Material.PAPER)
    k.cyl((-0.5, 0.5), (-0.5, 0.5), (0.62, 0.74), None, None, taper=0.45)
    k.cyl((-0.24, 0.24), (-0.24, 0.24), (0.74, 0.82), WHITE)
    if k.has("shampoo", "cream"):
        k.cyl((-0.34, 0.34), (-0.34, 0.34), (0.74, 1.0), WHITE if sum(k.color) < 600 else BLUE)
        return
    k.cyl((-0.08, 0.08), (-0.08, 0.08), (0.82, 0.94), SILVER)
    k.box((-0.14, 0.44), (-0.12, 0.12), (0.92, 1.0), WHITE)


def _jug(k: Kit, cap: RGB) -> None:
    lid = (40, 90, 170) if k.color[2] < 150 or sum(k.color) > 600 else RED
    k.box((-0.5, 0.5), (-0.5, 0.5), (0, 0.62))
    k.box((-0.505, 0.505), (-0.4, 0.4), (0.1, 0.52), label_color(k), Material.PAPER)
    k.cyl((-0.46, 0.46), (-0.46, 0.46), (0.62, 0.82), None, None, taper=0.6)
    k.cyl((-0.26, 0.26), (-0.26, 0.26), (0.82, 1.0), lid)
    k.box((-0.1, 0.1), (0.3, 0.46), (0.6, 0.82), shade(k.color, 0.8))


def _flacon(k: Kit, cap: RGB) -> None:
    if k.has("reagent"):
        k.cyl((-0.5, 0.5), (-0.5, 0.5), (0, 0.6), None, GLASS)
        k.cyl((-0.5, 0.5), (-0.5, 0.5), (0.6, 0.76), None, GLASS, taper=0.4)
        k.box((0.4, 0.51), (-0.3, 0.3), (0.16, 0.48), PAPER, Material.PAPER)
    else:
        k.box((-0.5, 0.5), (-0.5, 0.5), (0, 0.58), None, GLASS)
        k.box((0.48, 0.51), (-0.34, 0.34), (0.12, 0.44), PAPER, Material.PAPER)
    k.cyl((-0.2, 0.2), (-0.2, 0.2), (0.58, 0.74), GOLD, Material.METAL)
    k.cyl((-0.28, 0.28), (-0.28, 0.28), (0.72, 1.0), BLACK if k.has("ink", "reagent") else GOLD)


def _squeeze(k: Kit, cap: RGB) -> None:
    k.cyl((-0.46, 0.46), (-0.5, 0.5), (0, 0.2))
    k.cyl((-0.46, 0.46), (-0.5, 0.5), (0.2, 0.54), label_color(k), Material.PAPER)
    k.cyl((-0.46, 0.46), (-0.5, 0.5), (0.54, 0.8), None, None, taper=0.5)
    lid = WHITE if k.has("catsup", "hot_sauce", "salsa", "chocolate") else (200, 60, 40) if k.has("mustard") else DARK
    k.cyl((-0.26, 0.26), (-0.26, 0.26), (0.78, 0.9), lid)
    k.cyl((-0.18, 0.18), (-0.18, 0.18), (0.9, 1.0), lid, None, taper=0.4)


def _baby(k: Kit) -> None:
    k.cyl((-0.5, 0.5), (-0.5, 0.5), (0, 0.34), (248, 246, 240))
    k.cyl((-0.48, 0.48), (-0.48, 0.48), (0.34, 0.66), GLASSY, GLASS)
    k.cyl((-0.5, 0.5), (-0.5, 0.5), (0.66, 0.78), (110, 180, 220))
    k.cyl((-0.3, 0.3), (-0.3, 0.3), (0.78, 0.86), (226, 178, 140))
    k.cyl((-0.14, 0.14), (-0.14, 0.14), (0.84, 1.0), (226, 178, 140), None, taper=0.6)


def _drink(k: Kit, cap: RGB) -> None:
    material = GLASS if k.material == GLASS or k.has("juice", "soda", "cola", "pop", "beer") else k.material
    k.cyl((-0.48, 0.48), (-0.48, 0.48), (0, 0.3), None, material)
    k.cyl((-0.5, 0.5), (-0.5, 0.5), (0.3, 0.58), label_color(k), Material.PAPER)
    k.cyl((-0.48, 0.48), (-0.48, 0.48), (0.58, 0.7), None, material)
    k.cyl((-0.48, 0.48), (-0.48, 0.48), (0.7, 0.86), None, material, taper=0.42)
    k.cyl((-0.24, 0.24), (-0.24, 0.24), (0.86, 1.0), cap)


@shape("jar")
def jar(k: Kit) -> None:
    """Content seen through glass, a label, a metal or dark lid; plain jars and canisters stand open."""
    x, y, z = k.size
    if k.category.container:
        r, floor = 0.97, 0.012
        ring(k, x / 2, y / 2, (floor, z * r), 0.005)
        k.cyl((-x * 0.48, x * 0.48), (-y * 0.48, y * 0.48), (0, floor), shade(k.color, 0.8))
        for_lid = GREY if k.name == "canister" else (214, 176, 80)
        ring(k, x / 2, y / 2, (z * r, z), 0.007, for_lid, Material.METAL)
        k.parts = k.parts[:9] + [p for i, p in enumerate(k.parts[9:]) if i % 2 == 0]
        round_space(k, x / 2 - 0.012, y / 2 - 0.012, floor, z)
        return
    k.unit()
    lid = {"honey": GOLD, "jelly": RED, "peanut": (60, 110, 180), "coffee": BLACK, "sugar": (190, 60, 60)}
    top = next((color for word, color in lid.items() if k.has(word)), SILVER)
    k.cyl((-0.48, 0.48), (-0.48, 0.48), (0, 0.76), None, GLASS)
    k.cyl((-0.5, 0.5), (-0.5, 0.5), (0.22, 0.56), label_color(k), Material.PAPER)
    k.cyl((-0.46, 0.46), (-0.46, 0.46), (0.76, 0.82), GLASSY, GLASS)
    k.cyl((-0.5, 0.5), (-0.5, 0.5), (0.82, 1.0), top, Material.METAL)
    if k.has("bean_jar", "jelly_bean", "jimmies", "noodle"):
        bits = [(70, 44, 30)] * 4 if k.has("coffee") else [RED, YELLOW, GREEN, (150, 80, 170)]
        for i, color in enumerate(bits):
            k.ball((0.3, 0.5), (-0.4 + 0.2 * i, -0.22 + 0.2 * i), (0.06 + 0.02 * (i % 2), 0.18 + 0.02 * (i % 2)), color)
        for i, color in enumerate(bits[:3]):
            k.ball((0.3, 0.5), (-0.3 + 0.22 * i, -0.12 + 0.22 * i), (0.6, 0.72), color)


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


@shape("spray_bottle")
def spray_bottle(k: Kit) -> None:
    """A bottle with a trigger head pointing to the front."""
    k.unit()
    k.cyl((-0.42, 0.34), (-0.5, 0.5), (0, 0.52))
    k.box((0.2, 0.36), (-0.3, 0.3), (0.12, 0.44), label_color(k), Material.PAPER)
    k.cyl((-0.42, 0.34), (-0.5, 0.5), (0.52, 0.7), None, None, taper=0.4)
    head = WHITE if sum(k.color) < 560 else RED if k.color[0] > k.color[2] else (40, 100, 180)
    k.cyl((-0.18, 0.1), (-0.18, 0.18), (0.7, 0.82), head)
    k.box((-0.34, 0.4), (-0.2, 0.2), (0.82, 0.96), head)
    k.box((-0.2, 0.2), (-0.16, 0.16), (0.94, 1.0), head)
    k.box((0.4, 0.5), (-0.1, 0.1), (0.86, 0.94), DARK)
    k.rod((0.14, 0, 0.82), (0.28, 0, 0.66), 0.014, RED)


@shape("spray_can")
def spray_can(k: Kit) -> None:
    """An aerosol can with a cap."""
    k.unit()
    k.cyl((-0.5, 0.5), (-0.5, 0.5), (0, 0.76), None, Material.METAL)
    k.cyl((-0.505, 0.505), (-0.505, 0.505), (0.28, 0.56), label_color(k), Material.PAPER)
    k.cyl((-0.5, 0.5), (-0.5, 0.5), (0.76, 0.84), SILVER, Material.METAL, taper=0.7)
    k.cyl((-0.34, 0.34), (-0.34, 0.34), (0.84, 1.0), WHITE if k.name != "spray_paint_can" else k.color)


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
