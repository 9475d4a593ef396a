"""How often orders among the habits sway where ``belief`` expects the target: ``python -m tests.envs.sway``.

``python -m tests.envs.sway SET EVERY LEVEL`` reads the habits of every EVERY-th episode of a set twice: with orders
added, as many as there are sentences that name a place of the target, and without them. Prints one line of JSON; the
figures are means over the episodes in which the agent was given any orders.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence

import numpy as np

from ucon.envs.knowledge import HabitSource, Knowledge
from ucon.envs.told.falsehoods import ORDERS, place_now, things_of
from ucon.envs.told.orders import ordered_places
from ucon.perception.belief.from_habits import ReadHabits
from ucon.task.episode import Episode
from ucon.task.sets import load_episodes


def sent_to(knowledge: Knowledge, first: int) -> set[str]:
    """Things that the orders send the agent to; rows from ``first`` on are orders."""
    found = set()
    for row in knowledge.rows[knowledge.rows >= first].tolist():
        dataset = knowledge.base.dataset
        number = dataset.row_entry[row]
        place = ordered_places(dataset.entries[number])[row - dataset.first_row[number]]
        found |= set() if place is None else {place}
    return found


def sway(episodes: Sequence[Episode], level: str) -> dict[str, float]:
    """Measure how orders change the belief over each home's things; the agent goes to the most probable one first."""
    told, untold, locate = HabitSource(falsehoods=ORDERS, false_share=1.0), HabitSource(), ReadHabits()
    first, values = len(untold.dataset), []
    for episode in episodes:
        given = told.knowledge(episode, level)
        there, ordered = things_of(episode), sent_to(given, first)
        if not (given.rows >= first).any():
            continue
        right = place_now(untold.dataset, episode).anchor
        row = [float((given.rows >= first).sum()), float(len(ordered))]
        for texts in (untold.knowledge(episode, level).texts, given.texts):
            found = locate({"target": episode.target_category, "habits": texts, "habit_level": level})
            p = {name: float(found.p[k].sum()) for k, name in enumerate(found.names) if name in there}
            best = max(p, key=lambda name: (p[name], name))
            row += [best in ordered, best == right, sum(p.get(name, 0.0) for name in ordered) / sum(p.values())]
        values.append(row)
    if not values:
        return {"episodes": len(episodes), "with_orders": 0}
    mean = np.mean(values, axis=0)
    names = (
        "orders_given", "places_ordered",
        "first_is_ordered_without", "first_is_right_without", "belief_in_ordered_without",
        "first_is_ordered_with", "first_is_right_with", "belief_in_ordered_with",
    )  # fmt: skip
    return {"episodes": len(episodes), "with_orders": len(values)} | dict(zip(names, mean.tolist(), strict=True))


if __name__ == "__main__":
    sys.stdout.write(json.dumps(sway(load_episodes(sys.argv[1])[:: int(sys.argv[2])], sys.argv[3])) + "\n")
