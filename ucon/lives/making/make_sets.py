"""Makes whole sets of lives in several processes; the result does not depend on how many."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from ucon.core.errors import EpisodeError, UconError
from ucon.core.files import canonical_json, write_atomic
from ucon.core.pool import Needs, open_pool
from ucon.core.untrusted.plain_file import read_plain
from ucon.core.untrusted.strict_json import JsonError, parse_json
from ucon.habits.book import contexts_book
from ucon.habits.types import HabitDataset
from ucon.lives.life import Life
from ucon.lives.making.make_life import LifeOrder, make_life
from ucon.sim.cache import load_house

#: Added to the seed of an order for which no life could be made, and how many seeds are tried.
_RETRY_SEED_STEP, _RETRIES = 1 << 32, 4
#: Largest journal that is read, bytes.
_MAX_JOURNAL = 1 << 30


def make_lives(
    orders: Sequence[LifeOrder],
    dataset: HabitDataset | None = None,
    *,
    workers: int = 2,
    progress: Callable[[int], None] = lambda done: None,
    journal: Path | None = None,
) -> list[Life]:
    """Make a life for every order.

    Args:
        orders: what to make.
        dataset: the habits; by default the habit book with its second part, whose placements depend on the context.
        workers: processes.
        progress: called with the number of lives made.
        journal: file to which lives are appended as they are made; a repeated call does not make them again.

    Returns:
        Lives in the order of ``orders``.

    Raises:
        EpisodeError: no seed satisfies an order.
    """
    habits = dataset or contexts_book()
    done = [] if journal is None else _noted(journal, orders, habits.sha256)
    progress(len(done))

    def keep(life: Life) -> None:
        done.append(life)
        if journal is not None:
            with journal.open("a", encoding="utf-8") as notes:
                notes.write(canonical_json(life.to_json()) + "\n")
        progress(len(done))

    missing = orders[len(done) :]
    if workers <= 1:
        _begin(habits)
        for order in missing:
            keep(_make(order))
    elif missing:
        needs = Needs(tuple(sorted({order.scene for order in missing})))
        with open_pool(min(workers, len(missing)), _begin, (habits,), needs=needs) as pool:
            for life in pool.map(_make, missing):
                keep(life)
    return done


def _noted(journal: Path, orders: Sequence[LifeOrder], habits_hash: str) -> list[Life]:
    """The leading lives of a journal that match the orders; the rest of the journal is removed."""
    found: list[Life] = []
    raw = read_plain(journal, _MAX_JOURNAL) if journal.is_file() else b""
    for order, line in zip(orders, raw[: raw.rfind(b"\n") + 1].split(b"\n"), strict=False):
        try:
            life = Life.from_json(parse_json(line))
            same = (life.id, life.seed % _RETRY_SEED_STEP, life.habits_hash) == (order.id, order.seed, habits_hash)
            if not same or load_house(life.scene).spec.hash != life.home_hash:
                break
        except (JsonError, UconError):
            break
        found.append(life)
    write_atomic(journal, "".join(canonical_json(life.to_json()) + "\n" for life in found))
    return found


def _begin(dataset: HabitDataset) -> None:
    """Keep the habits in this process; they are sent to a worker once, not with every order."""
    global _dataset
    _dataset = dataset


_dataset: HabitDataset | None = None


def _make(order: LifeOrder) -> Life:
    """The life of an order; a few seeds are tried."""
    if _dataset is None:
        raise RuntimeError("a worker without habits")
    last = ""
    for again in range(_RETRIES):
        try:
            return make_life(replace(order, seed=order.seed + again * _RETRY_SEED_STEP), _dataset)
        except EpisodeError as error:
            last = str(error)
    raise EpisodeError(f"{order.id}: {last}")
