"""Reasons why an object cannot be placed: a fixed list, so that failures can be counted."""

from __future__ import annotations

from typing import Literal, get_args

from ucon.core.errors import PlacementError

Reason = Literal[
    "absent_anchor",
    "same_object",
    "implausible",
    "not_a_support",
    "not_a_container",
    "no_room_under",
    "too_large",
    "no_free_slot",
    "blocks_path",
    "unstable",
    "not_importable",
]
REASONS: tuple[Reason, ...] = get_args(Reason)


class RefusedError(PlacementError):
    """A placement that is not possible; ``reason`` is one of :data:`REASONS`."""

    def __init__(self, reason: Reason, text: str) -> None:
        super().__init__(f"{text} ({reason})")
        self.reason: Reason = reason
