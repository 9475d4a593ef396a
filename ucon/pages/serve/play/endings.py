"""A finished search in words and on a plan: found or lost, the person's path and the shortest one, the whole home."""

from __future__ import annotations

from typing import Any

import numpy as np

from ucon.envs.knowledge import HabitSource
from ucon.envs.ucon_env import UcONEnv
from ucon.evaluation.kept.record import EpisodeRecord
from ucon.pages.home_plan import footprint, placed_in, plan_of
from ucon.pages.serve.house_by_name import house_by_name
from ucon.task.episode import Episode
from ucon.task.robot.rig import RobotRig
from ucon.task.rules import task_rules
from ucon.task.spoken import target_place


def ended(episode: Episode, record: EpisodeRecord, source: HabitSource, rig: RobotRig | None = None) -> dict[str, Any]:
    """What is shown after an episode; nothing of it may be shown before.

    Args:
        episode: the episode that was played.
        record: its record.
        source: the habits it was played with.
        rig: the robot's rig, where a robot was played.

    Returns:
        Figures, words, ``plan`` and ``placed`` as ``data/plan.js`` draws them, the paths as points in metres, and
        ``turn``, the quarter turns clockwise that align the plan with the map of what was seen.
    """
    house = house_by_name(episode.scene)
    own, env = _walked(episode, record.actions, source, rig)
    boxes, room = env.search.world.boxes, house.spec.rooms[episode.target_object.room].type
    opened = [footprint(boxes[k]) for k in np.flatnonzero(env.search.opened).tolist()]
    shown = {
        "episode": episode.id,
        "home": episode.scene,
        "target": record.target.replace("_", " "),
        "success": record.success,
        "why": _why_lost(record),
        "place": f"{target_place(episode)} in the {room.replace('_', ' ')}",
        "steps": record.steps,
        "path_m": record.path_length_m,
        "shortest_m": record.shortest_path_m,
        "spl": record.spl,
        "collisions": record.collisions,
        "opens": record.opens,
        "plan": plan_of(house),
        "placed": placed_in(episode.arrangement, boxes, house.n_instances),
        "target_box": footprint(boxes[env.search.target]),
        "opened": [box for box in opened if box is not None],
        "path": own,
        "heading": env.search.pose.heading,
        "turn": episode.start.heading % 4,
    }
    env.close()
    exact = RobotRig.exact() if task_rules(episode.task).continuous else None
    shortest, again = _walked(episode, episode.solution, source, exact)
    again.close()
    return shown | {"shortest": shortest}


def _why_lost(record: EpisodeRecord) -> str:
    """Why a search was lost, in words for the person who searched; "" where it was not."""
    target, steps, seen = record.target.replace("_", " "), record.steps, record.first_seen_step
    in_view = f"The {target} was first in view at step {seen}"
    return {
        "none": "",
        "never_seen": f"The {target} was never in view, and your {steps} steps ran out.",
        "seen_not_reached": f"{in_view}, but you did not come near it, and your {steps} steps ran out.",
        "container_never_opened": f"You never opened what the {target} is in, and your {steps} steps ran out.",
        "stopped_early": f"You said Found it at step {steps}, but the {target} was not in view within reach."
        + (f" {in_view}." if seen >= 0 else ""),
        "out_of_steps": f"The {target} was in view within reach, but you did not say so; your {steps} steps ran out.",
    }[record.failure_cause]


def _walked(
    episode: Episode, actions: str, source: HabitSource, rig: RobotRig | None
) -> tuple[list[list[float]], UcONEnv]:
    """Carry out actions without pictures.

    Returns:
        Nodes of the path in metres, and the environment at its end.
    """
    env = UcONEnv([episode], habit_level="none", source=source, task=episode.task, rig=rig, observe="symbolic")
    env.reset(options={"episode": episode})
    for digit in actions:
        env.step(int(digit))
    return [[round(float(x), 3), round(float(y), 3)] for x, y in env.ledger.path_xy], env
