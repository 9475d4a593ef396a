"""What a run plays: episodes, or the requests of lives."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import closing
from typing import cast

from ucon.evaluation.playing.play import PlayedEpisode, RunSpec, play_episodes
from ucon.evaluation.playing.play_lives import play_lives
from ucon.evaluation.playing.stage import Stage
from ucon.lives.asked import Asked, by_life
from ucon.task.episode import Episode

Job = tuple[int, Episode | Asked]
"""What is played, with its index in the evaluated list. All jobs of a run are of one kind."""
_Lives = Sequence[tuple[int, Asked]]


def play(spec: RunSpec, jobs: Sequence[Job]) -> Iterator[PlayedEpisode]:
    """Play jobs in order and yield each as it ends. The result of one does not depend on what else is played.

    Args:
        spec: agent, environment, habit level.
        jobs: see :data:`Job`.
    """
    if not jobs:
        return
    with closing(Stage(spec.agent, spec.env)) as stage:
        yield from play_on(stage, spec, jobs)


def play_on(stage: Stage, spec: RunSpec, jobs: Sequence[Job]) -> Iterator[PlayedEpisode]:
    """As :func:`play`, with an agent and environments that exist already.

    Args:
        stage: where they are played; made by ``spec``.
        spec: agent, environment, habit level.
        jobs: see :data:`Job`.
    """
    if jobs and isinstance(jobs[0][1], Asked):
        return play_lives(spec, cast("_Lives", jobs), stage)
    return play_episodes(spec, cast("Sequence[tuple[int, Episode]]", jobs), stage)


def shares(jobs: Sequence[Job], count: int) -> list[list[Job]]:
    """Jobs of each of ``count`` workers: every ``count``-th episode, or life."""
    if not jobs or not isinstance(jobs[0][1], Asked):
        return [list(jobs[number::count]) for number in range(count)]
    lives = by_life(cast("_Lives", jobs))
    found = [[job for life in lives[number::count] for job in life] for number in range(count)]
    return cast("list[list[Job]]", [share for share in found if share])
