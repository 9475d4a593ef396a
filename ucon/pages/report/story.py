"""What happened in one episode, as plain values, found by taking the recorded actions again."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ucon.envs.ucon_env import UcONEnv
from ucon.evaluation.kept.decisions import DecisionRecord
from ucon.evaluation.kept.endings import why_lost
from ucon.evaluation.kept.record import EpisodeRecord
from ucon.pages.home_plan import placed_in
from ucon.pages.report.minds import Minds
from ucon.pages.report.pictures import Album, Pictures
from ucon.sim.render import RasterRenderer
from ucon.task.actions import Action
from ucon.task.agent import Agent
from ucon.task.episode import Episode
from ucon.task.search import Search
from ucon.task.spoken import target_place


@dataclass
class Story:
    """One episode of one run.

    Attributes:
        facts: plain values for the page; see :func:`tell`.
        pictures: WebP files, which ``facts["frames"]`` numbers.
        same: whether the agent, where one ran alongside, took the recorded actions.
    """

    facts: dict[str, Any]
    pictures: list[bytes] = field(default_factory=list)
    same: bool = True


def tell(
    env: UcONEnv,
    episode: Episode,
    record: EpisodeRecord,
    decisions: Sequence[DecisionRecord],
    *,
    agent: Agent | None,
    renderer: RasterRenderer | None,
    pictures: Pictures,
) -> Story:
    """Take the actions of an episode again and note what happened.

    Args:
        env: the environment of the run.
        episode: the episode.
        record: its record.
        decisions: what the agent chose.
        agent: runs alongside, for its beliefs; None: only the recorded actions are shown.
        renderer: of the pictures; None for none.
        pictures: ``key``: at the start, the end, decisions, openings, and where the target is first seen.

    Returns:
        The story; ``facts`` has ``place`` (the target's, in words), ``room``, ``believed`` (belief in the thing that
        keeps it: first step, step of the largest share, that share; or None), ``lost`` (why, in words), ``placed``,
        ``instances`` (number of the home's), ``target``, ``poses`` (x, y, heading, pitch per step, from the start),
        ``frames`` (number of the picture per step, -1 for none), ``opened`` (step, instance), ``blocked`` (steps),
        ``decisions``, ``beliefs`` (step, things, goal) and ``relevance`` (by given habit).
    """
    observation, info = env.reset(options={"episode": episode})
    search = env.search
    album = None if renderer is None else Album(search, renderer)
    keys = {d.step for d in decisions} | {0, record.steps, record.first_seen_step} if pictures == "key" else None
    poses, frames = [_pose(search)], [_frame(album, 0, keys)]
    opened: list[list[int]] = []
    blocked: list[int] = []
    minds = Minds(agent, search.xy, episode.start.heading)
    minds.begin(info)
    before = search.opened.copy()
    for step, digit in enumerate(map(int, record.actions), 1):
        minds.act(observation, info, digit, step - 1)
        observation, _, _, _, info = env.step(digit)
        fresh = np.flatnonzero(search.opened & ~before).tolist()
        before |= search.opened
        opened += [[step, instance] for instance in fresh]
        if digit == Action.MOVE_AHEAD and bool(observation["collision"][0]):
            blocked.append(step)
        poses.append(_pose(search))
        frames.append(_frame(album, step, None if fresh else keys))
    world: Any = search.world
    facts = {
        "place": target_place(episode),
        "room": world.house.spec.rooms[episode.target_object.room].type,
        "believed": _believed(minds, world, episode),
        "lost": why_lost(record, decisions),
        "placed": placed_in(episode.arrangement, world.boxes, world.house.n_instances),
        "instances": world.house.n_instances,
        "target": episode.target,
        "poses": poses,
        "frames": frames,
        "opened": opened,
        "blocked": blocked,
        "decisions": [_decision(d, minds) for d in decisions],
        "beliefs": minds.beliefs,
        "relevance": minds.relevance,
    }
    return Story(facts, [] if album is None else album.pictures, minds.same)


def _believed(minds: Minds, world: Any, episode: Episode) -> list[float] | None:
    """First step with belief in the thing that keeps the target, step with the largest share of belief, and that share.

    None where the agent never believed in it, has no beliefs, or that thing is no item of the home.
    """
    placed = episode.target_object
    keeper = placed.holder if placed.holder >= 0 else placed.anchor
    if keeper >= world.house.n_items:
        return None
    x0, y0, x1, y1 = (float(world.boxes[keeper][k]) for k in (0, 1, 3, 4))
    category = world.categories[keeper]
    found = [
        (share, step)
        for step, things, _ in minds.beliefs
        for name, box, share in things
        if name == category and x0 <= (box[0] + box[2]) / 2 <= x1 and y0 <= (box[1] + box[3]) / 2 <= y1
    ]
    if not found:
        return None
    most, at = max(found, key=lambda one: one[0])
    return [found[0][1], at, most]


def _decision(decision: DecisionRecord, minds: Minds) -> dict[str, Any]:
    """A decision for the page: its options with scores or, where only the chosen one is stored, the other views."""
    step = decision.step
    told: dict[str, Any] = {"step": step, "kind": decision.kind, "words": decision.words, "text": decision.text}
    if len(decision.options) > 1:
        scores = decision.scores or (None,) * len(decision.options)
        told["options"] = [[name, score] for name, score in zip(decision.options, scores, strict=False)]
        told["chosen"] = decision.answered if decision.answered >= 0 else decision.chosen
    elif step in minds.others:
        told["others"] = [list(other) for other in minds.others[step]]
    if step in minds.asked:
        told["said"] = [list(said) for said in minds.asked[step]]
    for name in ("asked", "fallback", "failure", "dropped"):
        if value := getattr(decision, name):
            told[name] = value
    return told


def _pose(search: Search) -> list[float]:
    """x, y (metres, world frame), heading in quarter turns, pitch in degrees."""
    x, y = search.xy
    return [round(float(x), 3), round(float(y), 3), round(search.pose.heading, 4), search.pose.pitch_deg]


def _frame(album: Album | None, step: int, keys: set[int] | None) -> int:
    return -1 if album is None or (keys is not None and step not in keys) else album.take()
