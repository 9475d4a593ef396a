"""Model card of a policy that learned from its own play."""

from __future__ import annotations

from collections.abc import Sequence

from ucon.learning.run.protocol import Card


def own_play_card(
    title: str, name: str, size: int, *, frames: int, episodes: int, levels: Sequence[str], dataset: str
) -> Card:
    """Text of the card: architecture, size, training episodes, levels and how to use the weights.

    Args:
        title: of the card.
        name: of the network.
        size: number of its trained parameters.
        frames: steps of its own that it learned from; 0 where nothing validated better than the start.
        episodes: number of episodes that they were drawn from.
        levels: habit levels.
        dataset: of the habits.
    """
    learned = (
        f"Learned from {frames:,} steps of its own in episodes drawn from {episodes} of the `train` part; habit levels "
        f"{', '.join(levels)}."
        if frames
        else "As it was before training: nothing that was learned validated better."
    )
    return Card(
        title,
        f"`{name}`, {size:,} trained parameters. {learned} Validation episodes chose the state; "
        "`test` was not touched.\n\n"
        f"Use: `python eval.py agent={name} agent.checkpoint=RUN`.\n\n"
        "It learned in simulated homes what a success is worth there; in homes unlike these it was not measured.",
        dataset,
    )
