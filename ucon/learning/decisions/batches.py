"""Batches of kept decisions as the network takes them, and their mirror images."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import torch
from numpy.typing import NDArray
from torch import Tensor

from ucon.learning.decisions.decisions import Decisions
from ucon.search.search_tokens import THING_AHEAD
from ucon.search.view_tokens import AHEAD, VISITED

#: Columns of a view's heading relative to the agent's.
_TURNED: Final = slice(VISITED + 1, VISITED + 5)
#: Headings relative to the agent's (ahead, left, back, right) in a mirror.
_MIRRORED: Final = (0, 3, 2, 1)


def batch_of(decisions: Decisions, rows: NDArray[Any]) -> dict[str, Tensor]:
    """Some decisions with their text, (n, ...) by name.

    Args:
        decisions: to take them from.
        rows: (n,) their numbers.
    """
    frames = {name: torch.from_numpy(values[rows]) for name, values in decisions.frames.items()}
    of = decisions.episode[rows]
    return frames | {name: torch.from_numpy(values[of]) for name, values in decisions.text.items()}


def mirrored(frames: Mapping[str, Tensor]) -> dict[str, Tensor]:
    """The same decisions in homes that are mirrored left to right.

    Args:
        frames: of :func:`batch_of`.
    """
    views, things, frontiers = (frames[name].clone() for name in ("views", "things", "frontiers"))
    views[..., AHEAD.stop - 1] *= -1
    views[..., _TURNED] = views[..., _TURNED][..., list(_MIRRORED)]
    things[..., THING_AHEAD.stop - 1] *= -1
    frontiers[..., 1] *= -1
    image = frames["map"].flip(-1)
    return {**frames, "map": image, "views": views, "things": things, "frontiers": frontiers}
