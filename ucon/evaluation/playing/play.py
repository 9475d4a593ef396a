"""Plays stored episodes with one agent in one process and makes a record of each.

An agent needs ``reset(infos, slots)`` and ``act(observations, infos, slots)``. If it calls a language model, it may
have ``language_usage(slot) -> (calls, tokens, seconds)`` since the slot's reset; if it chooses among candidates,
``decisions(slot)``.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from ucon.core.errors import ConfigError, brief
from ucon.evaluation.kept.decisions import DecisionRecord
from ucon.evaluation.kept.record import EpisodeRecord, EpisodeTiming
from ucon.evaluation.playing.stage import Env, Stage
from ucon.lives.request_record import BelievedPlace, LifeFacts
from ucon.memory.protocol import Memory
from ucon.retrieval.levels import RANKED_LEVELS
from ucon.task.actions import Action
from ucon.task.agent import Agent
from ucon.task.episode import Episode
from ucon.task.spoken import target_place


@dataclass(frozen=True)
class RunSpec:
    """What a worker needs to play. The factories have to be picklable: they are called in the workers.

    Raises:
        ConfigError: ``batch`` out of range.
    """

    agent: Callable[[], Agent]
    env: Callable[[], Env]
    habit_level: str
    seed: int = 0
    batch: int = 1
    """Environments whose observations a worker passes to its agent together.

    Above 1 helps agents that batch a model.
    """
    films: Path | None = None
    """Folder for the map and the video of every episode; None: no films."""
    memory: Callable[[], Memory | None] | None = None
    """Makes the memory of a robot that lives in a home; None: it begins every request without a memory."""

    def __post_init__(self) -> None:
        if type(self.batch) is not int or self.batch < 1:
            raise ConfigError(f"batch={brief(self.batch)}: expected a whole number from 1 up")


@dataclass(frozen=True)
class PlayedEpisode:
    """One finished episode: its index in the evaluated list, its record, timing and decisions."""

    index: int
    record: EpisodeRecord
    timing: EpisodeTiming
    decisions: tuple[DecisionRecord, ...] = ()
    """Decisions of agents that choose among candidates."""


@dataclass
class _Slot:
    """One environment of the batch with the episode that it plays now."""

    number: int
    env: Env
    index: int = -1
    episode: Episode | None = None
    observation: Any = None
    info: Any = None
    first_info: Any = None
    actions: list[int] = field(default_factory=list)
    frames: list[Any] | None = None
    started: float = 0.0

    def start(self, index: int, episode: Episode, seed: int, film: bool) -> None:
        self.index, self.episode, self.actions = index, episode, []
        self.started = time.perf_counter()
        self.observation, self.info = self.env.reset(seed=seed, options={"episode": episode})
        self.first_info = self.info
        self.frames = [self.env.render()] if film else None

    def append_picture(self, picture: Any) -> None:
        """Append the agent's picture to the right of the last frame."""
        assert self.frames is not None
        self.frames[-1] = np.concatenate([self.frames[-1], picture], axis=1)

    def step(self, action: int) -> bool:
        self.actions.append(int(action))
        self.observation, _, terminated, truncated, self.info = self.env.step(int(action))
        if self.frames is not None:
            self.frames.append(self.env.render())
        return bool(terminated or truncated)


def play_episodes(spec: RunSpec, jobs: Sequence[tuple[int, Episode]], stage: Stage) -> Iterator[PlayedEpisode]:
    """Play episodes in order and yield each as it ends. The result of one does not depend on the others.

    Args:
        spec: agent, environment, habit level.
        jobs: (index, episode) pairs.
        stage: where they are played.
    """
    agent, waiting = stage.agent, iter(jobs)
    slots = [_Slot(n, env) for n, env in enumerate(stage.envs(min(spec.batch, len(jobs))))]
    running = [slot for slot in slots if _begin(slot, waiting, agent, spec)]
    while running:
        actions = agent.act([s.observation for s in running], [s.info for s in running], [s.number for s in running])
        still = []
        for slot, action in zip(running, actions, strict=True):
            _append_agent_picture(slot, agent)
            ended = slot.step(action)
            if ended:
                yield played(slot, agent, spec, slot.info["episode_metrics"])
            if not ended or _begin(slot, waiting, agent, spec):
                still.append(slot)
        running = still


def _append_agent_picture(slot: _Slot, agent: Agent) -> None:
    """Append the agent's picture to the film, if a film is made and the agent draws one."""
    picture = getattr(agent, "picture", None)
    if slot.frames is not None and picture is not None and (drawn := picture(slot.number)) is not None:
        slot.append_picture(drawn)


def _begin(slot: _Slot, waiting: Iterator[tuple[int, Episode]], agent: Agent, spec: RunSpec) -> bool:
    job = next(waiting, None)
    if job is None:
        return False
    index, episode = job
    slot.start(index, episode, spec.seed, film=spec.films is not None)
    agent.reset([slot.info], [slot.number])
    return True


class Ended(Protocol):
    """A search that has just ended, in one environment of the batch."""

    number: int
    """Number of the environment in the batch."""
    env: Env
    index: int
    """Index of the episode in the evaluated list."""
    episode: Episode | None
    first_info: Any
    """Info of the reset."""
    actions: list[int]
    frames: list[Any] | None
    """Frames of its film; None without one."""
    started: float
    """Time of the process's clock at the start, seconds."""


def played(
    slot: Ended,
    agent: Agent,
    spec: RunSpec,
    metrics: Mapping[str, Any],
    life: LifeFacts | None = None,
    believed: tuple[BelievedPlace, ...] | None = None,
) -> PlayedEpisode:
    """Record, timing and decisions of a search that has just ended; writes its film, if one is made.

    Args:
        slot: the search.
        agent: the agent, before it begins another search in that environment.
        spec: of the run.
        metrics: of the search, as the environment's ``episode_metrics``.
        life: of a request in a life.
        believed: where a robot with a memory believed the target to be.
    """
    seconds = time.perf_counter() - slot.started
    episode = slot.episode
    assert episode is not None
    usage = getattr(agent, "language_usage", None)
    calls, tokens, language_s = usage(slot.number) if usage else (0, 0, 0.0)
    record = _record(slot, episode, agent.name, spec, metrics)
    record = replace(record, language_calls=int(calls), language_tokens=int(tokens), life=life, believed=believed)
    if slot.frames is not None and spec.films is not None:
        from ucon.evaluation.playing.pictures import save_film

        ending = "found" if record.success else "lost"
        name = f"{slot.index:03d}_{ending}_{episode.scene.replace(':', '-')}_{record.target}"
        save_film(slot.frames, _captions(record, target_place(episode)), spec.films, name)
    made = getattr(agent, "decisions", None)
    decisions = tuple(replace(d, seconds=round(float(d.seconds), 5)) for d in made(slot.number)) if made else ()
    spent = tuple(d.seconds for d in decisions) if calls else ()
    timing = EpisodeTiming(record.episode, round(seconds, 4), round(float(language_s), 4), spent)
    return PlayedEpisode(slot.index, record, timing, decisions)


def _captions(record: EpisodeRecord, place: str) -> list[str]:
    """One line for every frame of a film: target, action, and at the end the result and the true place."""
    find = f"find: {record.target.replace('_', ' ')}"
    names = [Action(int(digit)).name.lower().replace("_", " ") for digit in record.actions]
    lines = [find, *(f"{find}   step {number}: {name}" for number, name in enumerate(names, 1))]
    if record.success:
        lines[-1] = f"{find}   found {place} after {record.steps} steps"
    else:
        cause = record.failure_cause.replace("_", " ")
        lines[-1] = f"{find}   {cause} after {record.steps} steps; it is {place}"
    return lines


def _record(slot: Ended, episode: Episode, agent: str, spec: RunSpec, m: Mapping[str, Any]) -> EpisodeRecord:
    success, steps = bool(m["success"]), int(m["steps"])
    ranked = _retrieval(slot.env, episode, spec.habit_level)
    return EpisodeRecord(
        episode=episode.id,
        scene=episode.scene,
        split=episode.split,
        target=episode.target_category,
        relation=str(episode.target_object.relation),
        contained=bool(m["contained"]),
        agent=agent,
        habit_level=spec.habit_level,
        seed=spec.seed,
        success=success,
        success_75=success and steps <= 75,
        success_150=success and steps <= 150,
        success_300=success and steps <= 300,
        spl=float(m["spl"]),
        soft_spl=float(m["soft_spl"]),
        shortest_path_m=float(m["shortest_path_m"]),
        path_length_m=float(m["path_length_m"]),
        steps=steps,
        actions="".join(map(str, slot.actions)),
        opens=int(m["opens"]),
        collisions=int(m["collisions"]),
        first_seen_step=int(m["first_seen_step"]),
        failure_cause=str(m["failure_cause"]),
        n_habits=len(slot.first_info["habits"]),
        recall_10=ranked["recall_at_10"],
        recall_20=ranked["recall_at_20"],
        mrr=ranked["mrr"],
    )


def _retrieval(env: Env, episode: Episode, level: str) -> Mapping[str, float | None]:
    """How well the retriever ranks the target's habits among the episode's; None at levels that do not rank."""
    if level not in RANKED_LEVELS:
        return {"recall_at_10": None, "recall_at_20": None, "mrr": None}
    found: dict[str, float] = env.unwrapped.source.knowledge(episode, "none").retrieval_metrics()  # type: ignore[attr-defined]
    return {name: float(value) for name, value in found.items()}
