"""Short runs of lives for tests of pages."""

from __future__ import annotations

from pathlib import Path

from tests.lives.short import SMALL, short_life
from ucon.lives.life import Life
from ucon.lives.sets import save_lives
from ucon.programs.composing import eval_config
from ucon.programs.evaluating import Evaluation

#: Numbers of requests and days in each of the two lives; habits change on the last day.
EACH, DAYS = 8, 3


def two_lives() -> list[Life]:
    """Two short lives, in different homes."""
    return [short_life(number, requests=EACH, days=DAYS) for number in SMALL]


def run_of_lives(folder: Path, name: str, *words: str) -> Evaluation:
    """A run over two short lives, not played yet.

    Args:
        folder: folder for the file of lives and for the run.
        name: name of the run's folder.
        words: options of ``eval.py``, with agent and memory.
    """
    path = folder / "two.lives.xz"
    if not path.is_file():
        save_lives(two_lives(), path)
    fixed = ("task=resident", f"episodes={path}", "workers=0", "progress=false", "pictures=0")
    return Evaluation(eval_config(*fixed, *words, f"out={folder / name}"), folder / name)
