"""Builders of shapes, one module a family; importing a module registers its builders."""

from ucon.objects.shapes import (
    appliances,
    bathroom,
    cabinets,
    electronics,
    food,
    furniture,
    generic,
    household,
    packages,
    small,
    structure,
    tools,
    vessels,
)

__all__ = [
    "appliances",
    "bathroom",
    "cabinets",
    "electronics",
    "food",
    "furniture",
    "generic",
    "household",
    "packages",
    "small",
    "structure",
    "tools",
    "vessels",
]
