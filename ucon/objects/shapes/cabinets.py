"""Cabinets, drawers, wardrobes, chests and boxes that open."""

from __future__ import annotations

from ucon.objects.kit import Kit, shape
from ucon.objects.model import Material
from ucon.objects.palette import BLACK, DARK, GREY, SILVER, WHITE, shade
from ucon.objects.shapes.casework import BOARD, HANDLE, Span, carcass, drawer, drop_door, leaves, lid, seen_depth, tub

FRONT = BOARD + HANDLE
GAP_LID = 0.005


def shelved(k: Kit, x: Span, y: Span, z: Span, count: int, joints: tuple[int, ...], depth_frac: float) -> None:
    """Boards that split an interior into ``count`` compartments; those above the floor end before the front."""
    height = (z[1] - z[0] - (count - 1) * BOARD) / count
    front = x[1] - 0.016
    edge = x[0] + (front - x[0]) * depth_frac
    for i in range(count):
        low = z[0] + i * (height + BOARD)
        if i:
            k.box((x[0], edge), y, (low - BOARD, low), shade(k.color, 1.2), k.material)
        ground = k.category.bottom_z_m
        setback = 0.0 if i == count - 1 else front - edge
        back = max(x[0], front - seen_depth(ground + low, ground + low + height, setback))
        k.space((back, edge if i else front), y, (low, low + height), opened_by=joints)


def _base_cabinet(k: Kit, plinth: float, shelves: int) -> None:
    x, y, z = k.size
    slab = 0.025
    front = x / 2
    back = front - FRONT
    k.box((-x / 2, back - 0.03), (-y / 2 + 0.02, y / 2 - 0.02), (0, plinth), shade(k.color, 0.45))
    inner = carcass(k, (-x / 2, back), (-y / 2, y / 2), (plinth, z - slab))
    joints = leaves(k, front, (-y / 2 + 0.002, y / 2 - 0.002), (plinth, z - slab - 0.002), shade(k.color, 1.12))
    shelved(k, *inner, count=shelves, joints=joints, depth_frac=0.72)
    k.box((-x / 2, front), (-y / 2, y / 2), (z - slab, z), shade(k.color, 0.8) if k.has("no_top") else k.color)
    k.top_surface(0.01)


@shape("bottom_cabinet")
def bottom_cabinet(k: Kit) -> None:
    """A sideboard: doors, one shelf, a top."""
    _base_cabinet(k, 0.06, 2 if k.size[2] > 0.55 else 1)


@shape("bottom_cabinet_no_top", "metal_bottom_cabinet")
def kitchen_unit(k: Kit) -> None:
    """A kitchen base unit on a recessed plinth."""
    _base_cabinet(k, 0.1, 2)


@shape("top_cabinet")
def top_cabinet(k: Kit) -> None:
    """A wall cabinet above the counter, with one tall space: at eye height, a shelf would hide what lies on it."""
    x, y, z = k.size
    front = x / 2
    inner = carcass(k, (-x / 2, front - FRONT), (-y / 2, y / 2), (0, z))
    joints = leaves(k, front, (-y / 2 + 0.002, y / 2 - 0.002), (0, z), shade(k.color, 1.12))
    shelved(k, *inner, count=1, joints=joints, depth_frac=1.0)
    k.top_surface(0.01, clearance=0.4)
    hang_below(k, 0.35)


def hang_below(k: Kit, depth: float) -> None:
    """The space under an object on a wall, down to the floor of the room."""
    x, y, _ = k.size
    drop = k.category.bottom_z_m
    if drop > 0.1:
        k.below((-x / 2, -x / 2 + max(depth, x)), (-y / 2, y / 2), -0.02, -drop)


@shape("wardrobe")
def wardrobe(k: Kit) -> None:
    """Hanging space on one side, shelves on the other; the divider is behind the seam of the doors."""
    x, y, z = k.size
    front, plinth = x / 2, 0.08
    back = front - FRONT
    k.box((-x / 2, back - 0.03), (-y / 2 + 0.03, y / 2 - 0.03), (0, plinth), shade(k.color, 0.5))
    ix, iy, iz = carcass(k, (-x / 2, back), (-y / 2, y / 2), (plinth, z))
    joints = leaves(k, front, (-y / 2 + 0.002, y / 2 - 0.002), (plinth, z), shade(k.color, 1.1))
    middle = 0.0
    clear = (ix[0], ix[1] - 0.016)
    k.box(clear, (middle - BOARD / 2, middle + BOARD / 2), iz)
    left, right = (middle + BOARD / 2, iy[1]), (iy[0], middle - BOARD / 2)
    rail = iz[1] - 0.12
    k.cyl((-0.012, 0.012), left, (rail - 0.012, rail + 0.012), SILVER, Material.METAL, axis="y")
    k.space(clear, left, (iz[0], rail - 0.05), opened_by=(joints[0],))
    levels = [iz[0], iz[0] + 0.45, iz[0] + 0.9]
    board = (clear[0], clear[1] - 0.14)
    for low, high in zip(levels, [*levels[1:], min(iz[1], iz[0] + 1.35)], strict=True):
        if low > iz[0]:
            k.box(board, right, (low - BOARD, low), shade(k.color, 1.2))
        span = board if low > iz[0] else clear
        deepest = clear[1] - seen_depth(low, high - BOARD, clear[1] - board[1])
        k.space((max(span[0], deepest), span[1]), right, (low, high - BOARD), opened_by=(joints[-1],))
    if iz[1] - levels[-1] > 0.5:
        k.box(board, right, (levels[-1] + 0.43, levels[-1] + 0.45), shade(k.color, 1.2))
    k.top_surface(0.02, clearance=0.3)


@shape("drawer_unit")
def drawer_unit(k: Kit) -> None:
    """A chest of drawers. Lower drawers come out further, so that open upper ones do not hide them."""
    x, y, z = k.size
    front, plinth, slab = x / 2, 0.05, 0.025
    back = front - FRONT
    count = 2 if z < 0.55 else 3 if z < 1.1 else 4
    k.box((-x / 2, back - 0.03), (-y / 2 + 0.02, y / 2 - 0.02), (0, plinth), shade(k.color, 0.45))
    ix, _, _ = carcass(k, (-x / 2, back), (-y / 2, y / 2), (plinth, z - slab))
    k.box((-x / 2, front), (-y / 2, y / 2), (z - slab, z))
    height = (z - slab - plinth) / count
    for i in range(count):
        low = plinth + i * height
        travel = 0.8 * x * (count - i) / count
        y_span = (-y / 2 + 0.002, y / 2 - 0.002)
        body = (ix[0] + 0.01, ix[1])
        above = 0.8 * x * (count - i - 1) / count
        drawer(k, body, front, y_span, (low, low + height - 0.001), travel, shade(k.color, (1.12, 0.98)[i % 2]), above)
        if i:
            k.box(
                (ix[1] - BOARD, ix[1]), (-y / 2 + BOARD, y / 2 - BOARD), (low - 0.01, low + 0.01), shade(k.color, 0.7)
            )
    k.top_surface(0.01)


@shape("chest_lidded")
def chest(k: Kit) -> None:
    """A blanket chest: heavy body, lid hinged at the back edge."""
    x, y, z = k.size
    body = z - 0.04
    ix, iy = tub(k, (-x / 2 + 0.012, x / 2 - 0.012), (-y / 2 + 0.012, y / 2 - 0.012), (0, body), 0.025, 0.09,
                 inside=shade(k.color, 1.25))  # fmt: skip
    k.box((-x / 2, x / 2), (-y / 2, y / 2), (0, 0.06), shade(k.color, 0.75))
    joint = lid(k, (-x / 2, x / 2), (-y / 2, y / 2), (body, z), shade(k.color, 0.85))
    k.box((x / 2 - 0.012, x / 2 - 0.002), (-0.04, 0.04), (body - 0.09, body - 0.01), SILVER, Material.METAL)
    k.space(ix, iy, (0.09, body - GAP_LID), opened_by=(joint,))
    k.surface((-x / 2 + 0.02, x / 2 - 0.02), (-y / 2 + 0.02, y / 2 - 0.02), z, 1.0, link=joint)


@shape("box_open")
def flap_box(k: Kit) -> None:
    """A cardboard box with two flaps."""
    x, y, z = k.size
    t, top = 0.008, z - 0.012
    ix, iy = tub(k, (-x / 2, x / 2), (-y / 2, y / 2), (0, top), t, t, inside=shade(k.color, 0.85))
    left = k.hinge((0, y / 2, z), (-1.0, 0.0, 0.0), 1.65)
    right = k.hinge((0, -y / 2, z), (1.0, 0.0, 0.0), 1.65)
    k.box((-x / 2, x / 2), (0, y / 2), (top, z), shade(k.color, 1.1), link=left)
    k.box((-x / 2, x / 2), (-y / 2, 0), (top, z), shade(k.color, 1.04), link=right)
    # The strip below the seam is carried by one flap.
    k.box((ix[0] + 0.01, ix[1] - 0.01), (-0.02, 0.02), (top - 0.006, top), shade(k.color, 0.8), link=left)
    k.box((x / 2 - 0.003, x / 2), (-y * 0.25, y * 0.2), (z * 0.35, z * 0.6), WHITE, Material.PAPER)
    k.space(ix, iy, (t, top - 0.012), opened_by=(left, right))
    k.surface((-x / 2 + 0.01, x / 2 - 0.01), (-y / 2 + 0.01, y / 2 - 0.01), z, 1.0, link=left)


@shape("storage_box")
def storage_box(k: Kit) -> None:
    """A plastic box with a lid and grips at both ends."""
    x, y, z = k.size
    body = z - 0.022
    wall = 0.008
    ix, iy = tub(k, (-x / 2 + 0.012, x / 2 - 0.012), (-y / 2 + 0.012, y / 2 - 0.012), (0, body), wall, wall,
                 inside=shade(k.color, 0.9))  # fmt: skip
    joint = lid(k, (-x / 2, x / 2), (-y / 2, y / 2), (body, z), shade(k.color, 0.62))
    for side in (-1, 1):
        edge = side * (y / 2 - 0.012)
        span = (edge, edge + side * 0.012)
        k.box((-0.06, 0.06), (min(span), max(span)), (body - 0.06, body - 0.03), shade(k.color, 0.62))
    k.space(ix, iy, (wall, body - GAP_LID), opened_by=(joint,))
    k.surface((-x / 2 + 0.01, x / 2 - 0.01), (-y / 2 + 0.01, y / 2 - 0.01), z, 1.0, link=joint)


@shape("suitcase")
def suitcase(k: Kit) -> None:
    """A suitcase lying flat; its upper shell is hinged at the back edge."""
    x, y, z = k.size
    split, wall = z - 0.035, 0.012
    x_span, y_span = (-x / 2 + 0.002, x / 2 - 0.025), (-y / 2, y / 2)
    ix, iy = tub(k, x_span, y_span, (0.012, split), wall, wall, inside=shade(k.color, 1.45))
    joint = lid(k, x_span, y_span, (split, z), shade(k.color, 0.85))
    for y0 in (-y * 0.3, y * 0.22):
        k.box((x_span[1], x_span[1] + 0.006), (y0, y0 + 0.04), (0.02, split), BLACK)
    k.box((x_span[1], x / 2), (-0.08, 0.08), (z * 0.5, z * 0.5 + 0.025), BLACK)
    for y0 in (-y / 2 + 0.03, y / 2 - 0.07):
        k.box((-x / 2, -x / 2 + 0.04), (y0, y0 + 0.04), (0, 0.012), BLACK)
        k.box((x / 2 - 0.07, x / 2 - 0.03), (y0, y0 + 0.04), (0, 0.012), BLACK)
    k.space(ix, iy, (0.012 + wall, split - GAP_LID), opened_by=(joint,))
    k.surface((x_span[0] + 0.02, x_span[1] - 0.02), (-y / 2 + 0.02, y / 2 - 0.02), z, 1.0, link=joint)


@shape("case_handled")
def handled_case(k: Kit) -> None:
    """Tool box, tackle box, first aid kit: lid with a handle on top."""
    x, y, z = k.size
    aid = k.has("first_aid")
    grip = 0.0 if aid else min(0.035, 0.2 * z)
    top = z - grip
    split, wall = top - 0.2 * top, 0.008
    ix, iy = tub(k, (-x / 2, x / 2 - 0.008), (-y / 2, y / 2), (0, split), wall, wall, inside=shade(k.color, 0.6))
    joint = lid(
        k,
        (-x / 2, x / 2 - 0.008),
        (-y / 2, y / 2),
        (split, top - 0.003 * aid),
        shade(k.color, 0.88),
        z - top + 0.003 * aid,
    )
    if aid:
        red = (200, 30, 30)
        k.box((-0.045, 0.037), (-0.013, 0.013), (top - 0.003, top), red, link=joint)
        k.box((-0.017, 0.009), (-0.04, 0.04), (top - 0.003, top), red, link=joint)
        k.box((x / 2 - 0.008, x / 2), (-0.03, 0.03), (split - 0.015, split), red)
    else:
        k.box((-0.012, 0.012), (-y * 0.2, y * 0.2), (top + grip * 0.5, z), BLACK, link=joint)
        for side in (-1, 1):
            y0 = side * y * 0.2
            k.box((-0.012, 0.012), (y0 - 0.01, y0 + 0.01), (top, top + grip * 0.5), BLACK, link=joint)
            k.box((x / 2 - 0.008, x / 2), (y0 - 0.02, y0 + 0.02), (split - 0.03, split + 0.01), SILVER, Material.METAL)
    k.space(ix, iy, (wall, split - 0.003), opened_by=(joint,))


@shape("recycling_bin")
def recycling_bin(k: Kit) -> None:
    """A tall bin with a lid. Its floor is raised, so that a person looking in sees what lies there."""
    x, y, z = k.size
    body, wall, floor = z - 0.04, 0.012, 0.4 * z
    ix, iy = tub(k, (-x / 2 + 0.012, x / 2 - 0.012), (-y / 2 + 0.012, y / 2 - 0.012), (0, body), wall, floor,
                 inside=shade(k.color, 0.55))  # fmt: skip
    joint = lid(k, (-x / 2, x / 2), (-y / 2, y / 2), (body, z), shade(k.color, 0.75))
    k.box((x / 2 - 0.012, x / 2 - 0.008), (-0.1, 0.1), (0.45 * z, 0.7 * z), WHITE)
    k.box((x / 2 - 0.012, x / 2 - 0.004), (-0.06, 0.06), (0.5 * z, 0.65 * z), (60, 150, 70))
    k.space(ix, iy, (floor, body - GAP_LID), opened_by=(joint,))
    k.surface((-x / 2 + 0.03, x / 2 - 0.03), (-y / 2 + 0.03, y / 2 - 0.03), z, 1.0, link=joint)


@shape("mailbox")
def mailbox(k: Kit) -> None:
    """A box on a post with a rounded top, a drop door in front and a flag."""
    x, y, z = k.size
    low = 0.7 * z
    flat = z - y / 2
    k.box((-0.05, 0.05), (-0.05, 0.05), (0, low), (120, 86, 56), Material.WOOD)
    front = x / 2
    ix, iy, iz = carcass(k, (-x / 2, front - FRONT), (-y / 2, y / 2), (low, flat), 0.012)
    k.cyl((-x / 2, front - HANDLE), (-y / 2, y / 2), (flat - y / 2, z), axis="x")
    joint = drop_door(k, front, (-y / 2, y / 2), (low, flat), shade(k.color, 1.35), SILVER)
    k.box((0.05, 0.25), (y / 2 - 0.004, y / 2), (flat - 0.03, flat), (200, 40, 40))
    k.space((max(ix[0], ix[1] - 0.4), ix[1] - 0.005), iy, (iz[0], flat - y / 2), opened_by=(joint,))


@shape("cash_register")
def cash_register(k: Kit) -> None:
    """A drawer below, keys and a screen above."""
    x, y, z = k.size
    front, body = x / 2, 0.15
    ix, _, _ = carcass(k, (-x / 2, front - FRONT), (-y / 2, y / 2), (0, body), 0.012)
    drawer(k, (ix[0] + 0.01, ix[1]), front, (-y / 2, y / 2), (0, body), 0.8 * x, shade(k.color, 2 - 0.85))
    k.box((-x / 2, x * 0.3), (-y * 0.45, y * 0.45), (body, 0.45 * z), GREY)
    k.wedge((x * 0.0, x * 0.3), (-y * 0.45, y * 0.45), (0.45 * z, 0.58 * z), DARK, flip=True)
    k.box((-x * 0.15, -x * 0.05), (-0.03, 0.03), (0.45 * z, 0.66 * z), DARK)
    k.box((-x * 0.18, -x * 0.08), (-y * 0.35, y * 0.35), (0.62 * z, z), k.color)
    k.box((-x * 0.08, -x * 0.075), (-y * 0.3, y * 0.3), (0.66 * z, 0.96 * z), (70, 120, 170), Material.GLASS)
    k.box((x * 0.08, x * 0.25), (-y * 0.35, y * 0.35), (0.45 * z, 0.5 * z), WHITE)


@shape("tank_box")
def fish_tank(k: Kit) -> None:
    """An aquarium: pale glass, dark frame, gravel, a lid with the lamp in it."""
    x, y, z = k.size
    body, wall, gravel = z - 0.05, 0.01, 0.05
    water = (150, 196, 214)
    ix, iy = tub(k, (-x / 2 + 0.004, x / 2 - 0.004), (-y / 2 + 0.004, y / 2 - 0.004), (0.02, body), wall, gravel - 0.02,
                 water, (196, 170, 120))  # fmt: skip
    k.box((-x / 2, x / 2), (-y / 2, y / 2), (0, 0.02), BLACK)
    joint = lid(k, (-x / 2, x / 2), (-y / 2, y / 2), (body, z), BLACK)
    for part in range(2):
        y0 = (-0.3 + 0.4 * part) * y
        k.box((x / 2 - 0.004, x / 2 - 0.001), (y0, y0 + 0.06), (z * (0.4 + 0.2 * part), z * (0.5 + 0.2 * part)),
              (240, 130, 40))  # fmt: skip
    k.box((x / 2 - 0.004, x / 2 - 0.002), (y * 0.2, y * 0.24), (0.04, z * 0.5), (50, 130, 60))
    k.space(ix, iy, (gravel, body - GAP_LID), opened_by=(joint,))


@shape("rice_cooker", "electric_cauldron")
def lidded_cooker(k: Kit) -> None:
    """A rounded cooker with a hinged lid."""
    x, y, z = k.size
    body, wall = 0.8 * z, min(0.04, 0.1 * y)
    floor = 0.55 * z if z > 0.6 else 0.12 * z
    ix, iy = tub(k, (-x / 2, x / 2 - 0.01), (-y / 2, y / 2), (0, body), wall, floor, inside=GREY)
    joint = lid(k, (-x / 2, x / 2 - 0.01), (-y / 2, y / 2), (body, 0.94 * z), shade(k.color, 0.85), 0.06 * z)
    k.box((x * 0.1, x * 0.3), (-0.06, 0.06), (0.94 * z, z), DARK, link=joint)
    k.box((x / 2 - 0.01, x / 2), (-y * 0.22, y * 0.22), (0.25 * z, 0.55 * z), DARK)
    k.box((x / 2 - 0.01, x / 2 - 0.002), (-y * 0.1, y * 0.1), (0.42 * z, 0.52 * z), (90, 200, 190))
    k.space(ix, iy, (floor, body - 0.004), opened_by=(joint,))
