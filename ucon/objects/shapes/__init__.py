"""Builders of shapes, one module a family; importing a module registers its builders."""

from ucon.objects.shapes import appliances, bathroom, cabinets, furniture, generic, structure, vessels

__all__ = ["appliances", "bathroom", "cabinets", "furniture", "generic", "structure", "vessels"]
