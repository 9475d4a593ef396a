"""Small kitchen machines, kettles and the vacuum cleaner."""

from __future__ import annotations

from ucon.objects.kit import Kit, shape
from ucon.objects.model import Material
from ucon.objects.palette import BLACK, DARK, GREY, RED, SILVER, WHITE, YELLOW, shade

Span = tuple[float, float]


@shape("coffee_maker")
def coffee_maker(k: Kit) -> None:
    """A C-shaped machine with a glass pot of coffee."""
    k.unit()
    k.box((-0.5, 0.5), (-0.5, 0.5), (0, 0.1), k.color)
    k.box((-0.5, -0.1), (-0.5, 0.5), (0.1, 1), k.color)
    k.box((-0.1, 0.5), (-0.5, 0.5), (0.72, 1), shade(k.color, 1.2))
    k.cyl((-0.08, 0.44), (-0.34, 0.34), (0.1, 0.5), (70, 40, 24), Material.GLASS)
    k.cyl((0.0, 0.36), (-0.24, 0.24), (0.5, 0.6), BLACK)
    k.box((0.44, 0.5), (-0.06, 0.06), (0.2, 0.5), BLACK)
    k.box((0.47, 0.5), (-0.3, 0.3), (0.78, 0.86), RED)


@shape("toaster")
def toaster(k: Kit) -> None:
    """Two dark slots with toast, a lever."""
    k.unit()
    k.box((-0.46, 0.46), (-0.5, 0.5), (0.04, 0.92), SILVER, Material.METAL)
    k.box((-0.5, 0.5), (-0.46, 0.46), (0, 0.12), BLACK)
    for y0 in (-0.28, 0.1):
        k.box((-0.36, 0.36), (y0, y0 + 0.18), (0.92, 0.93), BLACK)
        k.box((-0.3, 0.3), (y0 + 0.04, y0 + 0.14), (0.9, 1.0), (196, 140, 80))
    k.box((0.46, 0.5), (-0.1, 0.1), (0.6, 0.7), BLACK)


@shape("blender")
def blender(k: Kit) -> None:
    """A clear jar on a base."""
    k.unit()
    k.cyl((-0.5, 0.5), (-0.5, 0.5), (0, 0.3), DARK, taper=0.75)
    k.cyl((-0.4, 0.4), (-0.4, 0.4), (0.3, 0.36), SILVER, Material.METAL)
    k.cyl((-0.42, 0.42), (-0.42, 0.42), (0.36, 0.9), (190, 216, 224), Material.GLASS, taper=1.12)
    k.cyl((-0.44, 0.44), (-0.44, 0.44), (0.9, 1.0), BLACK)
    k.box((0.4, 0.5), (-0.06, 0.06), (0.45, 0.85), BLACK)
    k.cyl((0.36, 0.48), (-0.1, 0.1), (0.08, 0.2), RED, axis="x")


@shape("electric_mixer")
def electric_mixer(k: Kit) -> None:
    """A stand mixer: foot, arm and steel bowl, along y."""
    k.unit()
    k.box((-0.42, 0.42), (-0.5, 0.5), (0, 0.08))
    k.box((-0.3, 0.3), (-0.5, -0.22), (0.08, 0.66))
    k.ball((-0.42, 0.42), (-0.5, 0.5), (0.6, 1.0))
    k.cyl((-0.5, 0.5), (-0.12, 0.46), (0.08, 0.46), SILVER, Material.METAL, taper=1.0)
    k.cyl((-0.08, 0.08), (0.12, 0.24), (0.4, 0.66), SILVER, Material.METAL)


@shape("food_processor")
def food_processor(k: Kit) -> None:
    """A clear bowl on a wide base with a feed tube."""
    k.unit()
    k.box((-0.5, 0.5), (-0.5, 0.5), (0, 0.32))
    k.cyl((-0.44, 0.44), (-0.44, 0.44), (0.32, 0.74), (196, 214, 220), Material.GLASS)
    k.cyl((-0.46, 0.46), (-0.46, 0.46), (0.74, 0.8), GREY)
    k.cyl((-0.3, 0.1), (-0.2, 0.2), (0.8, 1.0), (196, 214, 220), Material.GLASS)
    k.box((0.49, 0.52), (-0.2, 0.2), (0.1, 0.22), DARK)


@shape("food_slicer")
def food_slicer(k: Kit) -> None:
    """A slanted steel body with a round blade and a sliding tray."""
    k.unit()
    k.box((-0.5, 0.5), (-0.5, 0.5), (0, 0.2), SILVER, Material.METAL)
    k.box((-0.3, 0.2), (-0.45, -0.1), (0.2, 0.7), GREY, Material.METAL)
    k.cyl((-0.3, 0.3), (-0.05, 0.02), (0.2, 1.0), (220, 222, 226), Material.METAL, axis="y")
    k.box((-0.35, 0.4), (0.1, 0.5), (0.36, 0.46), SILVER, Material.METAL)
    k.box((0.3, 0.4), (0.3, 0.4), (0.46, 0.7), BLACK)


@shape("popcorn_machine")
def popcorn_machine(k: Kit) -> None:
    """A red cart top with glass sides full of popcorn."""
    k.unit()
    k.box((-0.5, 0.5), (-0.5, 0.5), (0, 0.16), RED)
    k.box((-0.44, 0.44), (-0.44, 0.44), (0.16, 0.42), (244, 226, 160))
    k.box((-0.44, 0.44), (-0.44, 0.44), (0.42, 0.8), (206, 226, 232), Material.GLASS)
    for fx in (-0.46, 0.46):
        for fy in (-0.46, 0.46):
            k.box((fx - 0.04, fx + 0.04), (fy - 0.04, fy + 0.04), (0.16, 0.8), YELLOW)
    k.box((-0.5, 0.5), (-0.5, 0.5), (0.8, 0.92), RED)
    k.wedge((-0.4, 0.0), (-0.4, 0.4), (0.92, 1.0), WHITE)
    k.wedge((0.0, 0.4), (-0.4, 0.4), (0.92, 1.0), WHITE, flip=True)


@shape("kettle")
def kettle(k: Kit) -> None:
    """A stove kettle or an electric jug: belly, spout to the front, handle."""
    k.unit()
    electric = k.name == "electric_kettle"
    belly = 0.78 if electric else 0.62
    if electric:
        k.cyl((-0.34, 0.34), (-0.5, 0.5), (0, 0.08), BLACK)
        k.cyl((-0.3, 0.3), (-0.46, 0.46), (0.08, belly), SILVER, Material.METAL, taper=0.78)
        k.cyl((-0.2, 0.2), (-0.3, 0.3), (belly, 0.9), BLACK)
        k.path([(-0.22, 0, 0.86), (-0.48, 0, 0.8), (-0.48, 0, 0.3), (-0.3, 0, 0.2)], 0.022, BLACK)
        k.rod((0.2, 0, 0.62), (0.42, 0, 0.78), 0.04, SILVER, Material.METAL)
    else:
        k.ball((-0.42, 0.34), (-0.5, 0.5), (-0.06, belly), SILVER, Material.METAL)
        k.cyl((-0.34, 0.26), (-0.4, 0.4), (0, 0.1), SILVER, Material.METAL)
        k.ball((-0.1, 0.04), (-0.08, 0.08), (belly - 0.05, belly + 0.08), BLACK)
        k.rod((0.22, 0, 0.3), (0.46, 0, 0.6), 0.03, SILVER, Material.METAL)
        k.path([(-0.34, 0, 0.5), (-0.26, 0, 0.9), (0.16, 0, 0.98), (0.26, 0, 0.5)], 0.016, BLACK)


@shape("french_press")
def french_press(k: Kit) -> None:
    """A glass beaker of coffee with a plunger and a handle."""
    k.unit()
    k.cyl((-0.32, 0.32), (-0.5, 0.5), (0.05, 0.5), (60, 38, 24), Material.GLASS)
    k.cyl((-0.32, 0.32), (-0.5, 0.5), (0.5, 0.8), (206, 222, 228), Material.GLASS)
    k.cyl((-0.34, 0.34), (-0.5, 0.5), (0.8, 0.86), BLACK)
    k.cyl((-0.36, 0.36), (-0.5, 0.5), (0, 0.05), BLACK)
    k.cyl((-0.02, 0.02), (-0.03, 0.03), (0.86, 0.95), SILVER)
    k.ball((-0.08, 0.08), (-0.1, 0.1), (0.92, 1.0), BLACK)
    k.path([(0.32, 0, 0.75), (0.5, 0, 0.72), (0.5, 0, 0.2), (0.32, 0, 0.15)], 0.016, BLACK)


@shape("vacuum")
def vacuum(k: Kit) -> None:
    """An upright vacuum cleaner: floor head, canister, long handle."""
    k.unit()
    k.box((0.0, 0.5), (-0.5, 0.5), (0, 0.12), DARK)
    k.rod((0.1, 0, 0.08), (-0.12, 0, 0.62), (0.16, 0.2))
    k.cyl((-0.1, 0.25), (-0.26, 0.26), (0.18, 0.5), (206, 216, 222), Material.GLASS)
    k.rod((-0.12, 0, 0.55), (-0.4, 0, 0.94), 0.03, DARK)
    k.rod((-0.42, 0, 0.92), (-0.3, 0, 1.0), 0.04, BLACK)
    for y0 in (-0.46, 0.36):
        k.cyl((-0.06, 0.2), (y0, y0 + 0.1), (0, 0.12), BLACK, axis="y")
