"""Builders of shapes, one module a family; importing a module registers its builders."""

from ucon.objects.shapes import (
    appliances,
    bathroom,
    cabinets,
    food,
    furniture,
    generic,
    household,
    packages,
    structure,
    vessels,
)

__all__ = [
    "appliances",
    "bathroom",
    "cabinets",
    "food",
    "furniture",
    "generic",
    "household",
    "packages",
    "structure",
    "vessels",
]
