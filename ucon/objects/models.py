"""``build_model``: the shape of a category at a size and colour variant, built once and shared."""

from __future__ import annotations

from functools import lru_cache

from ucon.core.errors import ConfigError
from ucon.objects import shapes
from ucon.objects.catalogue import catalogue
from ucon.objects.kit import SHAPES, Kit
from ucon.objects.model import ObjectModel, Vec3
from ucon.objects.tint import material_of, tinted


@lru_cache(maxsize=8192)
def build_model(category: str, size: Vec3 | None = None, tint: int = 0) -> ObjectModel:
    """The model of a category.

    Args:
        category: of the catalogue.
        size: (x depth, y width, z height) in metres; the catalogue's size when None.
        tint: colour variant; 0 is the catalogue's colour.

    Raises:
        ConfigError: unknown category, or a size that is not three positive lengths.
    """
    book = catalogue()
    row, hints = book[category], book.hints(category)
    if size is not None and (len(size) != 3 or not all(0 < s < 1000 for s in size)):
        raise ConfigError(f"size of '{category}' is {size}, expected three lengths in metres above 0")
    wanted = row.size if size is None else (float(size[0]), float(size[1]), float(size[2]))
    kit = Kit(row, hints, wanted, tinted(row, tint), material_of(row, hints))
    builder = SHAPES.get(category) or SHAPES.get(row.archetype) or shapes.generic.plain
    builder(kit)
    return kit.finish()
