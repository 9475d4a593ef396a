"""The fixed sets of lives: home, seed and targets of each.

``lives_test``: 10 lives in each of seen / unseen category x seen / unseen scene, in homes of the episode set ``test``;
in half of them the habits of some possessions change. ``lives_val`` (20 lives) and ``lives_mini`` (4) use homes and
categories of ``val``. ``lives_long``: 4 lives of 50 days. ``lives_train``: an endless sequence of lives to learn from,
with homes and entries of the part ``train`` only.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import count
from typing import Final

from ucon.core.errors import ConfigError, unknown_name
from ucon.core.rng import derived_seed
from ucon.habits.splits import split_categories
from ucon.habits.types import HabitDataset
from ucon.lives.making.make_life import LifeOrder
from ucon.task.making.set_plans import TRAIN, set_cells

#: For each set: the episode set whose homes and categories it uses, lives in each cell of that set, and days.
LIFE_SETS: Final = {
    "lives_mini": ("val", 2, 14),
    "lives_val": ("val", 10, 14),
    "lives_test": ("test", 10, 14),
    "lives_long": ("test", 1, 50),
}
#: The set of lives to learn from.
ENDLESS: Final = f"lives_{TRAIN}"


def life_orders(name: str, dataset: HabitDataset) -> Iterator[LifeOrder]:
    """What to make for every life of a named set; scenes are used in turn. ``lives_train`` is endless.

    Args:
        name: name of the set.
        dataset: the habits.

    Raises:
        ConfigError: no such set.
    """
    if name == ENDLESS:
        yield from (train_order(number, dataset) for number in count())
    if name not in LIFE_SETS:
        raise ConfigError(unknown_name("set of lives", name, (*LIFE_SETS, ENDLESS)))
    like, lives, days = LIFE_SETS[name]
    made = 0
    for cell in set_cells(like):
        targets = split_categories(dataset.categories, cell.category_split)
        for number in range(lives):
            scene = cell.scenes[number % len(cell.scenes)]
            seed = derived_seed(0, "lives", name, cell.label, number) % (1 << 31)
            label, changes = f"{name}/{cell.label}/{number:02d}", bool(made % 2)
            yield LifeOrder(label, scene, seed, cell.label, targets, cell.part, days, changes)
            made += 1


def train_order(number: int, dataset: HabitDataset, days: int = 14) -> LifeOrder:
    """The order of a life of ``lives_train``; there is one for every number.

    Args:
        number: number of the life, from 0.
        dataset: the habits.
        days: length of the life.
    """
    cells = set_cells(TRAIN)
    cell = cells[number % len(cells)]
    scene = cell.scenes[number // len(cells) % len(cell.scenes)]
    targets = split_categories(dataset.categories, cell.category_split)
    seed = derived_seed(0, "lives", TRAIN, number) % (1 << 31)
    name, changes = f"{ENDLESS}/{number:05d}", bool(number // 2 % 2)
    return LifeOrder(name, scene, seed, cell.label, targets, cell.part, days, changes)
