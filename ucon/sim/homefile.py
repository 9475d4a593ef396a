"""A compiled home as bytes: specification, free nodes, rooms and boxes, compressed, with a checksum. No pickle.

Layout: one line ``UCON-HOME <version> <sha256 of the rest>``, then zlib of (length of the JSON as 4 bytes, JSON,
bits of the free nodes, rooms as int16, boxes as float64). The polygons are made again on loading.
"""

from __future__ import annotations

import json
import zlib
from dataclasses import fields
from typing import Any

import numpy as np

from ucon.core.errors import DataError
from ucon.core.files import canonical_json, sha256_bytes
from ucon.objects.model import Material
from ucon.scenes.spec import HomeSpec, Item, Opening, Room
from ucon.sim.house import House, NavGrid

FORMAT = 1
_MAGIC = b"UCON-HOME"


def house_to_bytes(house: House) -> bytes:
    """Serialise; equal houses give equal bytes."""
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
    """Read back what :func:`house_to_bytes` wrote.

    Raises:
        DataError: another format, or bytes that were cut or altered; ``where`` names the file.
    """
    line, _, packed = data.partition(b"\n")
    words = line.split(b" ")
    if len(words) != 3 or words[0] != _MAGIC:
        raise DataError(f"{where}: not a compiled home; delete it and it is built again")
    if words[1] != str(FORMAT).encode():
        raise DataError(
            f"{where}: compiled home of format {words[1].decode(errors='replace')}, expected {FORMAT}; "
            "delete it and it is built again"
        )
    if sha256_bytes(packed).encode() != words[2]:
        raise DataError(f"{where}: checksum differs, the file is truncated or altered; delete it and it is built again")
    body = zlib.decompress(packed)
    end = 4 + int.from_bytes(body[:4], "little")
    header = json.loads(body[4:end])
    spec = _spec(header)
    nx, ny = header["shape"]
    bits = (nx * ny + 7) // 8
    free = np.unpackbits(np.frombuffer(body, np.uint8, bits, end), count=nx * ny).astype(bool).reshape(nx, ny)
    room = np.frombuffer(body, "<i2", nx * ny, end + bits).reshape(nx, ny).astype(np.int16)
    boxes = np.frombuffer(body, "<f8", -1, end + bits + 2 * nx * ny).reshape(-1, 6).astype(np.float64)
    for array in (free, room, boxes):
        array.flags.writeable = False
    ox, oy = header["origin_xy"]
    return House(spec, NavGrid((ox, oy), free, room), boxes)


def _row(value: Any) -> list[Any]:
    return [getattr(value, field.name) for field in fields(value)]


def _spec(header: dict[str, Any]) -> HomeSpec:
    spec = HomeSpec(
        name=header["name"],
        kind=header["kind"],
        wall_height_m=header["wall_height_m"],
        rooms=tuple(_room(*row) for row in header["rooms"]),
        openings=tuple(Opening(*row) for row in header["openings"]),
        items=tuple(_item(*row) for row in header["items"]),
    )
    # The checksum covers the hash, so it need not be computed again from the canonical JSON (10 ms).
    spec.__dict__["hash"] = header["hash"]
    return spec


def _room(name: str, kind: str, rect: list[float], floor: list[int], material: int, wall: list[int], out: bool) -> Room:
    return Room(name, kind, tuple(rect), tuple(floor), Material(material), tuple(wall), out)  # type: ignore[arg-type]


def _item(category: str, size: list[float], position: list[float], turns: int, room: int, tint: int) -> Item:
    return Item(category, tuple(size), tuple(position), turns, room, tint)  # type: ignore[arg-type]
