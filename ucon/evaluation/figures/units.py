"""Units of the bootstrap: episodes, or whole lives, since requests of one life depend on one another."""

from __future__ import annotations

from collections.abc import Sequence

from ucon.evaluation.kept.record import EpisodeRecord


def lives_of(records: Sequence[EpisodeRecord]) -> list[str] | None:
    """Clusters for intervals: the life of each record; None for records of episodes, or of a single life."""
    found = [record.life.life for record in records if record.life is not None]
    return found if len(found) == len(records) and len(set(found)) > 1 else None
