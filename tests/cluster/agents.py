"""Agents that kill, stop or fail their own process in one episode, as can happen to workers."""

import os
import signal
import time
from pathlib import Path

from models.agents.random import RandomAgent
from ucon.core.errors import ConfigError


class Befalls(RandomAgent):
    """Does ``what`` to its process in the episode of ``target``, as long as fewer than ``times`` processes had it."""

    def __init__(self, what: str, folder: Path, target: str, times: int) -> None:
        super().__init__(seed=4, done_probability=0.05)
        self._what, self._folder, self._target, self._times = what, folder, target, times

    def reset(self, infos, slots=None):
        super().reset(infos, slots)
        if any(info["target"] == self._target for info in infos) and len(list(self._folder.iterdir())) < self._times:
            (self._folder / str(os.getpid())).touch()
            getattr(self, self._what)()

    def killed(self):
        os.kill(os.getpid(), signal.SIGKILL)

    def stopped(self):
        os.kill(os.getpid(), signal.SIGSTOP)

    def fails(self):
        raise RuntimeError("it is broken")

    def refuses(self):
        raise ConfigError("agent.option=7: expected another")


class Slow(RandomAgent):
    """Is slow to reset, so that something can happen in the meantime."""

    def __init__(self) -> None:
        super().__init__(seed=4, done_probability=0.05)

    def reset(self, infos, slots=None):
        super().reset(infos, slots)
        time.sleep(0.5)
