"""A habit dataset in homes: target categories per scene, sizes of knowledge bases, and retrieval from them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import ConfigError
from ucon.core.rng import stream
from ucon.habits import Entry, HabitDataset, KnowledgeBase, household
from ucon.habits.knowledge import MODES, Mode
from ucon.retrieval import Retriever, mrr
from ucon.scenes import SCENES

#: Number of categories of a knowledge base, as in an episode.
CATEGORIES = 20
#: Recall is measured among the first 1 to this many habits.
LONGEST = 60
_KNOWLEDGE_BASES = 60
_TARGETS = 5
_DRAWS_A_SCENE = 10

Sizes = Mapping[Mode, Mapping[str, NDArray[np.int64]]]
"""Sizes of seeded knowledge bases, (draws,), by mode and scene."""


@dataclass(frozen=True)
class Offer:
    """What the canonical scenes allow with a dataset: target categories and sizes of knowledge bases."""

    categories: Mapping[str, int]
    """Number of target categories with a household in each scene."""
    sizes: Sizes


@dataclass(frozen=True)
class Retrieval:
    """How well a retriever finds a target's own habits, over seeded knowledge bases of 20 categories."""

    mrr: float
    recall: NDArray[np.float64]
    """(60,) share of the target's habits among the first 1 to 60."""
    supporting: NDArray[np.float64] | None
    """(60,) the same for habits that support a placement; None where supports are unknown."""
    size: float
    """Mean number of habits of the knowledge bases."""

    def figures(self) -> dict[str, float | None]:
        """JSON-ready figures, rounded to four digits."""
        supporting = None if self.supporting is None else round(float(self.supporting[19]), 4)
        return {
            "mrr": round(self.mrr, 4),
            "recall_at_10": round(float(self.recall[9]), 4),
            "recall_at_20": round(float(self.recall[19]), 4),
            "supporting_recall_at_20": supporting,
            "knowledge_base_size": round(self.size, 1),
        }


def offer_of_scenes(dataset: HabitDataset, scenes: Sequence[str] = SCENES) -> Offer:
    """Target categories of canonical scenes, and sizes of ten knowledge bases of 20 categories in each.

    Args:
        dataset: the dataset that is measured; one bound to scenes is measured only in those.
        scenes: canonical scenes.
    """
    from ucon.sim.cache import load_house
    from ucon.task.making.living import living_in

    categories: dict[str, int] = {}
    sizes: dict[Mode, dict[str, NDArray[np.int64]]] = {mode: {} for mode in MODES}
    for scene in [name for name in scenes if name in (dataset.scenes or scenes)]:
        living = living_in(load_house(scene), dataset)
        categories[scene] = len(living)
        draws = [
            stream(0, "statistics", "sizes", scene, k).permutation(sorted(living))[:CATEGORIES]
            for k in range(_DRAWS_A_SCENE)
        ]
        drawn = [{str(n): [host.entry for host in living[str(n)]] for n in names} for names in draws]
        for mode in MODES:
            found = [len(KnowledgeBase.build(dataset, one, k, mode)) for k, one in enumerate(drawn) if one]
            sizes[mode][scene] = np.asarray(found, np.int64)
    return Offer(categories, sizes)


def measure_retrieval(dataset: HabitDataset, retriever: Retriever, mode: Mode = "category") -> Retrieval:
    """Retrieval with the paper's query: five targets in each of 60 knowledge bases of 20 categories.

    Args:
        dataset: the habits.
        retriever: the retriever that is measured.
        mode: of the knowledge bases.

    Raises:
        ConfigError: no entry fits any scene.
    """
    homes = _households(dataset)
    if not homes:
        raise ConfigError(f"dataset '{dataset.name}': no entry fits any of the scenes; remove their kinds of place")
    ranks, sizes = [], []
    recall: dict[str, list[NDArray[np.float64]]] = {"own": [], "supporting": []}
    for number in range(_KNOWLEDGE_BASES):
        people = homes[number % len(homes)]
        rng = stream(0, "statistics", "retrieval", number)
        names = [str(name) for name in rng.permutation(sorted(people))[:CATEGORIES]]
        base = KnowledgeBase.build(dataset, {name: people[name] for name in names}, number, mode)
        sizes.append(len(base))
        for name in names[:_TARGETS]:
            ranking, own = retriever.rank(name, base), base.rows_about(name)
            supporting = [row for row in own if dataset.habits[row].supports]
            ranks.append(mrr(ranking, own))
            recall["own"].append(_recall(ranking, own))
            if supporting:
                recall["supporting"].append(_recall(ranking, np.asarray(supporting, np.int32)))
    return Retrieval(
        mrr=float(np.mean(ranks)),
        recall=np.mean(recall["own"], 0),
        supporting=np.mean(recall["supporting"], 0) if dataset.labelled and recall["supporting"] else None,
        size=float(np.mean(sizes)),
    )


def _households(dataset: HabitDataset) -> list[dict[str, tuple[Entry, ...]]]:
    """Households of each scene, without scenes that have none (a book about offices has none in a flat)."""
    from ucon.sim.cache import load_house
    from ucon.task.making.living import home_kinds

    def kinds(scene: str) -> tuple[str, ...]:
        return () if dataset.scenes else home_kinds(load_house(scene).spec)

    found = [household(scene, dataset, kinds=kinds(scene)) for scene in dataset.scenes or SCENES]
    return [people for people in found if people]


def _recall(ranking: NDArray[np.int32], relevant: NDArray[np.int32]) -> NDArray[np.float64]:
    """Recall among the first 1 to 60, (60,); a shorter ranking keeps its last value."""
    found = np.isin(ranking[:LONGEST], relevant).cumsum() / len(relevant)
    return np.pad(found, (0, LONGEST - len(found)), mode="edge")
