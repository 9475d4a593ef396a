import json
import time

import numpy as np
import pytest

from tests.sim.homes import hand_house
from ucon.core.errors import DataError, UconError
from ucon.core.files import sha256_file
from ucon.sim import cache
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
    """A changed layout rule must not leave old homes in the package."""
    data = (cache.PACKED / file).read_bytes()
    name = house_from_bytes(data, file).spec.name
    assert cache.file_name(name) == file
    assert same(cache.build_house(name), house_from_bytes(data, file))


def test_shipped_homes_are_in_their_manifest():
    listed = json.loads((cache.PACKED / "MANIFEST.json").read_text())["files"]
    assert sorted(listed) == PACKED_HOMES
    assert all(sha256_file(cache.PACKED / name) == entry["sha256"] for name, entry in listed.items())
    assert all(entry["bytes"] < 100_000 for entry in listed.values())
