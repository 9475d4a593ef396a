"""Builders of shapes, one module a family; importing a module registers its builders."""

from ucon.objects.shapes import generic

__all__ = ["generic"]
