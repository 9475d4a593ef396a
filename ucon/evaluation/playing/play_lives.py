"""Plays lives with one agent in one process, and makes a record of each request."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

from ucon.evaluation.playing.play import PlayedEpisode, RunSpec, played
from ucon.evaluation.playing.stage import Env, Stage
from ucon.lives.asked import Asked, by_life
from ucon.lives.request_record import LifeFacts
from ucon.memory.protocol import Memory
from ucon.task.actions import Action
from ucon.task.agent import Agent
from ucon.task.episode import Episode


@dataclass
class _Resident:
    """One environment of the batch with the life that it plays now, and the current request."""

    number: int
    env: Env
    wanted: dict[int, int] = field(default_factory=dict)
    """Index of each request that is still to be recorded, by its number in the life."""
    index: int = -1
    episode: Episode | None = None
    memory: Memory | None = None
    observation: Any = None
    info: Any = None
    first_info: Any = None
    actions: list[int] = field(default_factory=list)
    frames: list[Any] | None = None
    started: float = 0.0

    def live(self, jobs: Sequence[tuple[int, Asked]], agent: Agent, spec: RunSpec) -> None:
        """Start a life. Requests before the first wanted one are played too: the robot remembers them."""
        self.wanted = {asked.number: index for index, asked in jobs}
        self.memory = None if spec.memory is None else spec.memory()
        self.observation, self.info = self.env.reset(seed=spec.seed, options={"life": jobs[0][1].life})
        self._begin(agent)

    def step(self, action: int, agent: Agent, spec: RunSpec) -> Iterator[PlayedEpisode]:
        """Carry out an action; yields the request that it ends, if that request is wanted."""
        if self.memory is not None:
            self.memory.look(self.observation, self.info)
            action = self.memory.act(int(action), self.observation)
        self.actions.append(int(action))
        self.observation, _, over, _, self.info = self.env.step(int(action))
        if "request_record" not in self.info:
            return
        # Privileged: both are for the record alone, and the next request may begin with this same info.
        metrics = dict(self.info.pop("request_record"))
        del self.info["is_success"]
        facts = LifeFacts(**metrics.pop("life"))
        if self.memory is not None:
            self.memory.end()
        if facts.request in self.wanted:
            self.index = self.wanted.pop(facts.request)
            believed = None if self.memory is None else self.memory.believed
            yield played(self, agent, spec, metrics, facts, believed)
        if not over and self.wanted:
            self._begin(agent)

    def _begin(self, agent: Agent) -> None:
        """Begin a request; the current frame is its first one, or the first one of the patrol before it."""
        while "patrol" in self.info:
            action = Action.DONE if self.memory is None else self.memory.patrol(self.observation, self.info)
            self.observation, _, _, _, self.info = self.env.step(int(action))
        self.episode = self.env.unwrapped.episode  # type: ignore[attr-defined]
        self.actions, self.first_info, self.started = [], self.info, time.perf_counter()
        known = self.info if self.memory is None else self.memory.begin(self.info)
        agent.reset([known], [self.number])


def play_lives(spec: RunSpec, jobs: Sequence[tuple[int, Asked]], stage: Stage) -> Iterator[PlayedEpisode]:
    """Play lives in order and yield each wanted request as it ends.

    A life is played from its first request up to its last wanted one, so a request's result does not depend on what
    else is wanted.

    Args:
        spec: agent, environment, memory, habit level.
        jobs: (index, request) pairs.
        stage: where they are played.
    """
    agent, lives = stage.agent, iter(by_life(jobs))
    running = []
    for number, env in enumerate(stage.envs(min(spec.batch, len(by_life(jobs))))):
        resident = _Resident(number, env)
        resident.live(next(lives), agent, spec)
        running.append(resident)
    while running:
        actions = agent.act([r.observation for r in running], [r.info for r in running], [r.number for r in running])
        still = []
        for resident, action in zip(running, actions, strict=True):
            yield from resident.step(action, agent, spec)
            if not resident.wanted and (jobs_of_life := next(lives, None)) is not None:
                resident.live(jobs_of_life, agent, spec)
            if resident.wanted:
                still.append(resident)
        running = still
