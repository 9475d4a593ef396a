"""The fixed sets: home, seed and target categories of every episode of a named set.

``test``: 250 episodes in each of seen / unseen category x seen / unseen scene, all households new. ``test_large``:
2,000 more episodes like those of ``test``, for differences too small to show in 1,000. Seen scenes are the canonical
layouts of the 20 official training scenes; unseen ones are the two official test scenes and generated homes from a
reserved range of seeds. ``val`` has 400 episodes and ``mini`` 50: their target categories are in neither ``train`` nor
``test``, and half of their episodes are in the seen scenes, half in generated homes kept for them.

``test_context`` has 1,000 episodes in the homes of ``test``, ``val_context`` 200 in those of ``val``. Their targets are
the objects of the book's second part (:func:`ucon.habits.book.contexts_book`), whose habits name different places in
different contexts, and each episode states its context.

``train``: 4,000 episodes to learn from, in 800 homes that no other set uses (other furnishings of the seen scenes, and
generated homes), with targets and households from the ``train`` part alone.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

from ucon.core.errors import ConfigError, UconError, brief, unknown_name
from ucon.core.rng import derived_seed
from ucon.habits.splits import Split, entry_parts, split_categories
from ucon.habits.types import HabitDataset
from ucon.scenes import SCENES, scene_split
from ucon.task.making.living import contradictory
from ucon.task.making.sampler import EpisodeSampler
from ucon.task.rules import PAPER
from ucon.task.sets import set_name

#: For each test set: number of episodes in each cell, and number of generated homes.
TEST_SETS = {"test": (250, 20), "test_large": (500, 40)}
#: Sets whose episodes all state a context, and the sets whose homes they use.
CONTEXT_SETS = {"test_context": "test", "val_context": "val"}
#: First seed of the generated homes kept for testing; validation homes start 10,000 below.
RESERVED_SEED = 900_000
TRAIN = "train"
#: Of ``train``: episodes in each of two cells, other furnishings of each seen scene, generated homes, their first seed.
N_TRAIN, N_VARIANTS, N_GENERATED, TRAIN_SEED = 2000, 20, 400, 100_000
OFFICIAL, N_OFFICIAL = "official", 2000
#: Labels of official episodes. Held-out (scene, category) pairs are never trained on.
LEARNED, HELD_OUT = "official/learned", "official/held_out"
#: The set that has held-out pairs only.
OFFICIAL_HELD_OUT, N_HELD_OUT = "official_held_out", 1000
OFFICIAL_SETS = {OFFICIAL: N_OFFICIAL, OFFICIAL_HELD_OUT: N_HELD_OUT}
#: Least number of held-out categories of a scene; with fewer, its episodes would be too much alike.
MIN_HELD_OUT = 3
PLANNED_HOMES = ("house", "flat", "house", "flat", "office", "house", "flat", "restaurant", "house", "shop")


@dataclass(frozen=True)
class Cell:
    """One group of episodes of a set.

    Attributes:
        label: name of the group.
        category_split: targets are of this part of the categories.
        part: draw the household from the entries that this part may use (:data:`ucon.habits.splits.PARTS_USED`).
        scenes: names of homes, used in turn.
        count: number of episodes.
    """

    label: str
    category_split: Split
    part: Split
    scenes: tuple[str, ...]
    count: int


@dataclass(frozen=True)
class Order:
    """What to sample for one episode.

    Attributes:
        id: of the episode.
        scene: name of its home.
        seed: of the sampler.
        split: label of its group.
        targets: categories that may be the target; None: all.
        part: draw the household from the entries that this part may use; None: from all.
    """

    id: str
    scene: str
    seed: int
    split: str
    targets: tuple[str, ...] | None
    part: Split | None = None


def set_cells(name: str) -> tuple[Cell, ...]:
    """The groups of a named set.

    Raises:
        ConfigError: no such set, or an official set, which has no groups.
    """
    seen = tuple(scene for scene in SCENES if scene_split(scene) == "seen")
    if name == "val_context":
        return tuple(replace(cell, count=100) for cell in set_cells("val"))
    if name in CONTEXT_SETS:
        return set_cells(CONTEXT_SETS[name])
    if name in TEST_SETS:
        count, homes = TEST_SETS[name]
        unseen = tuple(scene for scene in SCENES if scene_split(scene) == "unseen") + generated(RESERVED_SEED, homes)
        pairs = [
            (f"{c}_category/{s}_scene", split, scenes)
            for c, split in (("seen", "train"), ("unseen", "test"))
            for s, scenes in (("seen", seen), ("unseen", unseen))
        ]
        return tuple(Cell(label, split, "test", scenes, count) for label, split, scenes in pairs)  # type: ignore[arg-type]
    if name == TRAIN:
        variants = tuple(f"{scene}~{number}" for number in range(1, N_VARIANTS + 1) for scene in seen)
        return (
            Cell("train_category/variant_scene", "train", "train", variants, N_TRAIN),
            Cell("train_category/generated_scene", "train", "train", generated(TRAIN_SEED, N_GENERATED), N_TRAIN),
        )
    if name in ("val", "mini"):
        count = 200 if name == "val" else 25
        return (
            Cell("val_category/seen_scene", "val", "val", seen, count),
            Cell("val_category/val_scene", "val", "val", generated(RESERVED_SEED - 10_000, 20), count),
        )
    raise ConfigError(
        unknown_name("episode set to make", name, (*TEST_SETS, "val", "mini", TRAIN, *CONTEXT_SETS, *OFFICIAL_SETS))
    )


def generated(first_seed: int, count: int) -> tuple[str, ...]:
    """Names of generated homes of mixed kinds.

    Args:
        first_seed: of the first home.
        count: number of homes.
    """
    return tuple(f"procedural:{PLANNED_HOMES[k % len(PLANNED_HOMES)]}:{first_seed + k}" for k in range(count))


def set_orders(
    name: str,
    dataset: HabitDataset,
    task: str = PAPER.name,
    *,
    context: bool = False,
    left_out: Callable[[str], None] = lambda line: None,
) -> Iterator[Order]:
    """What to sample for every episode of a named set.

    Scenes are used in turn. Scenes and seeds are the same under all rules, so that the versions of a set differ only in
    their rules. The ``official`` sets need a dataset whose entries are bound to scenes, such as the official release.

    Args:
        name: of the set.
        dataset: the habits.
        task: rule set.
        context: whether the episodes state their context.
        left_out: called with one line for each scene that is not a home or where no category can be placed.

    Raises:
        ConfigError: no such set, or the dataset does not suit it.
    """
    label = set_name(name, task, context=context)
    if name in OFFICIAL_SETS:
        yield from _official_orders(name, dataset, label, left_out)
        return
    for cell in set_cells(name):
        targets = split_categories(_targets(name, dataset), cell.category_split)
        for number in range(cell.count):
            scene = cell.scenes[number % len(cell.scenes)]
            seed = derived_seed(0, "set", name, cell.label, number) % (1 << 31)
            yield Order(f"{label}/{cell.label}/{number:03d}", scene, seed, cell.label, targets, cell.part)


def _targets(name: str, dataset: HabitDataset) -> Sequence[str]:
    """Target categories of a set: all of the dataset's, or those whose habits contradict each other.

    Raises:
        ConfigError: the set needs contradictory habits, and the dataset has no entries with parts of their own.
    """
    if name not in CONTEXT_SETS:
        return dataset.categories
    found = {entry.category for entry in dataset.entries if entry.id in dataset.parts and contradictory(entry)}
    if not found:
        raise ConfigError(f"episode set '{name}' with dataset '{dataset.name}': it is made from the shipped book only")
    return sorted(found)


def _official_orders(name: str, dataset: HabitDataset, label: str, left_out: Callable[[str], None]) -> Iterator[Order]:
    """The orders of an ``official`` set."""
    if not dataset.scenes:
        raise ConfigError(
            f"episode set '{name}' with dataset '{dataset.name}', whose entries belong to no scene; "
            "give the official release: --habits PATH"
        )
    sampler, parts = EpisodeSampler(dataset), entry_parts(dataset)
    held = {(e.scene, e.category) for e in dataset.entries if parts[e.id] == "test"}
    targets: dict[str, dict[str, tuple[str, ...]]] = {}
    for scene in dataset.scenes:
        try:
            hosted = sampler.target_categories(scene)
        except UconError as error:
            left_out(f"{brief(scene)}: left out, {error}")
            continue
        if not hosted:
            left_out(f"{scene}: left out, no category of dataset '{dataset.name}' can be placed there")
            continue
        unseen = tuple(name for name in hosted if (scene, name) in held)
        learned = tuple(name for name in hosted if (scene, name) not in held)
        if not learned and len(unseen) < MIN_HELD_OUT:
            left_out(f"{scene}: left out, everything that can be placed there is held out, fewer than {MIN_HELD_OUT}")
            continue
        targets[scene] = {HELD_OUT: unseen if len(unseen) >= MIN_HELD_OUT else (), LEARNED: learned}
    only_held = name == OFFICIAL_HELD_OUT
    scenes = [scene for scene, of in targets.items() if of[HELD_OUT] or not only_held]
    if not targets:
        raise ConfigError(f"episode set '{name}': too little of '{dataset.name}' can be placed in any of its scenes")
    if not scenes:
        raise ConfigError(f"episode set '{name}': no scene of '{dataset.name}' has {MIN_HELD_OUT} categories held out")
    for number in range(OFFICIAL_SETS[name]):
        scene = scenes[number % len(scenes)]
        odd = only_held or number // len(scenes) % 2
        kind = HELD_OUT if targets[scene][HELD_OUT] and (odd or not targets[scene][LEARNED]) else LEARNED
        seed = derived_seed(0, "set", name, number) % (1 << 31)
        yield Order(f"{label}/{scene}/{number:04d}", scene, seed, kind, targets[scene][kind])
