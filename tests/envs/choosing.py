"""Helpers to play environments of choices: random choices, whole episodes, and homes without the target."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from ucon.task.episode import Episode


def at_random(draw: np.random.Generator) -> Callable[[Any], int]:
    """Chooses at random among the rows that the mask offers."""
    return lambda obs: int(draw.choice(np.flatnonzero(obs["action_mask"])))


def rollout(env: Any, choose: Callable[[Any], int], **options: Any) -> list[Any]:
    """Everything that reset and the steps of an episode returned."""
    seen: list[Any] = [env.reset(**options)]
    while len(seen) < 2 or not (seen[-1][2] or seen[-1][3]):
        seen.append(env.step(choose(seen[-1][0])))
    return seen


def gone(episode: Episode) -> Episode:
    """The same episode with the target moved out of the home."""
    objects = list(episode.arrangement.objects)
    objects[episode.target] = replace(objects[episode.target], position=(0.0, 0.0, -50.0))
    return replace(episode, arrangement=replace(episode.arrangement, objects=tuple(objects)))
