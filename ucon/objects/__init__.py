"""The catalogue of 838 categories, and the shapes they are built from."""

from ucon.objects.catalogue import Catalogue, catalogue
from ucon.objects.models import build_model

__all__ = ["Catalogue", "build_model", "catalogue"]
