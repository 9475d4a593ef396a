"""The labels among which L3MVN asks for its target: the target and other categories of the catalogue."""

from __future__ import annotations

from ucon.core.rng import stream
from ucon.language.phrases import phrase
from ucon.objects.catalogue import catalogue


def label_set(target: str, size: int) -> tuple[str, ...]:
    """The target and other movable categories, always the same for a target.

    Args:
        target: its category.
        size: number of labels.

    Returns:
        Names with spaces, the target first.
    """
    book = catalogue()
    others = [name for name in book.names if book[name].role == "movable" and name != target]
    drawn = stream(0, "l3mvn", target).choice(len(others), size=min(size - 1, len(others)), replace=False)
    return (phrase(target), *(phrase(others[k]) for k in sorted(drawn.tolist())))
