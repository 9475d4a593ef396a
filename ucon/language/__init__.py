"""Sentence encoders, embedding tables, features of (habit, candidate) pairs, and language models.

Importing this package is cheap. torch and transformers are imported when a text is encoded that neither the shipped
table nor the cache on disk holds.
"""

from ucon.language.encoder import DIM, MINILM_SHA256, MiniLM, TextEncoder
from ucon.language.store import StoredEncoder, VectorTable, default_encoder

__all__ = ["DIM", "MINILM_SHA256", "MiniLM", "StoredEncoder", "TextEncoder", "VectorTable", "default_encoder"]
