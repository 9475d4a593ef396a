"""The catalogue: facts about each of the 838 categories.

Each row of ``data/catalogue.csv`` gives one :class:`Category` (for general use) and one :class:`Hints` (for the shape
builders). A wrong value raises an error that names file and line.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, get_args, get_type_hints

from ucon.core.errors import ConfigError, DataError, unknown_name
from ucon.objects.model import Category, Vec3

CATALOGUE_FILE = Path(__file__).parent / "data" / "catalogue.csv"

_HINT_TYPES = get_type_hints(Category)
_MOUNTS: tuple[str, ...] = get_args(_HINT_TYPES["mount"])
_ROLES: tuple[str, ...] = get_args(_HINT_TYPES["role"])
_SPLITS = ("", "train", "test")
_COLUMNS = [
    *("name", "archetype", "x_m", "y_m", "z_m", "mass_kg", "color", "rgb", "mount", "role", "group"),
    *("openable", "container", "support", "bottom_z_m", "rooms", "official_target", "official_split"),
    *("container_kind", "interior_frac", "compartments", "top_frac", "area_frac", "under_frac", "note"),
]


@dataclass(frozen=True, slots=True)
class Hints:
    """Proportions for the shape builders, as fractions of the object's size.

    Attributes:
        color_name: name of its colour.
        container_kind: kind of its compartments.
        interior_frac: size of the interior.
        compartments: number of compartments.
        top_frac: height of the surface on top.
        area_frac: usable fraction of the top's area.
        under_frac: free height below.
    """

    color_name: str
    container_kind: str
    interior_frac: Vec3 | None
    compartments: int
    top_frac: float | None
    area_frac: float | None
    under_frac: float


class Catalogue:
    """All categories by name, in alphabetical order; a mapping from names to :class:`Category`.

    Attributes:
        names: of all categories, in alphabetical order.
    """

    def __init__(self, rows: dict[str, tuple[Category, Hints]]) -> None:
        self._rows = rows
        self.names: tuple[str, ...] = tuple(rows)

    def __getitem__(self, name: str) -> Category:
        return self._row(name)[0]

    def __contains__(self, name: object) -> bool:
        return name in self._rows

    def __iter__(self) -> Iterator[Category]:
        return (category for category, _ in self._rows.values())

    def __len__(self) -> int:
        return len(self._rows)

    def hints(self, name: str) -> Hints:
        """The shape builders' hints for a category.

        Raises:
            ConfigError: no such category.
        """
        return self._row(name)[1]

    def _row(self, name: str) -> tuple[Category, Hints]:
        try:
            return self._rows[name]
        except (KeyError, TypeError):
            raise ConfigError(unknown_name("category", str(name), self.names)) from None


@lru_cache(maxsize=1)
def catalogue() -> Catalogue:
    """The shipped catalogue, read once per process."""
    return read_catalogue(CATALOGUE_FILE)


def read_catalogue(path: Path) -> Catalogue:
    """Read and check a catalogue file.

    Raises:
        DataError: the file is missing, or a row has a wrong value; names file and line.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise DataError(f"{path}: cannot be read as text ({error}); restore it from the release") from None
    reader = csv.reader(text.splitlines())
    header = next(reader, [])
    if header != _COLUMNS:
        raise DataError(f"{path}:1: columns are {', '.join(header) or 'missing'}; expected {', '.join(_COLUMNS)}")
    rows: dict[str, tuple[Category, Hints]] = {}
    for values in reader:
        where = f"{path}:{reader.line_num}"
        row = _parse(values, where)
        name = row[0].name
        if name in rows:
            raise DataError(f"{where}: category '{name}' is in the file twice; remove one of the rows")
        rows[name] = row
    if not rows:
        raise DataError(f"{path}:2: no categories; restore the file from the release")
    return Catalogue(dict(sorted(rows.items())))


def _parse(values: list[str], where: str) -> tuple[Category, Hints]:
    if len(values) != len(_COLUMNS):
        raise DataError(f"{where}: {len(values)} fields, expected {len(_COLUMNS)}; the row is truncated or altered")
    cell = _Cells(dict(zip(_COLUMNS, values, strict=True)), where)
    size = (cell.number("x_m", 0.001, 60), cell.number("y_m", 0.001, 60), cell.number("z_m", 0.001, 60))
    mount: Any = cell.choice("mount", _MOUNTS)
    role: Any = cell.choice("role", _ROLES)
    category = Category(
        name=cell.text("name"),
        archetype=cell.text("archetype"),
        size=size,
        mass_kg=cell.number("mass_kg", 1e-4, 1e5),
        color=cell.rgb(),
        mount=mount,
        role=role,
        semantic_group=cell.text("group"),
        openable=cell.flag("openable"),
        container=cell.flag("container"),
        support=cell.flag("support"),
        bottom_z_m=cell.number("bottom_z_m", 0, 10),
        rooms=tuple(cell.text("rooms").split("|")),
        official_target=cell.flag("official_target"),
        official_split=cell.choice("official_split", _SPLITS),
        note=cell.row["note"],
    )
    hints = Hints(
        color_name=cell.text("color"),
        container_kind=cell.row["container_kind"],
        interior_frac=cell.fractions("interior_frac"),
        compartments=int(cell.number("compartments", 0, 12)),
        top_frac=cell.optional("top_frac"),
        area_frac=cell.optional("area_frac"),
        under_frac=cell.number("under_frac", 0, 1),
    )
    return category, hints


class _Cells:
    """The cells of one row, checked as they are read."""

    def __init__(self, row: dict[str, str], where: str) -> None:
        self.row = row
        self.where = where

    def wrong(self, column: str, expected: str) -> DataError:
        name = self.row["name"] or "?"
        return DataError(f"{self.where}: {name}: {column} is '{self.row[column]}', expected {expected}")

    def text(self, column: str) -> str:
        if not self.row[column].strip():
            raise self.wrong(column, "text")
        return self.row[column]

    def choice(self, column: str, options: tuple[str, ...]) -> str:
        if self.row[column] not in options:
            raise self.wrong(column, "one of " + ", ".join(option or "(empty)" for option in options))
        return self.row[column]

    def flag(self, column: str) -> bool:
        return self.choice(column, ("0", "1")) == "1"

    def number(self, column: str, low: float, high: float) -> float:
        try:
            value = float(self.row[column])
        except ValueError:
            raise self.wrong(column, "a number") from None
        if not low <= value <= high:
            raise self.wrong(column, f"a number from {low:g} to {high:g}")
        return value

    def optional(self, column: str) -> float | None:
        return None if self.row[column] == "" else self.number(column, 0, 1)

    def fractions(self, column: str) -> Vec3 | None:
        if self.row[column] == "":
            return None
        try:
            x, y, z = (float(value) for value in self.row[column].split())
        except ValueError:
            raise self.wrong(column, "three numbers") from None
        if not all(0 < value <= 1 for value in (x, y, z)):
            raise self.wrong(column, "three fractions above 0 and up to 1")
        return x, y, z

    def rgb(self) -> tuple[int, int, int]:
        try:
            red, green, blue = (int(value) for value in self.row["rgb"].split())
        except ValueError:
            raise self.wrong("rgb", "three whole numbers") from None
        if not all(0 <= value <= 255 for value in (red, green, blue)):
            raise self.wrong("rgb", "three whole numbers from 0 to 255")
        return red, green, blue
