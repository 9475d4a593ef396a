"""``load_house``: a compiled home by name, from memory, the package, a pack or the user's cache, or built.

The cache key holds the home's name, the file format and a fingerprint of the code and data that homes are made from, so
that homes compiled by older code are never used.
"""

from __future__ import annotations

import contextlib
import copyreg
import re
import sys
from collections.abc import Iterable
from functools import lru_cache
from pathlib import Path
from typing import Any
from weakref import WeakValueDictionary

import ucon
from ucon.core.errors import DataError, UconError, brief
from ucon.core.files import read_verified, sha256_bytes, user_cache, user_pack, write_atomic, write_manifest
from ucon.core.untrusted.plain_file import read_bounded
from ucon.sim.bullet import bullet
from ucon.sim.homefile import FORMAT, REMEDY, house_from_bytes, house_to_bytes
from ucon.sim.house import House

SUFFIX = ".home"
#: Folder of homes in a pack.
IN_PACK = "homes"
PACKED = Path(ucon.__file__).parent / "scenes" / "data" / "homes"
_SOURCES = ("core/geometry.py", "core/rng.py", "objects", "scenes", "sim")
_IN_MEMORY = 32
#: Largest file in the cache; the largest named home takes 19 KB.
_MAX_FILE = 16 * 2**20


#: Homes by the name under which they were loaded.
_LOADED: WeakValueDictionary[str, House] = WeakValueDictionary()


@lru_cache(maxsize=_IN_MEMORY)
def load_house(name: str) -> House:
    """The compiled home of this name, such as ``Rs_int``, ``Rs_int~3`` or ``procedural:house:17``.

    It is looked for in memory, in the package, in the folder that ``UCON_PACK`` names and in the user's cache; as a
    last resort it is built with PyBullet. A damaged cache file is built again, with one line of warning; a damaged
    shipped or packed file is an error.

    Raises:
        ConfigError: no such home, or no such folder.
        SceneError: it cannot be built.
        DataError: a shipped or packed home is damaged, or it is in none of these places and PyBullet is missing.
    """
    _LOADED[name] = house = _load(name)
    return house


def _load(name: str) -> House:
    file = file_name(name)
    for packed in (folder / file for folder in _packed_folders() if (folder / file).is_file()):
        return _named(name, house_from_bytes(read_verified(packed), str(packed)), packed)
    cached = cache_folder() / file
    if (kept := _kept(name, cached)) is not None:
        return kept
    _require_bullet(name)
    house = build_house(name)
    with contextlib.suppress(OSError):  # A read-only cache costs time, not correctness.
        write_atomic(cached, house_to_bytes(house))
    return house


def loaded_by_name(house: House) -> bool:
    """Whether :func:`load_house` returns this very object for its name, so that pickles may hold the name alone."""
    return _LOADED.get(house.spec.name) is house


def _pickled(house: House) -> Any:
    """Pickle a home that was loaded by its name as name and hash, and any other home whole."""
    if loaded_by_name(house):
        return the_house, (house.spec.name, house.spec.hash)
    return house.__reduce_ex__(4)


copyreg.pickle(House, _pickled)


def the_house(name: str, spec_hash: str) -> House:
    """The home of this name, for unpickling.

    Args:
        name: of the home.
        spec_hash: hash of its specification when it was pickled.

    Raises:
        DataError: the home here is another version; and as for :func:`load_house`.
    """
    house = load_house(name)
    if house.spec.hash != spec_hash:
        raise DataError(f"home '{name}': pickled as {spec_hash[:12]}, here it is {house.spec.hash[:12]}")
    return house


def _kept(name: str, cached: Path) -> House | None:
    """The home of a file in the cache; None where it has to be built, with a warning where the file is damaged."""
    try:
        return _named(name, house_from_bytes(read_bounded(cached, _MAX_FILE), str(cached)), cached)
    except FileNotFoundError:
        return None
    except (DataError, OSError) as error:
        why = str(error) if isinstance(error, DataError) else f"{cached}: cannot be read ({error.strerror})"
        print(f"warning: {why.removesuffix(f'; {REMEDY}')}; home '{name}' is built again", file=sys.stderr)  # noqa: T201
        return None


def _named(name: str, house: House, path: Path) -> House:
    if house.spec.name != name:
        raise DataError(f"{path}: home '{brief(house.spec.name)}', expected '{name}'; {REMEDY}")
    return house


def _packed_folders() -> list[Path]:
    """Where packed homes are: in the package, then in the user's pack."""
    pack = user_pack()
    return [PACKED] if pack is None else [PACKED, pack / IN_PACK]


def _require_bullet(name: str) -> None:
    from ucon.scenes import home_spec

    try:
        bullet()
    except UconError:
        home_spec(name)  # an unknown name is reported first
        pack = user_pack()
        places = "the package and the cache" if pack is None else f"the package, {pack} and the cache"
        raise DataError(
            f"home '{name}': not in {places}, and PyBullet, which builds homes, is missing here; on a machine "
            f"with PyBullet, run `python -m ucon pack SET_OR_HOME --out FOLDER`, copy FOLDER and give UCON_PACK=FOLDER"
        ) from None


def build_house(name: str) -> House:
    """Build and check a home now, without caches; needs PyBullet.

    Raises:
        SceneError: it cannot be built.
    """
    from ucon.scenes import home_spec
    from ucon.sim.compile import compile_mended

    return compile_mended(home_spec(name))


def pack_homes(names: Iterable[str], folder: Path, *, fresh: bool = True) -> list[Path]:
    """Write compiled homes and a SHA-256 manifest, as the package ships them.

    Args:
        names: of the homes.
        folder: where to write them.
        fresh: build them again, even if they are cached.

    Returns:
        The written files.
    """
    paths = []
    for name in names:
        path = folder / file_name(name)
        write_atomic(path, house_to_bytes(build_house(name) if fresh else load_house(name)))
        paths.append(path)
    write_manifest(folder, [path.name for path in sorted(folder.glob(f"*{SUFFIX}"))])
    return paths


def file_name(name: str) -> str:
    """File name of a home: its name with unusual characters replaced by ``-``, and a short hash."""
    return f"{re.sub(r'[^A-Za-z0-9_.]', '-', name)[:80]}-{sha256_bytes(name.encode())[:8]}{SUFFIX}"


def cache_folder() -> Path:
    """Folder of compiled homes in the user's cache, for this version of the code."""
    return user_cache() / "homes" / f"{FORMAT}-{fingerprint()[:16]}"


@lru_cache(maxsize=1)
def fingerprint() -> str:
    """SHA-256 of the code and data that decide what a home is."""
    root = Path(ucon.__file__).parent
    files = [path for source in _SOURCES for path in _files(root / source)]
    parts = [f"{path.relative_to(root).as_posix()} {sha256_bytes(path.read_bytes())}" for path in files]
    return sha256_bytes("\n".join(parts).encode())


def _files(source: Path) -> list[Path]:
    if source.is_file():
        return [source]
    # These do not affect what a home is.
    skipped = {"__pycache__", "render", "placement", "robot", "homes", "cache.py", "live.py", "sheets.py"}
    return sorted(
        path for path in source.rglob("*") if path.is_file() and not skipped & set(path.relative_to(source).parts)
    )
