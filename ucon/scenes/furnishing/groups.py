"""Groups of furniture as rigid templates: things at a wall, beside a bed, around a table.

Frames: origin on the wall (or the middle, for tables), +x into the room, +y to the left when looking into the room.
"""

from __future__ import annotations

from ucon.objects.catalogue import catalogue
from ucon.objects.model import Box3, Vec3
from ucon.scenes.furnishing.canvas import BODY_Z_M, Group, Piece, piece_box
from ucon.scenes.furnishing.grid import FLAT_M

FRONT_M = 0.75
"""Depth that is kept clear in front of openables, for a door leaf and a person, metres."""
WALL_GAP_M = 0.05
SLAB_M = 0.04
COUNTER_M = 0.90
RUN_DEPTH_M = 0.60
TOP_Z_M = 1.45
SIDE_M = 0.03
"""Gap between neighbours of a counter run, so that doors opened past 90 degrees do not meet, metres."""
CARPET_M = 0.004
UNDER_SLAB = ("bottom_cabinet_no_top", "dishwasher")


def size_of(category: str, size: Vec3 | None = None) -> Vec3:
    """The size of an item: the given one, else the catalogue's; carpets are thin enough to walk on."""
    if size is not None:
        return size
    x, y, z = catalogue()[category].size
    return (x, y, CARPET_M) if category == "carpet" else (x, y, z)


def front_void(box: Box3, depth_m: float = FRONT_M, grow_m: float = 0.0) -> Box3:
    """The space that must stay clear in front of the +x side of a box.

    Args:
        box: metres.
        depth_m: of the space.
        grow_m: by which it is wider on each side.
    """
    low = box[2] if box[2] > 0.9 else FLAT_M
    high = box[5] if box[2] > 0.9 else min(max(box[5], 1.0), BODY_Z_M[1])
    return (box[3], box[1] - grow_m, low, box[3] + depth_m, box[4] + grow_m, high)


def leaf_m(width_m: float) -> float:
    """How far a cabinet door reaches out when open; wide cabinets have two leaves."""
    return (width_m if width_m <= 0.6 else width_m / 2) + 0.03


def front_rect(box: Box3) -> tuple[float, float, float, float]:
    """Rectangle x0, y0, x1, y1 where a person stands to open the +x side of a box."""
    return (box[3] + 0.18, box[1] - 0.125, box[3] + 0.98, box[4] + 0.125)


def single(
    category: str, size: Vec3 | None = None, z: float = 0.0, tint: int = 0, clear_m: float = 0.0, turns: int = 0
) -> Group:
    """A group of one item with its back at the origin.

    Args:
        category: of the catalogue.
        size: metres; None: the catalogue's.
        z: bottom.
        tint: colour variant.
        clear_m: depth that must stay clear in front.
        turns: quarter turns.
    """
    size = size_of(category, size)
    depth = size[0] if turns % 2 == 0 else size[1]
    piece = Piece(category, size, depth / 2, 0.0, z, turns, tint)
    group = Group([piece])
    if catalogue()[category].openable:
        box = (0.0, -size[1] / 2, z, size[0], size[1] / 2, z + size[2])
        group.voids.append(front_void(box))
        group.fronts.append(front_rect(box))
        group.margin_m = 0.12
    elif clear_m > 0:
        wide = size[1] if turns % 2 == 0 else size[0]
        group.voids.append((depth, -wide / 2, FLAT_M, depth + clear_m, wide / 2, BODY_Z_M[1]))
    return group


def bed(
    size: Vec3, left: tuple[str, Vec3] | None, right: tuple[str, Vec3] | None, tint: int, bed_kind: str = "bed"
) -> Group:
    """A bed with its head at the wall and a nightstand at either side.

    Args:
        size: of the bed, metres.
        left: category and size of the left nightstand, or None.
        right: of the right one, or None.
        tint: colour variant.
        bed_kind: category of the bed.
    """
    group = Group([Piece(bed_kind, size, size[0] / 2, 0.0, tint=tint)])
    for side, stand in ((1, left), (-1, right)):
        if stand is None:
            continue
        category, stand_size = stand
        y = side * (size[1] / 2 + 0.06 + stand_size[1] / 2)
        piece = Piece(category, stand_size, stand_size[0] / 2, y, tint=tint)
        group.pieces.append(piece)
        box = (0.0, y - stand_size[1] / 2, 0.0, stand_size[0], y + stand_size[1] / 2, stand_size[2])
        if catalogue()[category].openable:
            group.voids.append(front_void(box, 0.6))
            group.fronts.append(front_rect(box))
    group.voids.append((size[0], -size[1] / 2, FLAT_M, size[0] + 0.5, size[1] / 2, BODY_Z_M[1]))
    return group


def desk(table: str, size: Vec3, chair: str | None, chair_size: Vec3 | None, tint: int) -> Group:
    """A desk at the wall and a chair that faces it.

    Args:
        table: category of the desk.
        size: of the desk, metres.
        chair: category, or None.
        chair_size: metres.
        tint: colour variant.
    """
    group = Group([Piece(table, size, size[0] / 2, 0.0, tint=tint)])
    reach = size[0]
    if chair is not None:
        chair_size = size_of(chair, chair_size)
        group.pieces.append(Piece(chair, chair_size, size[0] + 0.02 + chair_size[0] / 2, 0.0, turns=2, tint=tint))
        reach += chair_size[0] + 0.02
    half = 0.3
    group.voids.append((reach, -half, FLAT_M, reach + 0.4, half, BODY_Z_M[1]))
    return group


def table_with_seats(table: str, size: Vec3, seat: str, n: int, tint: int, around_m: float = 0.0) -> Group:
    """A table in the middle with seats that face it: along the long sides first, then at the heads.

    Args:
        table: category.
        size: of the table, metres.
        seat: category.
        n: number of seats.
        tint: colour variant.
        around_m: clear depth behind the seats.
    """
    sx, sy, _sz = size
    seat_size = size_of(seat)
    group = Group([Piece(table, size, 0.0, 0.0, tint=tint)], margin_m=0.1)
    pitch = seat_size[1] + 0.06
    per_side = max(1, int((sy + 0.02) // pitch))
    spots: list[tuple[float, float, int]] = []
    near = seat_size[0] / 2 + 0.02
    count = min(per_side, (n + 1) // 2)
    for k in range(count):
        y = (k - (count - 1) / 2) * max(pitch, sy / count)
        y = max(-sy / 2 + seat_size[1] / 2, min(sy / 2 - seat_size[1] / 2, y)) if sy >= seat_size[1] else 0.0
        spots += [(sx / 2 + near, y, 2), (-sx / 2 - near, y, 0)]
    spots = spots[: max(2 * count, 0)]
    if n > len(spots):
        spots += [(0.0, sy / 2 + near, 3), (0.0, -sy / 2 - near, 1)]
    for x, y, turns in spots[:n]:
        chair = Piece(seat, seat_size, x, y, turns=turns, tint=tint)
        if not any(
            _overlap(piece_box(chair), piece_box(other)) for other in group.pieces
        ):  # wide seats at small tables
            group.pieces.append(chair)
    if around_m > 0:
        boxes = group.boxes()
        low, high = boxes[:, :2].min(0), boxes[:, 3:5].max(0)
        void = (low[0] - around_m, low[1] - around_m, FLAT_M, high[0] + around_m, high[1] + around_m, BODY_Z_M[1])
        group.voids.append(void)
    return group


def bench_of_desks(table: str, size: Vec3, chair: str, pairs: int, tint: int) -> Group:
    """Desks back to back in two rows, each with a chair, as in open-plan offices.

    Args:
        table: category of the desks.
        size: of a desk, metres.
        chair: category.
        pairs: number of pairs of desks.
        tint: colour variant.
    """
    group = Group([], margin_m=0.3)
    chair_size = size_of(chair)
    for k in range(pairs):
        y = (k - (pairs - 1) / 2) * (size[1] + 0.02)
        for side, turns in ((1, 0), (-1, 2)):
            x = side * (size[0] / 2 + 0.01)
            group.pieces.append(Piece(table, size, x, y, turns=turns, tint=tint))
            seat = side * (size[0] + 0.03 + chair_size[0] / 2)
            group.pieces.append(Piece(chair, chair_size, seat, y, turns=(turns + 2) % 4, tint=tint))
    reach = size[0] + chair_size[0] + 0.04
    half = pairs * (size[1] + 0.02) / 2
    for side in (1, -1):
        x0, x1 = sorted((side * reach, side * (reach + 0.6)))
        group.voids.append((x0, -half, FLAT_M, x1, half, BODY_Z_M[1]))
    return group


def lecture(table: str, size: Vec3, seat: str, n: int, tint: int) -> Group:
    """Rows of four seats that face a desk, with room to walk between and around them.

    Args:
        table: category of the desk.
        size: of the desk, metres.
        seat: category.
        n: number of seats.
        tint: colour variant.
    """
    seat_size = size_of(seat)
    group = Group([Piece(table, size, 0.0, 0.0, turns=2, tint=tint)], margin_m=0.7)
    for k in range(n):
        row, place = divmod(k, 4)
        x = -size[0] / 2 - 1.1 - row * (seat_size[0] + 0.6)
        group.pieces.append(Piece(seat, seat_size, x, (place - 1.5) * (seat_size[1] + 0.15), turns=0, tint=tint))
    return group


def shelf_row(category: str, size: Vec3, n: int, tint: int, aisle_m: float) -> Group:
    """A double row of shop shelves, back to back, with an aisle on both sides.

    Args:
        category: of the shelves.
        size: of a shelf, metres.
        n: number of shelves, both sides together.
        tint: colour variant.
        aisle_m: width of the aisles.
    """
    group = Group([], margin_m=aisle_m)
    per_side = (n + 1) // 2
    for k in range(n):
        side = 1 if k < per_side else -1
        count = per_side if side == 1 else n - per_side
        index = k if side == 1 else k - per_side
        y = (index - (count - 1) / 2) * (size[1] + 0.01)
        turns = 0 if side == 1 else 2
        group.pieces.append(Piece(category, size, side * (size[0] / 2 + 0.01), y, turns=turns, tint=tint))
    half = per_side * (size[1] + 0.01) / 2
    for side in (1, -1):
        x0, x1 = sorted((side * (size[0] + 0.01), side * (size[0] + 0.01 + aisle_m)))
        group.voids.append((x0, -half, FLAT_M, x1, half, BODY_Z_M[1]))
    return group


def media(tv: str, stand: tuple[str, Vec3] | None, speakers: int, tint: int) -> Group:
    """A television at the wall, above or on its stand, with loudspeakers beside it.

    Args:
        tv: category.
        stand: category and size, or None.
        speakers: number of loudspeakers.
        tint: colour variant.
    """
    size = size_of(tv)
    group = Group([])
    edge = size[1] / 2
    if stand is not None:
        category, stand_size = stand
        group.pieces.append(Piece(category, stand_size, stand_size[0] / 2, 0.0, tint=tint))
        box = (0.0, -stand_size[1] / 2, 0.0, stand_size[0], stand_size[1] / 2, stand_size[2])
        if catalogue()[category].openable:
            group.voids.append(front_void(box))
            group.fronts.append(front_rect(box))
        edge = max(edge, stand_size[1] / 2)
    if tv == "wall_mounted_tv":
        group.pieces.append(Piece(tv, size, size[0] / 2 - WALL_GAP_M, 0.0, 1.0))
    else:
        depth, height = (stand[1][0], stand[1][2]) if stand else (size[0] + 0.1, 0.0)
        group.pieces.append(Piece(tv, size, depth / 2, 0.0, height))
    speaker = size_of("loudspeaker")
    for k in range(min(speakers, 2)):
        y = (1 - 2 * k) * (edge + 0.1 + speaker[1] / 2)
        group.pieces.append(Piece("loudspeaker", speaker, speaker[0] / 2, y))
    return group


def sofa_set(
    sofa: str, size: Vec3, table: str | None, table_size: Vec3 | None, carpet: Vec3 | None, tint: int
) -> Group:
    """A sofa with a low table in front of it, on a carpet.

    Args:
        sofa: category.
        size: of the sofa, metres.
        table: category, or None.
        table_size: metres.
        carpet: size of the carpet, or None.
        tint: colour variant.
    """
    group = Group([Piece(sofa, size, size[0] / 2, 0.0, tint=tint)])
    reach = size[0] + 0.45
    if table is not None:
        table_size = size_of(table, table_size)
        x = size[0] + 0.42 + table_size[0] / 2
        group.pieces.append(Piece(table, table_size, x, 0.0, tint=tint))
        reach = x + table_size[0] / 2 + 0.35
    group.voids.append((size[0], -size[1] / 2 + 0.2, FLAT_M, size[0] + 0.4, size[1] / 2 - 0.2, BODY_Z_M[1]))
    if table is not None:
        group.voids.append((reach - 0.35, -0.4, FLAT_M, reach, 0.4, BODY_Z_M[1]))
    if carpet is not None:
        x = max(size[0] * 0.6 + carpet[0] / 2, reach - 0.2 - carpet[0] / 2)
        group.pieces.append(Piece("carpet", carpet, x, 0.0, tint=tint))
    return group


def _overlap(a: Box3, b: Box3) -> bool:
    return all(min(a[3 + k], b[3 + k]) - max(a[k], b[k]) > 1e-6 for k in range(2))


Unit = tuple[str, Vec3]


def _units(group: Group, units: list[Unit], start: float, turns: int, slabs: bool, tops: list[str], tint: int) -> float:
    """Append counter units side by side from ``start``; along +y for turn 0, along +x for turn 1."""
    at = start
    for category, size in units:
        centre, depth = at + size[1] / 2, size[0] / 2
        place = (depth, centre) if turns == 0 else (centre, depth)
        group.pieces.append(Piece(category, size, place[0], place[1], turns=turns, tint=tint))
        if slabs and category in UNDER_SLAB:
            slab = (RUN_DEPTH_M + 0.02, size[1] + SIDE_M - 0.001, SLAB_M)
            spot = (slab[0] / 2, centre) if turns == 0 else (centre, slab[0] / 2)
            group.pieces.append(Piece("countertop", slab, spot[0], spot[1], COUNTER_M - SLAB_M, turns, tint))
        front = _world_front(centre, size, turns)
        if catalogue()[category].openable:
            group.voids.append(front[0])
            group.fronts.append(front[1])
        elif category != "countertop":
            group.voids.append(_world_front(centre, size, turns, 0.55)[0])
        above = "range_hood" if category in ("stove", "oven") and "range_hood" in tops else "top_cabinet"
        if above in tops and category not in ("fridge",) and (category != "stove" or above == "range_hood"):
            tops.remove(above)
            base = size_of(above)
            wide = min(base[1], size[1]) if above == "range_hood" else size[1]
            top = (base[0], wide, base[2])
            x = top[0] / 2 - WALL_GAP_M
            spot = (x, centre) if turns == 0 else (centre, x)
            z = 1.55 if above == "range_hood" else TOP_Z_M
            group.pieces.append(Piece(above, top, spot[0], spot[1], z, turns, tint))
            if above == "top_cabinet":
                void = (
                    top[0] - WALL_GAP_M,
                    centre - top[1] / 2,
                    z,
                    top[0] + leaf_m(top[1]),
                    centre + top[1] / 2,
                    z + top[2],
                )
                group.voids.append(void if turns == 0 else (void[1], void[0], void[2], void[4], void[3], void[5]))
        at += size[1] + SIDE_M
    return at - SIDE_M


def _world_front(
    centre: float, size: Vec3, turns: int, depth_m: float = FRONT_M
) -> tuple[Box3, tuple[float, float, float, float]]:
    box = (0.0, centre - size[1] / 2, 0.0, size[0], centre + size[1] / 2, size[2])
    void, rect = front_void(box, depth_m), front_rect(box)
    if turns == 0:
        return void, rect
    return (void[1], void[0], void[2], void[4], void[3], void[5]), (rect[1], rect[0], rect[3], rect[2])


def counter_run(units: list[Unit], slabs: bool, tops: list[str], tint: int) -> Group:
    """Counter units in one straight line.

    Args:
        units: category and size of each.
        slabs: whether units without a top get a slab.
        tops: categories to hang above; those used are removed from the list.
        tint: colour variant.
    """
    group = Group([])
    total = sum(size[1] for _, size in units) + SIDE_M * (len(units) - 1)
    _units(group, units, -total / 2, 0, slabs, tops, tint)
    group.margin_m = 0.12 if any(catalogue()[c].openable for c, _ in (units[0], units[-1])) else WALL_GAP_M
    return group


def counter_corner(first: list[Unit], second: list[Unit], slabs: bool, tops: list[str], tint: int) -> Group:
    """Counter units in an L: a blind corner at the origin, ``first`` along +y, ``second`` along +x.

    Args:
        first: category and size of each unit along +y.
        second: of each unit along +x.
        slabs: whether units without a top get a slab.
        tops: categories to hang above; those used are removed from the list.
        tint: colour variant.
    """
    side = RUN_DEPTH_M + 0.02
    group = Group([Piece("countertop", (side, side, COUNTER_M), side / 2, side / 2, tint=tint)])
    _units(group, first, side + 0.13, 0, slabs, tops, tint)
    _units(group, second, side + 0.13, 1, slabs, tops, tint)
    return group
