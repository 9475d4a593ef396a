"""``oracle``: replays the stored shortest solution; SR and SPL show what the episode sets allow."""

from __future__ import annotations

from models.agents.base import Controller, ControllerAgent
from ucon.core.errors import ConfigError
from ucon.evaluation.kept.decisions import DecisionRecord
from ucon.task.actions import Action
from ucon.task.agent import Info, Observation


class _Replay:
    def __init__(self, episode: str, solution: str) -> None:
        self._actions = [int(digit) for digit in solution]
        self._next = 0
        words = f"walk: the stored solution, {len(solution)} actions"
        self.decisions = [DecisionRecord(episode, 0, 0, "solution", (words,), 0)]

    def act(self, observation: Observation, info: Info) -> int:
        self._next += 1
        return self._actions[self._next - 1] if self._next <= len(self._actions) else int(Action.DONE)


class OracleAgent(ControllerAgent):
    """Replays the shortest solution, which uses the true map and target place: an upper bound of SPL."""

    name = "oracle"
    uses_habits = False

    def start(self, info: Info) -> Controller:
        """A controller that replays the solution in the privileged ``info``.

        Raises:
            ConfigError: the environment is not privileged.
        """
        try:
            return _Replay(str(info.get("episode", "")), str(info["privileged"]["solution"]))
        except KeyError:
            raise ConfigError(
                "agent oracle needs the stored solution: make the environment with privileged=True"
            ) from None
