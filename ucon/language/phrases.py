"""Categories as text: the name with spaces, and the paper's retrieval query."""

from __future__ import annotations

from typing import Final

#: The paper's retrieval query.
QUERY: Final = "Please retrieve the habit about {target}."


def phrase(category: str) -> str:
    """A category with spaces: ``coffee_table`` becomes "coffee table"."""
    return category.replace("_", " ")


def query_text(target: str, told: str = "") -> str:
    """The paper's retrieval query for a target category.

    Args:
        target: the category.
        told: words to add, such as ``when there is film night``.
    """
    return QUERY.format(target=f"{phrase(target)} {told}".rstrip())
