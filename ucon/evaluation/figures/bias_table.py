"""Position bias of language models in words and tables (:mod:`ucon.evaluation.kept.position_bias`)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ucon.evaluation.kept.position_bias import PositionBias

HEAD = ("% chosen by place in the list", "options", "choices", "1st, 2nd, ...", "same in both orders", "by name")


def bias_rows(label: str, summary: Mapping[str, Any]) -> list[tuple[str, ...]]:
    """Rows of the table with the columns :data:`HEAD`, one for each length of list from two options up.

    Args:
        label: of the run.
        summary: content of its ``summary.json``.

    Raises:
        DataError: it is malformed.
    """
    bias = PositionBias.in_summary(summary)
    if bias is None:
        return []
    agreement = "-" if bias.agreement is None else f"{100 * bias.agreement:.0f}"
    named = ", ".join(f"{name} {100 * share:.0f}" for name, share in bias.named.items()) or "-"
    return [
        (label, str(n), str(count), ", ".join(f"{100 * share:.0f}" for share in shares), agreement, named)
        for n, (count, shares) in bias.chosen.items()
        if n > 1
    ]


def bias_line(summary: Mapping[str, Any]) -> str:
    """One line about the longest list; "" where no model read one.

    Args:
        summary: content of ``summary.json``.
    """
    rows = bias_rows("", summary)
    if not rows:
        return ""
    _, n, count, shares, agreement, named = rows[-1]
    twice = f"; the same in both orders: {agreement} %" if agreement != "-" else ""
    names = f"; by name: {named} %" if named != "-" else ""
    return f"places in a list of {n} chosen by the model: {shares} % of {count}{twice}{names}"
