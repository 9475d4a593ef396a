"""Makes the stories of a run's episodes, in worker processes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Final

from ucon.configuration.wiring import Factory
from ucon.core.errors import UconError
from ucon.core.pool import Pool
from ucon.envs.ucon_env import UcONEnv
from ucon.evaluation.kept.decisions import DecisionRecord
from ucon.evaluation.kept.record import EpisodeRecord
from ucon.evaluation.playing.runner import resolve_workers
from ucon.evaluation.playing.stage import one_thread
from ucon.pages.report.minds import HeardModel
from ucon.pages.report.pictures import Pictures, small_renderer
from ucon.pages.report.story import Story, tell
from ucon.task.episode import Episode
from ucon.task.rules import task_rules

#: What a story is made from: the episode, its record, and the agent's decisions.
Told = tuple[Episode, EpisodeRecord, Sequence[DecisionRecord]]
#: Fewer episodes than this are handled in this process, since starting others takes seconds.
_FEW: Final = 8


@dataclass(frozen=True)
class Telling:
    """How the stories of one run are made; plain data, sent to workers."""

    config: dict[str, Any]
    """Configuration of the run."""
    thinks: bool
    """Whether the agent runs alongside."""
    pictures: Pictures


def mind_of(config: dict[str, Any]) -> tuple[bool, str]:
    """Whether an agent has anything to show besides its record, and can be run here.

    Args:
        config: of the run.

    Returns:
        Whether it runs alongside; and a line for the page that says why not, "" where nothing is missing.
    """
    try:
        agent = Factory(config["agent"])()
        if not hasattr(agent, "thoughts") and not hasattr(agent, "language"):
            return False, ""
        if hasattr(agent, "check"):
            agent.check()
    except UconError as error:
        return False, f"The agent's beliefs are not shown, since the agent cannot be run here: {error}"
    return True, ""


class Teller:
    """Makes the stories of one run's episodes, one after the other."""

    def __init__(self, how: Telling) -> None:
        """Build environment and agent.

        Args:
            how: how the stories are made.
        """
        self._how = how
        env = dict(how.config["env"])
        if not how.thinks:  # neither senses nor habits are needed to take recorded actions
            env |= {"observe": "symbolic", "detector": False}
        self._env_config = env
        self._env: UcONEnv | None = None
        self._agent: Any = None
        if how.thinks:
            self._agent = Factory(how.config["agent"])()
            if hasattr(self._agent, "language"):
                self._agent.language = HeardModel(self._agent.language)
            one_thread()
        self._renderer = None if how.pictures == "none" else small_renderer(task_rules(str(env["task"])).fov_deg)

    def tell(self, episode: Episode, record: EpisodeRecord, decisions: Sequence[DecisionRecord]) -> Story:
        """Make the story of one episode; see :func:`ucon.pages.report.story.tell`."""
        if self._env is None:
            self._env = Factory(self._env_config, {"episodes": (episode,)})().unwrapped
        assert self._env is not None
        return tell(
            self._env, episode, record, decisions,
            agent=self._agent, renderer=self._renderer, pictures=self._how.pictures,
        )  # fmt: skip


_teller: Teller | None = None


def _begin(how: Telling) -> None:
    global _teller
    _teller = Teller(how)


def _tell(*told: Any) -> Story:
    assert _teller is not None
    return _teller.tell(*told)


def stories(how: Telling, episodes: Sequence[Told]) -> Iterator[Story]:
    """The stories of episodes, in order.

    Args:
        how: how the stories are made.
        episodes: of the run.
    """
    workers = resolve_workers("auto", len(episodes))
    if workers < 2 or len(episodes) < _FEW:
        teller = Teller(how)
        yield from (teller.tell(*told) for told in episodes)
        return
    with Pool(workers, _begin, (how,)) as pool:
        asked = [pool.submit(_tell, *told) for told in episodes]
        for one in asked:
            yield pool.result(one)
