"""Compiles the kernels of a searching agent by running all of its perception for a few steps."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import gymnasium as gym
import numpy as np

from ucon.perception.mapping.fine_frontiers import fine_frontiers
from ucon.perception.mapping.fine_map import FineMap
from ucon.perception.mapping.planner import Planner
from ucon.perception.mapping.semantic_map import SemanticMap, frame_depth
from ucon.perception.places.neighbourhood import interest
from ucon.perception.places.place_kernels import INSIDE
from ucon.perception.places.sight import Sight
from ucon.perception.places.target_places import Places
from ucon.perception.views.candidates import candidates
from ucon.perception.views.heading_candidates import in_view
from ucon.perception.views.viewpoints import Expectation, Viewpoints


def look_around(env: gym.Env[Any, Any], actions: Sequence[int]) -> SemanticMap:
    """Play actions in the first episode of an environment and run the whole of perception on every frame.

    Args:
        env: an environment with a detector and ``nav`` in its info.
        actions: the actions to play.

    Returns:
        The map of the frames.
    """
    obs, info = env.reset(options={"episode": 0})
    errors = info.get("detector_errors")
    sight = None if errors is None else Sight.of(errors, str(info["target"]))
    known, places, planner, viewpoints = SemanticMap.of(info), Places(0.1, sight), Planner(info["nav"]), Viewpoints(3.0)
    fine = FineMap()
    for action in actions:
        known.update(obs, info)
        places.refresh(known)
        active = places.searched(~known.opened[: known.n_tracks])
        places.look(known, frame_depth(obs, info), active, 3.0, 0.1)
        fine.update(known.view, frame_depth(obs, info))
        planner.update(known)
        fine_frontiers(fine, known, planner)
        in_view(known, planner, known.view, (1.0, 5.0))
        candidates(known, planner, places)
        mass = np.ones((known.n_tracks, 4))
        closed = np.unique(places.track[places.relation == INSIDE]).astype(np.int64)
        expected = Expectation(mass, 1.0, 0.1, interest(known, ("fridge",), np.ones(1)))
        best, _ = viewpoints.choose(known, planner, places, expected, closed)
        if best is not None:
            planner.plan(best.view)
        viewpoints.lower_expectations(known, places, expected, closed)
        obs, _, _, _, info = env.step(action)
    return known
