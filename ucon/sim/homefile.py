"""A compiled home as bytes: specification, free nodes, rooms and boxes, compressed, with a checksum. No pickle.

Layout: one line ``UCON-HOME <version> <sha256 of the rest>``, then zlib of (length of the JSON as 4 bytes, JSON, bits
of the free nodes, rooms as int16, boxes as float64). Polygons are not stored; they are computed after loading.
"""

from __future__ import annotations

import zlib
from dataclasses import fields
from typing import Any

import numpy as np

from ucon.core.errors import DataError, brief
from ucon.core.files import canonical_json, sha256_bytes
from ucon.core.untrusted.strict_json import parse_json
from ucon.core.untrusted.unpack import unpack_zlib
from ucon.objects.model import Material
from ucon.scenes.spec import HomeSpec, Item, Opening, Room
from ucon.sim.homecheck import MOST_NODES, require_usable
from ucon.sim.house import House, NavGrid

FORMAT = 1
REMEDY = "delete it and it is built again"
_MAGIC = b"UCON-HOME"
#: Largest unpacked home; the largest named one takes 82 KB.
_MAX_BYTES = 16 * 2**20
_verified: set[str] = set()
"""Checksums of the files whose content this process has checked."""


def house_to_bytes(house: House) -> bytes:
    """Serialise a home; equal homes give equal bytes."""
    spec, grid = house.spec, house.grid
    header = {
        "hash": spec.hash,
        "name": spec.name,
        "kind": spec.kind,
        "wall_height_m": spec.wall_height_m,
        "rooms": [_row(room) for room in spec.rooms],
        "openings": [_row(opening) for opening in spec.openings],
        "items": [_row(item) for item in spec.items],
        "origin_xy": list(grid.origin_xy),
        "shape": list(grid.shape),
    }
    text = canonical_json(header).encode()
    body = b"".join(
        (
            len(text).to_bytes(4, "little"),
            text,
            np.packbits(grid.free).tobytes(),
            grid.room.astype("<i2").tobytes(),
            house.boxes.astype("<f8").tobytes(),
        )
    )
    packed = zlib.compress(body, 6)
    return b" ".join((_MAGIC, str(FORMAT).encode(), sha256_bytes(packed).encode())) + b"\n" + packed


def house_from_bytes(data: bytes, where: str) -> House:
    """Read a home that :func:`house_to_bytes` wrote.

    The hash and the map of rooms are computed from the specification and compared with the file's, once per process for
    the same bytes (9 ms for the largest home). Which nodes PyBullet found free, and the boxes, are protected by the
    checksum alone.

    Args:
        data: the bytes.
        where: names the file in errors.

    Raises:
        DataError: another format, bytes that were cut or altered, or content that is no home.
    """
    line, _, packed = data.partition(b"\n")
    words = line.split(b" ")
    if len(words) != 3 or words[0] != _MAGIC:
        raise DataError(f"{where}: not a compiled home; {REMEDY}")
    if words[1] != str(FORMAT).encode():
        found = brief(words[1].decode(errors="replace"))
        raise DataError(f"{where}: compiled home of format {found}, expected {FORMAT}; {REMEDY}")
    checksum = sha256_bytes(packed)
    if checksum.encode() != words[2]:
        raise DataError(f"{where}: checksum differs, the file is truncated or altered; {REMEDY}")
    try:
        house, told = _house(unpack_zlib(packed, _MAX_BYTES))
        if checksum not in _verified:
            require_usable(house, told)
            _verified.add(checksum)
    except (LookupError, TypeError, ValueError, ArithmeticError, AttributeError) as error:
        raise DataError(f"{where}: not a home ({brief(str(error))}); {REMEDY}") from None
    house.spec.__dict__["hash"] = told  # checked above; saves computing it at every loading
    return house


def _house(body: bytes) -> tuple[House, str]:
    """The home in the unpacked bytes, and the hash that they state for it."""
    end = 4 + int.from_bytes(body[:4], "little")
    header = parse_json(body[4:end])
    nx, ny = header["shape"]
    if not (type(nx) is type(ny) is int and 0 < nx <= MOST_NODES and 0 < ny <= MOST_NODES):
        raise ValueError(f"{nx} x {ny} nodes, expected 1 to {MOST_NODES} each way")
    bits = (nx * ny + 7) // 8
    free = np.unpackbits(np.frombuffer(body, np.uint8, bits, end), count=nx * ny).astype(bool).reshape(nx, ny)
    room = np.frombuffer(body, "<i2", nx * ny, end + bits).reshape(nx, ny).astype(np.int16)
    boxes = np.frombuffer(body, "<f8", -1, end + bits + 2 * nx * ny).reshape(-1, 6).astype(np.float64)
    for array in (free, room, boxes):
        array.flags.writeable = False
    ox, oy = header["origin_xy"]
    return House(_spec(header), NavGrid((ox, oy), free, room), boxes), header["hash"]


def _row(value: Any) -> list[Any]:
    return [getattr(value, field.name) for field in fields(value)]


def _spec(header: dict[str, Any]) -> HomeSpec:
    return HomeSpec(
        name=header["name"],
        kind=header["kind"],
        wall_height_m=header["wall_height_m"],
        rooms=tuple(_room(*row) for row in header["rooms"]),
        openings=tuple(Opening(*row) for row in header["openings"]),
        items=tuple(_item(*row) for row in header["items"]),
    )


def _room(name: str, kind: str, rect: list[float], floor: list[int], material: int, wall: list[int], out: bool) -> Room:
    return Room(name, kind, tuple(rect), tuple(floor), Material(material), tuple(wall), out)  # type: ignore[arg-type]


def _item(category: str, size: list[float], position: list[float], turns: int, room: int, tint: int) -> Item:
    return Item(category, tuple(size), tuple(position), turns, room, tint)  # type: ignore[arg-type]
