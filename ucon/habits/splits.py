"""Which categories a reader may learn from: train, val and test, by category.

The official release's unseen categories are in the test part wherever the habit book holds them; the rest is drawn by
a hash of the name, so that a new category never moves an old one. Priors and readers are fitted on ``train`` only.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Literal

Split = Literal["train", "val", "test"]
SPLITS: tuple[Split, ...] = ("train", "val", "test")
TEST_PERCENT, VAL_PERCENT = 12, 12


@cache
def _unseen() -> frozenset[str]:
    return frozenset(json.loads((Path(__file__).parent / "data" / "unseen_categories.json").read_text()))


def category_split(category: str) -> Split:
    """The part that a target category belongs to, known or not."""
    if category in _unseen():
        return "test"
    value = int(hashlib.sha256(f"split:{category}".encode()).hexdigest()[:8], 16) % 100
    if value < TEST_PERCENT:
        return "test"
    return "val" if value < TEST_PERCENT + VAL_PERCENT else "train"


def split_categories(categories: Iterable[str], split: Split) -> tuple[str, ...]:
    """Those of ``categories`` that lie in a part, sorted."""
    return tuple(sorted(c for c in categories if category_split(c) == split))
