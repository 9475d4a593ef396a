"""Habits about an episode's target as arrays of fixed shape, computed once at reset.

The belief over anchors comes from a reader (``ucon.readers.anchor_reader.AnchorReader``, or another with the same
interface). The habits that speak most for places of the target are also given as vectors, for the network to attend to.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ucon.language.encoder import DIM
from ucon.language.phrases import phrase, query_text
from ucon.language.store import StoredEncoder, default_encoder
from ucon.objects.catalogue import catalogue
from ucon.objects.model import RELATIONS
from ucon.perception.places.affordances import affordance, sight_range_m
from ucon.readers.protocol import Read, Reader, read_info

N_HABITS = 24
"""Number of habits given as vectors: those with the largest support for places of the target."""
HABIT_FEATURES = ("there", "relevance", "place", "score")
"""Features of each such habit.

1 (0 in empty rows), relevance to the target, support for any place of it, and, where asked for, its retrieval score.
"""
SUMMARY_FEATURES = ("most", "entropy", "amount", "some", "trusted", "size_m", "height_m")
STATIC_FEATURES = ("openable", "inside", "ontop", "under", "furniture", "length_m", "height_m", "known")
"""Features of a category from the catalogue; ``known``: an anchor that the reader knows."""


class Words(NamedTuple):
    """Categories of the catalogue, in its order, with embeddings and static features."""

    number: dict[str, int]
    vectors: NDArray[np.float16]
    """(n, DIM) embeddings of the names."""
    static: NDArray[np.float32]
    """(n, len(STATIC_FEATURES) - 1): all of :data:`STATIC_FEATURES` but ``known``."""


@lru_cache(maxsize=1)
def words() -> Words:
    """The catalogue's categories; computed once per process."""
    names = catalogue().names
    static = np.zeros((len(names), len(STATIC_FEATURES) - 1), np.float32)
    for row, name in zip(static, names, strict=True):
        offers, size = affordance(name), catalogue()[name].size
        row[:5] = offers.openable, offers.inside, offers.ontop, offers.under, offers.furniture
        row[5:] = min(max(size[:2]), 4.0), min(size[2], 3.0)
    vectors = default_encoder().encode_half([phrase(name) for name in names])
    return Words({name: k for k, name in enumerate(names)}, vectors, static)


def kept_habits(reading: Read, texts: Sequence[str], known: Sequence[str]) -> tuple[list[int], NDArray[np.float64]]:
    """The habits that speak most for places of the target.

    Args:
        reading: of the habits about the target.
        texts: H habits.
        known: A anchors.

    Returns:
        Indices of at most N_HABITS habits, ordered by support and text, so independent of the list's order; and the
        support (H, A) of all habits for each anchor.
    """
    support = np.zeros((len(texts), len(known)))
    for k, anchor in enumerate(known):
        support[:, k] = reading.support(anchor)
    weight = np.round(support.sum(1), 6)
    order = sorted(range(len(texts)), key=lambda k: (-weight[k], texts[k]))
    return order[:N_HABITS], support


def read_habits(
    reader: Reader, info: Mapping[str, Any], *, scores: bool = False, encoder: StoredEncoder | None = None
) -> dict[str, NDArray[np.generic]]:
    """Arrays of an episode from the ``info`` of its reset.

    Args:
        reader: of the habits.
        info: with ``target``, ``habits`` and ``habit_level``.
        scores: give each habit its cosine with the retrieval query.
        encoder: of the sentences; the shipped one by default.

    Returns:
        belief (n, 4) float16, p(category, relation) for the n categories of the catalogue; summary (7,) float32;
        target () int64, its number, n outside the catalogue; goal (DIM,) float16, embedding of its name; habit_vectors
        (N_HABITS, DIM) float16; habit_features (N_HABITS, 4) float16; support (N_HABITS, A) float16; reach_m ()
        float32, distance in metres from which the target is seen.
    """
    target, texts = str(info["target"]), tuple(info["habits"])
    trusted = info.get("habit_level") == "gt"
    encoder = encoder or default_encoder()
    reading = read_info(reader, info)
    belief, known = reading.belief(reader.known), tuple(reader.known)
    joint = np.zeros((len(words().number), len(RELATIONS)), np.float16)
    for name, p, relation in zip(known, belief.p, belief.relation, strict=True):
        if name in words().number:
            joint[words().number[name]] = p * relation
    kept, support = kept_habits(reading, texts, known)
    vectors, features = np.zeros((N_HABITS, DIM), np.float16), np.zeros((N_HABITS, len(HABIT_FEATURES)), np.float16)
    supports = np.zeros((N_HABITS, len(known)), np.float16)
    if kept:
        vectors[: len(kept)] = encoder.encode_half([texts[k] for k in kept])
        supports[: len(kept)] = support[kept]
        features[: len(kept), 0] = 1.0
        features[: len(kept), 1] = np.asarray(reading.relevance)[kept]
        features[: len(kept), 2] = support[kept].sum(1)
    if kept and scores:
        query = encoder.encode_half([query_text(target)])[0].astype(np.float32)
        features[: len(kept), 3] = vectors[: len(kept)].astype(np.float32) @ query
    return {
        "belief": joint,
        "summary": _summary(np.asarray(belief.p), len(texts), support, trusted, target),
        "target": np.array(words().number.get(target, len(words().number))),
        "goal": encoder.encode_half([phrase(target)])[0],
        "habit_vectors": vectors,
        "habit_features": features,
        "support": supports,
        "reach_m": np.array(sight_range_m(target), np.float32),
    }


def _summary(
    p: NDArray[np.float64], n: int, support: NDArray[np.float64], trusted: bool, target: str
) -> NDArray[np.float32]:
    """(7,) float32: how certain the belief is, how much the habits say, and the size of the target."""
    entropy = -float((p * np.log(np.maximum(p, 1e-12))).sum())
    size = catalogue()[target].size if target in catalogue() else (0.1, 0.1, 0.1)
    amount = float(np.log1p(support.sum()))
    largest = min(float(max(size)), 2.0)
    return np.array([p.max(), entropy / 5, amount / 3, n > 0, trusted, largest, min(size[2], 2.0)], np.float32)
