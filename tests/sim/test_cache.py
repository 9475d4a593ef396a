import json
import time
import zlib
from pathlib import Path

import numpy as np
import pytest

from tests.sim.homes import hand_house
from ucon.core.errors import DataError, UconError
from ucon.core.files import canonical_json, sha256_bytes, sha256_file
from ucon.sim import cache, homefile
from ucon.sim.homefile import house_from_bytes, house_to_bytes

NAME = "Rs_int"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("UCON_CACHE", str(tmp_path))
    monkeypatch.setattr(cache, "PACKED", tmp_path / "packed")
    cache.load_house.cache_clear()
    yield tmp_path
    cache.load_house.cache_clear()


def same(a, b):
    return (
        a.spec == b.spec
        and a.spec.hash == b.spec.hash
        and (a.grid.free == b.grid.free).all()
        and (a.grid.room == b.grid.room).all()
        and a.grid.origin_xy == b.grid.origin_xy
        and (a.boxes == b.boxes).all()
    )


def test_round_trip_is_exact():
    house = hand_house()
    data = house_to_bytes(house)
    back = house_from_bytes(data, "memory")
    assert same(house, back)
    assert house_to_bytes(back) == data
    assert type(back.spec)(**{f: getattr(back.spec, f) for f in back.spec.__dataclass_fields__}).hash == house.spec.hash


def test_arrays_are_read_only():
    back = house_from_bytes(house_to_bytes(hand_house()), "memory")
    with pytest.raises(ValueError, match="read-only"):
        back.boxes[0] = 0.0


@pytest.mark.parametrize("place", [0, 10, 30, 100, -1])
def test_a_flipped_bit_is_found(place):
    data = bytearray(house_to_bytes(hand_house()))
    data[place] ^= 1
    with pytest.raises(DataError, match=r"some\.home"):
        house_from_bytes(bytes(data), "some.home")


def test_a_cut_file_is_found():
    data = house_to_bytes(hand_house())
    for length in (0, 5, 60, len(data) - 1):
        with pytest.raises(DataError):
            house_from_bytes(data[:length], "some.home")


@pytest.mark.timed
def test_load_builds_once_then_reads_in_milliseconds(folder):
    built = cache.load_house(NAME)
    files = list(folder.rglob("*.home"))
    assert len(files) == 1
    assert files[0].stat().st_size < 100_000
    times = []
    for _ in range(5):
        cache.load_house.cache_clear()
        start = time.process_time()
        loaded = cache.load_house(NAME)
        times.append(time.process_time() - start)
        assert loaded is not built
        assert same(built, loaded)
    assert np.median(times) < 0.020


def test_a_damaged_cache_file_is_built_again(folder):
    built = cache.load_house(NAME)
    file = next(folder.rglob("*.home"))
    file.write_bytes(file.read_bytes()[:-7])
    cache.load_house.cache_clear()
    assert same(cache.load_house(NAME), built)
    house_from_bytes(file.read_bytes(), str(file))


def test_packed_homes_are_used_first_and_verified(folder, monkeypatch):
    paths = cache.pack_homes([NAME], folder / "packed")
    assert json.loads((folder / "packed" / "MANIFEST.json").read_text())["files"][paths[0].name]["bytes"]
    monkeypatch.setattr(cache, "build_house", lambda name: pytest.fail("built although packed"))
    assert cache.load_house(NAME).spec.name == NAME
    cache.load_house.cache_clear()
    paths[0].write_bytes(paths[0].read_bytes()[:-7])
    with pytest.raises(DataError, match=NAME):
        cache.load_house(NAME)


def test_unknown_home_is_one_clear_error(folder):
    with pytest.raises(UconError, match="Rs_imt"):
        cache.load_house("Rs_imt")


def test_names_never_share_a_file():
    names = ["a:b", "a-b", "a~b", "procedural:house:1", "procedural:house:11"]
    assert len({cache.file_name(n) for n in names}) == len(names)


PACKED_HOMES = sorted(path.name for path in cache.PACKED.glob(f"*{cache.SUFFIX}"))


@pytest.mark.parametrize(
    "file", [name if k % 25 == 0 else pytest.param(name, marks=pytest.mark.slow) for k, name in enumerate(PACKED_HOMES)]
)
def test_shipped_homes_are_what_the_code_builds(file):
    """After a change of layout rules, no outdated homes may remain in the package."""
    data = (cache.PACKED / file).read_bytes()
    name = house_from_bytes(data, file).spec.name
    assert cache.file_name(name) == file
    assert same(cache.build_house(name), house_from_bytes(data, file))


def test_shipped_homes_are_in_their_manifest():
    listed = json.loads((cache.PACKED / "MANIFEST.json").read_text())["files"]
    assert sorted(listed) == PACKED_HOMES
    assert all(sha256_file(cache.PACKED / name) == entry["sha256"] for name, entry in listed.items())
    assert all(entry["bytes"] < 100_000 for entry in listed.values())


def repacked(data, change):
    """A home's file with changed content and a valid checksum."""
    body = bytearray(zlib.decompress(data.partition(b"\n")[2]))
    end = 4 + int.from_bytes(body[:4], "little")
    header = json.loads(body[4:end])
    rest = bytearray(body[end:])
    change(header, rest)
    text = canonical_json(header).encode()
    packed = zlib.compress(len(text).to_bytes(4, "little") + text + bytes(rest))
    return b"UCON-HOME 1 " + sha256_bytes(packed).encode() + b"\n" + packed


def with_first(rows, column, value):
    def change(header, rest):
        header[rows][0][column] = value

    return change


def setting(name, value):
    return lambda header, rest: header.update({name: value})


CHANGED = {
    "hash": setting("hash", "0" * 64),
    "hash of no text": setting("hash", 10**9),
    "an item moved": with_first("items", 2, [1.0, 1.0, 0.0]),
    "an item that is none": with_first("items", 0, "no_such_thing"),
    "an item of no size": with_first("items", 1, [0, 1, 1]),
    "an item beyond all numbers": with_first("items", 2, [1e300, 1.0, 0.0]),
    "an item in no room": with_first("items", 4, 10**6),
    "a room of letters": with_first("rooms", 2, "abcd"),
    "a room without end": with_first("rooms", 2, [0, 0, 1e9, 1e9]),
    "no rooms": setting("rooms", []),
    "no items": lambda header, rest: header.pop("items"),
    "a shape of a million million": setting("shape", [10**6, 10**6]),
    "a shape below zero": setting("shape", [-1, -1]),
    "a shape of text": setting("shape", "ab"),
    "an origin elsewhere": setting("origin_xy", [5.0, 5.0]),
    "the map of rooms": lambda header, rest: rest.__setitem__(slice(1000, 1100), b"\x07" * 100),
    "more boxes": lambda header, rest: rest.extend(bytes(48)),
    "cut boxes": lambda header, rest: rest.__delitem__(slice(-5, None)),
    "boxes that are no numbers": lambda header, rest: rest.__setitem__(slice(-8, None), b"\xff" * 8),
}


@pytest.mark.parametrize("change", CHANGED.values(), ids=CHANGED)
def test_a_changed_home_under_a_right_checksum_is_refused(change):
    with pytest.raises(DataError, match=r"some\.home: .*delete it and it is built again") as refused:
        house_from_bytes(repacked(house_to_bytes(hand_house()), change), "some.home")
    assert "\n" not in str(refused.value)


def test_a_home_that_unpacks_to_more_than_any_is_refused():
    packed = zlib.compress(bytes(1 << 25), 1)
    with pytest.raises(DataError, match="holds more than"):
        house_from_bytes(b"UCON-HOME 1 " + sha256_bytes(packed).encode() + b"\n" + packed, "some.home")


def test_the_hash_is_found_once_for_the_same_file(monkeypatch):
    data = repacked(house_to_bytes(hand_house()), lambda header, rest: None)
    monkeypatch.setattr(homefile, "_verified", set())
    house_from_bytes(data, "some.home")
    monkeypatch.setattr(homefile, "require_usable", lambda house, told: pytest.fail("verified again"))
    assert house_from_bytes(data, "some.home").spec.hash == hand_house().spec.hash


DAMAGE = {
    "cut": lambda data: data[:-7],
    "a flipped bit": lambda data: data[:100] + bytes([data[100] ^ 1]) + data[101:],
    "another version": lambda data: data.replace(b"UCON-HOME 1", b"UCON-HOME 7", 1),
    "another home": lambda data: house_to_bytes(hand_house()),
    "an item moved": lambda data: repacked(data, CHANGED["an item moved"]),
    "nothing": lambda data: b"",
    "a directory": None,
}


@pytest.mark.parametrize("damage", DAMAGE)
def test_a_damaged_home_in_the_cache_is_built_again_with_one_line(damage, folder, monkeypatch, capsys):
    shipped = (Path(cache.__file__).parents[1] / "scenes" / "data" / "homes" / cache.file_name(NAME)).read_bytes()
    right = house_from_bytes(shipped, "shipped")
    monkeypatch.setattr(cache, "build_house", lambda name: right)  # built without PyBullet, which takes a second
    file = cache.cache_folder() / cache.file_name(NAME)
    file.parent.mkdir(parents=True)
    change = DAMAGE[damage]
    file.mkdir() if change is None else file.write_bytes(change(shipped))
    assert cache.load_house(NAME) is right
    (line,) = capsys.readouterr().err.splitlines()
    assert str(file) in line
    assert f"home '{NAME}' is built again" in line
    if change is not None:
        cache.load_house.cache_clear()
        assert same(cache.load_house(NAME), right)
        assert not capsys.readouterr().err
