"""Continuing an interrupted set: finished episodes are not made again, and nothing else is mistaken for them."""

from __future__ import annotations

import itertools
from pathlib import Path

from ucon.habits import book
from ucon.task.making.make_sets import make_episodes
from ucon.task.making.set_plans import set_orders
from ucon.task.sets import load_episodes

ORDERS = list(itertools.islice(set_orders("mini", book()), 3))


def made(journal: Path, first: int = 0, last: int = 3) -> tuple[list[str], list[int]]:
    """Hashes of the episodes, and the counts at which progress was reported."""
    told: list[int] = []
    orders = ORDERS[first:last]
    found = make_episodes(orders, workers=1, journal=journal, progress=lambda done, _: told.append(done))
    return [episode.hash for episode in found], told


def test_what_was_made_is_not_made_anew(tmp_path: Path) -> None:
    journal = tmp_path / "mini.part"
    stored = [episode.hash for episode in load_episodes("mini")[:3]]
    assert made(journal, last=2) == (stored[:2], [1, 2])
    with journal.open("a") as notes:
        notes.write(journal.read_text()[:500])  # cut off while being written
    assert made(journal) == (stored, [3])
    assert made(journal) == (stored, [])


def test_what_belongs_to_other_orders_is_cut_off(tmp_path: Path) -> None:
    journal = tmp_path / "mini.part"
    stored = [episode.hash for episode in load_episodes("mini")[:3]]
    made(journal, last=2)
    journal.write_text("".join(reversed(journal.read_text().splitlines(keepends=True))))
    assert made(journal, last=2) == (stored[:2], [1, 2])
    journal.write_text("nonsense\n" + journal.read_text())
    assert made(journal, last=1) == (stored[:1], [1])
