"""How a category is said: by its name, and in the paper's query for habits."""

from __future__ import annotations

from typing import Final

#: The paper's query.
QUERY: Final = "Please retrieve the habit about {target}."


def phrase(category: str) -> str:
    """A category as people write it: ``coffee_table`` is "coffee table"."""
    return category.replace("_", " ")


def query_text(target: str) -> str:
    """The paper's query for a target category."""
    return QUERY.format(target=phrase(target))
