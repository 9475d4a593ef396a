"""All figures of a habit dataset: its text, its placements, its homes, and retrieval from it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ucon.evaluation.datasets.homes_of_habits import Offer, Retrieval, measure_retrieval, offer_of_scenes
from ucon.evaluation.datasets.placements import placement_statistics
from ucon.evaluation.datasets.sentences import near_duplicates, text_statistics
from ucon.habits import HabitDataset
from ucon.habits.knowledge import MODES, Mode
from ucon.retrieval import DenseRetriever, dataset_vectors
from ucon.scenes import SCENES


@dataclass(frozen=True)
class Measures:
    """Figures of a dataset (JSON-ready), with the data that plots need."""

    dataset: HabitDataset
    figures: dict[str, Any]
    offer: Offer
    retrieval: Mapping[Mode, Retrieval]


def measure(dataset: HabitDataset, scenes: Sequence[str] = SCENES) -> Measures:
    """Measure everything. A dataset other than the habit book is encoded first, once, which takes minutes.

    Args:
        dataset: the dataset that is measured.
        scenes: canonical scenes for knowledge bases; a dataset bound to scenes is measured in its own.
    """
    dense = DenseRetriever()
    vectors = dataset_vectors(dataset, dense.encoder)
    retrieval = {mode: measure_retrieval(dataset, dense, mode) for mode in MODES}
    offer = offer_of_scenes(dataset, scenes)
    found = {mode: one.figures() for mode, one in retrieval.items()}
    # Figures of the default mode are also at the top level, under the names that scripts rely on.
    default = {name: value for name, value in found["category"].items() if not name.startswith("supporting")}
    figures = {
        "dataset": dataset.name,
        "sha256": dataset.sha256,
        **text_statistics(dataset),
        "near_duplicates": near_duplicates(vectors),
        **placement_statistics(dataset),
        **default,
        "retrieval": found,
        "scenes": _scene_figures(offer),
    }
    return Measures(dataset, figures, offer, retrieval)


def _scene_figures(offer: Offer) -> dict[str, Any]:
    """Target categories per scene, and sizes of the knowledge bases by mode."""
    counts = list(offer.categories.values())
    if not any(counts):
        return {}
    sizes = {}
    for mode, by_scene in offer.sizes.items():
        values = np.concatenate(list(by_scene.values()))
        sizes[mode] = {"mean": round(float(values.mean()), 1), "min": int(values.min()), "max": int(values.max())}
    return {
        "target_categories": {"mean": round(float(np.mean(counts)), 1), "min": min(counts), "max": max(counts)},
        "target_categories_by_scene": dict(offer.categories),
        "knowledge_base_sizes": sizes,
    }
