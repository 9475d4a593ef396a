"""How a lost search ended, in words."""

from __future__ import annotations

from collections.abc import Sequence

from ucon.evaluation.kept.decisions import DecisionRecord
from ucon.evaluation.kept.record import EpisodeRecord


def why_lost(record: EpisodeRecord, decisions: Sequence[DecisionRecord]) -> str:
    """Why a search did not find its target, in one line.

    Args:
        record: of the search.
        decisions: decisions that the agent made in it; () where none are kept.

    Returns:
        The reason; "" for a search that found its target.
    """
    steps, seen = record.steps, record.first_seen_step
    at = f" ({decisions[-1].words})" if decisions else ""
    sight = "never seen before" if seen < 0 else f"seen first at step {seen}"
    return {
        "none": "",
        "never_seen": f"never seen; steps ran out at {steps}",
        "seen_not_reached": f"seen first at step {seen}, but not approached; steps ran out at {steps}",
        "container_never_opened": f"the container that holds it was never opened; steps ran out at {steps}",
        "stopped_early": f"Done was said elsewhere at step {steps}{at}; {sight}",
        "out_of_steps": f"in view and within reach, but Done was not said there; steps ran out at {steps}",
    }[record.failure_cause]
