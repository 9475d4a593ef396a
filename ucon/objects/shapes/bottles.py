"""Bottles, jars and sprays; colour and label show what is in them."""

from __future__ import annotations

from ucon.objects.kit import Kit, shape
from ucon.objects.model import Material
from ucon.objects.palette import (
    BLACK,
    BLUE,
    DARK,
    DARKGREEN,
    GLASSY,
    GOLD,
    GREEN,
    GREY,
    PAPER,
    RED,
    RGB,
    SILVER,
    WHITE,
    YELLOW,
    shade,
)
from ucon.objects.shapes.generic import ring
from ucon.objects.shapes.hollow import round_space

GLASS = Material.GLASS


def label_color(k: Kit) -> RGB:
    """A label colour that stands out from the content; equal names and contents have equal labels."""
    palette = (PAPER, (232, 214, 120), (206, 60, 52), (70, 130, 80), (62, 104, 176), (240, 240, 236))
    pick = palette[sum(map(ord, k.name)) % len(palette)]
    contrast = sum(abs(a - b) for a, b in zip(pick, k.color, strict=True))
    if contrast > 150:
        return pick
    return PAPER if sum(k.color) < 480 else (62, 104, 176)


@shape("bottle")
def bottle(k: Kit) -> None:
    """Body, label band, shoulder, neck and cap, with proportions that depend on the content."""
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
