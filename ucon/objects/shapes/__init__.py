"""Builders of shapes, one module a family; importing a module registers its builders."""

from ucon.objects.shapes import appliances, cabinets, furniture, generic

__all__ = ["appliances", "cabinets", "furniture", "generic"]
