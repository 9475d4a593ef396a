"""Sinks, toilets, tubs, showers and things that hang on bathroom walls."""

from __future__ import annotations

from ucon.objects.kit import Kit, shape
from ucon.objects.model import Material
from ucon.objects.palette import BLUE, DARK, GREY, SILVER, WHITE, shade
from ucon.objects.shapes.cabinets import hang_below
from ucon.objects.shapes.casework import tub
from ucon.objects.shapes.generic import OPEN_TOP_HEADROOM

WATER = (150, 196, 214)
TILE = Material.TILE


@shape("sink")
def sink(k: Kit) -> None:
    """A basin on a slim pedestal with a tap; free floor below its front."""
    x, y, z = k.size
    if k.name == "commercial_kitchen_sink":
        _steel_sink(k)
        return
    rim = z - 0.13
    low = rim - 0.2
    ix, iy = tub(k, (-x / 2 + 0.1, x / 2), (-y / 2, y / 2), (low, rim), 0.05, 0.06, inside=shade(k.color, 0.82))
    k.box((-x / 2, -x / 2 + 0.1), (-y / 2, y / 2), (low, rim))
    k.box((-x / 2 + 0.02, -x / 2 + 0.16), (-0.08, 0.08), (0, low), shade(k.color, 0.92))
    k.cyl((-x / 2 + 0.03, -x / 2 + 0.07), (-0.02, 0.02), (rim, z - 0.02), SILVER, Material.METAL)
    k.box((-x / 2 + 0.03, -x / 2 + 0.2), (-0.015, 0.015), (z - 0.03, z), SILVER, Material.METAL)
    for s in (-1, 1):
        k.cyl(
            (-x / 2 + 0.03, -x / 2 + 0.07), (s * 0.1 - 0.02, s * 0.1 + 0.02), (rim, rim + 0.05), SILVER, Material.METAL
        )
    k.cyl((0.02, 0.08), (-0.03, 0.03), (low + 0.06, low + 0.064), GREY, Material.METAL)
    k.space(ix, iy, (low + 0.064, low + 0.064 + 0.14 * OPEN_TOP_HEADROOM))
    edge = (y / 2 - 0.13, y / 2 - 0.005)
    k.surface((-x / 2 + 0.01, -x / 2 + 0.1), edge, rim, 0.5)
    k.surface((-x / 2 + 0.01, -x / 2 + 0.1), (-edge[1], -edge[0]), rim, 0.5)
    k.below((-x / 2 + 0.17, x / 2), (-y / 2 + 0.01, y / 2 - 0.01), low)


def _steel_sink(k: Kit) -> None:
    x, y, z = k.size
    rim = 0.62 * z
    low = rim - 0.24
    bowl = (-y / 2 + 0.05, y * 0.12)
    k.box((-x / 2 + 0.06, -x / 2 + 0.1), bowl, (rim - 0.04, rim), SILVER, Material.METAL)
    ix, iy = tub(k, (-x / 2 + 0.1, x / 2 - 0.04), bowl, (low, rim), 0.02, 0.03, SILVER, shade(SILVER, 0.75))
    k.box((-x / 2, x / 2), (bowl[1], y / 2), (rim - 0.04, rim), SILVER, Material.METAL)
    k.box((-x / 2, -x / 2 + 0.06), (-y / 2, y / 2), (rim - 0.04, rim + 0.12), SILVER, Material.METAL)
    for fx in (-x / 2 + 0.02, x / 2 - 0.06):
        for fy in (-y / 2 + 0.02, y / 2 - 0.06):
            k.box((fx, fx + 0.04), (fy, fy + 0.04), (0, rim - 0.04), GREY, Material.METAL)
    k.box((x / 2 - 0.04, x / 2), (-y / 2, bowl[1]), (rim - 0.05, rim), SILVER, Material.METAL)
    tap = -y * 0.17
    k.box((-x / 2 + 0.06, -x / 2 + 0.1), (tap - 0.02, tap + 0.02), (rim, z), SILVER, Material.METAL)
    k.box((-x / 2 + 0.1, -0.04), (tap - 0.015, tap + 0.015), (z - 0.04, z), SILVER, Material.METAL)
    k.box((-0.08, -0.04), (tap - 0.015, tap + 0.015), (rim + 0.2, z - 0.04), SILVER, Material.METAL)
    k.space(ix, iy, (low + 0.03, low + 0.03 + 0.21 * OPEN_TOP_HEADROOM))
    k.surface((-x / 2 + 0.08, x / 2 - 0.02), (bowl[1] + 0.02, y / 2 - 0.02), rim)
    k.below((-x / 2 + 0.1, x / 2 - 0.08), (-y / 2 + 0.1, y / 2 - 0.1), low)


@shape("toilet")
def toilet(k: Kit) -> None:
    """Cistern at the back, bowl in front, raised seat ring."""
    x, y, z = k.size
    if k.name == "bidet":
        k.unit()
        k.box((-0.5, -0.3), (-0.4, 0.4), (0, 0.86))
        k.cyl((-0.4, 0.5), (-0.5, 0.5), (0.3, 0.86))
        k.cyl((-0.3, 0.3), (-0.35, 0.35), (0, 0.3), shade(k.color, 0.92))
        k.cyl((-0.22, 0.4), (-0.34, 0.34), (0.86, 0.88), WATER)
        k.box((-0.45, -0.35), (-0.08, 0.08), (0.86, 1.0), SILVER, Material.METAL)
        k.surface((-x * 0.48, -x * 0.36), (-y * 0.35, -y * 0.12), z * 0.86)
        return
    seat = 0.42
    k.box((-x / 2, -x / 2 + 0.2), (-y / 2, y / 2), (seat - 0.02, z - 0.03))
    k.box((-x / 2, -x / 2 + 0.21), (-y / 2, y / 2), (z - 0.03, z), shade(k.color, 0.95))
    k.cyl((-x / 2 + 0.16, x / 2), (-y * 0.46, y * 0.46), (0.2, seat - 0.02))
    k.cyl((-x / 2 + 0.16, x / 2), (-y * 0.47, y * 0.47), (seat - 0.02, seat), shade(k.color, 0.9))
    k.cyl((-x / 2 + 0.24, x / 2 - 0.06), (-y * 0.3, y * 0.3), (seat, seat + 0.004), WATER, TILE)
    k.box((-x / 2 + 0.02, x * 0.2), (-y * 0.28, y * 0.28), (0, 0.2), shade(k.color, 0.92))
    k.box((-x / 2 + 0.05, -x / 2 + 0.2), (-y * 0.32, y * 0.32), (0.2, seat - 0.02))
    k.box((-x / 2 + 0.2, -x / 2 + 0.215), (y * 0.25, y * 0.42), (z - 0.11, z - 0.09), SILVER, Material.METAL)
    k.surface((-x / 2 + 0.01, -x / 2 + 0.2), (-y / 2 + 0.01, y / 2 - 0.01), z)


@shape("urinal")
def urinal(k: Kit) -> None:
    """A bowl on the wall."""
    k.unit()
    k.box((-0.5, -0.3), (-0.5, 0.5), (0, 1))
    k.cyl((-0.4, 0.5), (-0.5, 0.5), (0, 0.3), None, None, taper=1.0)
    k.cyl((-0.3, 0.38), (-0.38, 0.38), (0.3, 0.31), WATER)
    for s in (-1, 1):
        c, d = sorted((s * 0.5, s * 0.4))
        k.box((-0.3, 0.0), (c, d), (0.3, 1))


@shape("bathtub")
def bathtub(k: Kit) -> None:
    """A tub with thick rims; things can lie on its floor."""
    x, y, z = k.size
    rim, floor = min(0.11, 0.12 * y), 0.3 * z
    hot = k.name == "hot_tub"
    ix, iy = tub(k, (-x / 2, x / 2), (-y / 2, y / 2), (0, z - (0 if hot else 0.09)), rim, floor,
                 (120, 84, 56) if hot else None, WATER if hot else shade(k.color, 0.86))  # fmt: skip
    top = z if hot else z - 0.09
    if not hot:
        k.cyl((x / 2 - 0.08, x / 2 - 0.04), (-0.02, 0.02), (top, z), SILVER, Material.METAL)
        k.box((x / 2 - 0.22, x / 2 - 0.04), (-0.015, 0.015), (z - 0.02, z), SILVER, Material.METAL)
        for s in (-1, 1):
            k.cyl((x / 2 - 0.08, x / 2 - 0.04), (s * 0.12 - 0.02, s * 0.12 + 0.02), (top, top + 0.05), SILVER,
                  Material.METAL)  # fmt: skip
    k.space(ix, iy, (floor, top))
    k.surface((-x / 2 + 0.01, -x / 2 + rim), (-y / 2 + 0.01, y / 2 - 0.01), top)
    for s in (-1, 1):
        c, d = sorted((s * (y / 2 - 0.005), s * (y / 2 - rim)))
        k.surface((-x / 2 + rim, x / 2 - 0.25), (c, d), top)


@shape("swimming_pool")
def swimming_pool(k: Kit) -> None:
    """Water between stone rims."""
    x, y, z = k.size
    rim = 0.25
    ix, iy = tub(k, (-x / 2, x / 2), (-y / 2, y / 2), (0, z), rim, 0.2, (226, 220, 206), (96, 170, 210))
    k.box(ix, iy, (0.2, 0.6 * z), (84, 166, 212), Material.GLASS)
    k.space(ix, iy, (0.6 * z, 1.2 * z))
    for s in (-1, 1):
        c, d = sorted((s * y / 2, s * (y / 2 - rim)))
        k.surface((-x / 2, x / 2), (c, d), z)


@shape("shower_stall", "shower")
def shower_stall(k: Kit) -> None:
    """A tray between two glass walls and the wall of the room, open to the front, with a shower head."""
    x, y, z = k.size
    tray, glass = 0.05, (200, 224, 230)
    k.box((-x / 2, x / 2), (-y / 2, y / 2), (0, tray), WHITE, TILE)
    k.box((-x / 2, -x / 2 + 0.02), (-y / 2, y / 2), (tray, z), (222, 232, 234), TILE)
    k.box((-x / 2 + 0.02, x / 2), (-y / 2, -y / 2 + 0.012), (tray, z), glass, Material.GLASS)
    k.box((-x / 2 + 0.02, x / 2), (y / 2 - 0.012, y / 2), (tray, z), glass, Material.GLASS)
    k.box((x / 2 - 0.015, x / 2), (-y / 2 + 0.012, -y / 2 + 0.04), (tray, z), SILVER, Material.METAL)
    k.box((x / 2 - 0.015, x / 2), (y / 2 - 0.04, y / 2 - 0.012), (tray, z), SILVER, Material.METAL)
    k.box((x / 2 - 0.02, x / 2), (-y / 2 + 0.04, y / 2 - 0.04), (z - 0.04, z), SILVER, Material.METAL)
    k.box((-x / 2 + 0.02, -x / 2 + 0.04), (-0.01, 0.01), (1.0, z * 0.93), SILVER, Material.METAL)
    k.box((-x / 2 + 0.02, -x / 2 + 0.3), (-0.01, 0.01), (z * 0.92, z * 0.93), SILVER, Material.METAL)
    k.cyl((-x / 2 + 0.2, -x / 2 + 0.4), (-0.1, 0.1), (z * 0.9, z * 0.92), SILVER, Material.METAL)
    k.cyl((-0.04, 0.04), (-0.04, 0.04), (tray, tray + 0.004), GREY, Material.METAL)
    inner = (-y / 2 + 0.015, y / 2 - 0.015)
    k.space((-x / 2 + 0.05, x / 2 - 0.03), inner, (tray + 0.004, tray + 0.9))
    k.surface((-x / 2 + 0.05, x / 2 - 0.03), inner, tray + 0.004, 0.9)


@shape("showerhead")
def showerhead(k: Kit) -> None:
    """A riser rail with a rain head."""
    k.unit()
    k.box((-0.5, -0.42), (-0.05, 0.05), (0, 1), SILVER, Material.METAL)
    k.box((-0.5, 0.2), (-0.05, 0.05), (0.97, 1), SILVER, Material.METAL)
    k.cyl((-0.1, 0.5), (-0.5, 0.5), (0.93, 0.965), SILVER, Material.METAL)
    k.box((-0.5, -0.3), (-0.4, 0.4), (0.1, 0.16), SILVER, Material.METAL)


@shape("towel_rack")
def towel_rack(k: Kit) -> None:
    """A rail on two brackets with a towel over it."""
    x, y, z = k.size
    for s in (-1, 1):
        c, d = sorted((s * y / 2, s * (y / 2 - 0.02)))
        k.box((-x / 2, x / 2), (c, d), (0.3 * z, 0.8 * z), SILVER, Material.METAL)
    k.box((x / 2 - 0.02, x / 2), (-y / 2, y / 2), (0.45 * z, 0.7 * z), SILVER, Material.METAL)
    k.box((-x / 2, x / 2), (-y * 0.34, y * 0.2), (0.7 * z, z), (120, 170, 180), Material.FABRIC)
    k.box((x / 2 - 0.022, x / 2), (-y * 0.34, y * 0.2), (0, 0.7 * z), (120, 170, 180), Material.FABRIC)
    k.surface((-x / 2, x / 2), (-y * 0.34, y * 0.2), z, 0.3)
    hang_below(k, 0.3)


@shape("wall_dispenser", "soap_dispenser")
def dispenser(k: Kit) -> None:
    """A rounded box with a dark window and a nozzle; the tabletop dispenser is a bottle with a pump."""
    k.unit()
    if k.name == "soap_dispenser":
        k.cyl((-0.36, 0.5), (-0.5, 0.5), (0, 0.62), WHITE)
        k.cyl((-0.2, 0.34), (-0.3, 0.3), (0.62, 0.72), SILVER, Material.METAL)
        k.cyl((0.0, 0.14), (-0.1, 0.1), (0.72, 0.92), SILVER, Material.METAL)
        k.box((-0.5, 0.2), (-0.12, 0.12), (0.9, 1.0), SILVER, Material.METAL)
        return
    k.box((-0.5, 0.34), (-0.5, 0.5), (0.12, 1))
    k.box((-0.5, 0.5), (-0.42, 0.42), (0.22, 0.9), shade(k.color, 1.2))
    k.box((-0.3, 0.3), (-0.2, 0.2), (0, 0.14), DARK)
    k.box((0.48, 0.52), (-0.1, 0.1), (0.5, 0.75), BLUE)
    if k.name == "toilet_paper_dispenser":
        k.cyl((-0.2, 0.3), (-0.3, 0.3), (0, 0.2), WHITE, Material.PAPER, axis="y")
