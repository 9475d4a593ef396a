"""All runs of people below one folder: opens them, and finds those of earlier sessions."""

from __future__ import annotations

import re
import threading
import time
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Final

from ucon.core.errors import ConfigError, DataError, brief
from ucon.envs.own_home import ENDINGS, episodes_of, is_home_file
from ucon.evaluation.kept.partial import read_partial
from ucon.evaluation.kept.record import EpisodeRecord, read_records
from ucon.evaluation.kept.seal import PARTIAL, has_summary
from ucon.pages.serve.desk import checked_name
from ucon.pages.serve.play.game import Game
from ucon.pages.serve.play.journal import Journal
from ucon.programs.composing import eval_config
from ucon.programs.evaluating import Evaluation
from ucon.task.own_home.shipped import is_shipped
from ucon.task.sets import episode_sets

#: Levels that can be played; ``context`` re-ranks habits in every step, which nobody could follow.
LEVELS: Final = ("none", "retrieval", "gt", "full")
#: Side of the picture in pixels: what agents get, and a sharper one.
PICTURES: Final = (128, 384)
_MOST_EPISODES: Final = 2000
#: Name of a run's folder: its set, level and number of searches.
_RUN: Final = re.compile(rf"(.+)-({'|'.join(LEVELS)})-([0-9]{{1,4}})(?:-.*)?")
#: Largest number of games that are open at once: each keeps a home in memory.
_MOST_OPEN: Final = 8
#: Seconds to wait for all games when the server ends; all actions are in their journals by then.
_CLOSING_S: Final = 2.0


def sets() -> tuple[str, ...]:
    """Names of the episode sets that can be played, the small one first."""
    names = {name for name in episode_sets() if "." not in name}
    return tuple(sorted(names, key=lambda name: (name != "mini", name)))


def named_homes(files: Iterable[Path]) -> dict[str, Path]:
    """Home files by the names of their sets, which are part of paths.

    Args:
        files: in order.

    Raises:
        ConfigError: no home file, or a name that another set has.
    """
    found: dict[str, Path] = {}
    for file in files:
        if not is_home_file(file):
            raise ConfigError(f"--home {file}: expected a home file, which ends in {' or '.join(ENDINGS)}")
        name, whole = re.sub("[^A-Za-z0-9_-]", "_", file.stem)[:40], _whole(file)
        if name in sets() or found.get(name, whole) != whole:
            raise ConfigError(f"--home {file}: another set is called {name}; give the file another name")
        found[name] = whole
    return found


def _whole(file: Path) -> Path:
    """A home's file as a whole path; a shipped home keeps its name."""
    return file if is_shipped(file) else file.expanduser().resolve()


class Games:
    """The open games of a server, by name: ``ann/mini-retrieval-5``."""

    def __init__(self, folder: Path, homes: Mapping[str, Path] | None = None) -> None:
        """Games below a folder.

        Args:
            folder: of all runs of people.
            homes: home files by the names of their sets.
        """
        self._folder, self._homes = folder, homes or {}
        self._open: dict[str, Game] = {}
        self._closed = False
        self._lock = threading.Lock()
        """Guards the open games; held only for moments, since every request needs it."""
        self._opening = threading.Lock()
        """Held while a game is opened, which may take long."""

    @property
    def sets(self) -> tuple[str, ...]:
        """Sets that can be played: the user's own homes first."""
        return (*self._homes, *sets())

    def open(self, player: str, level: str, episodes: str, n: int, picture_px: int) -> str:
        """Begin a run, or continue the one that was left.

        Args:
            player: who plays.
            level: habit level.
            episodes: name of a set.
            n: number of its episodes, from the first; at most all.
            picture_px: side of the picture.

        Returns:
            Name of the game.

        Raises:
            ConfigError: a wrong option, the run is open in another command, or the server is shutting down.
        """
        checked_name(player, "name")
        if episodes not in self.sets:
            raise ConfigError(f"no set {brief(episodes)} here; for a home file, start with `serve --home FILE.yaml`")
        if level not in LEVELS or picture_px not in PICTURES or not 1 <= n <= _MOST_EPISODES:
            raise ConfigError(f"no such run: {brief(level)}, {brief(episodes)}, {n} episodes, {picture_px} pixels")
        source = str(self._homes.get(episodes, episodes))
        n = min(n, len(episodes_of(source)))
        sharp = "" if picture_px == PICTURES[0] else f"-{picture_px}px"
        wanted = self._folder / player / f"{episodes}-{level}-{n}{sharp}"
        with self._opening:
            evaluation = Evaluation(_config(player, level, source, n, picture_px, wanted), wanted, anew=True)
            name = f"{player}/{evaluation.out.name}"
            with self._lock:
                if (there := self._open.get(name)) is not None and there.alive:
                    return name
                many = self._taken_of_many()
            for game in many:
                game.stop()
            game = Game(evaluation, Journal(_journal_of(evaluation.out)))
            game.know(_records_of(evaluation))
            with self._lock:
                if self._closed:
                    raise ConfigError("the server is shutting down; start it again and continue")
                self._open[name] = game
                game.start()
        return name

    def get(self, name: str) -> Game:
        """An open game.

        Args:
            name: of the game.

        Raises:
            ConfigError: it is not open.
        """
        with self._lock:
            game = self._open.get(name)
        if game is None:
            raise ConfigError("this game is no longer open; start or continue it on the page Play")
        return game

    def left(self) -> list[dict[str, Any]]:
        """Runs below the folder, newest first, at most 100.

        Each has ``player``, ``level``, ``episodes``, ``n``, ``picture_px``, ``done``, ``finished`` and ``run``.
        """
        found = []
        for path in self._folder.glob("*/*"):
            options = _options_of(path)
            if options is not None and (has_summary(path) or (path / PARTIAL).is_file()):
                finished = has_summary(path)
                done = options["n"] if finished else _lines(path / PARTIAL)
                found.append((path.stat().st_mtime, options | {"done": done, "finished": finished, "run": str(path)}))
        return [one for _, one in sorted(found, key=lambda pair: -pair[0])][:100]

    def close(self) -> None:
        """Leave all games; no more are opened. Waits at most ``_CLOSING_S``, even for a game that builds a home."""
        with self._lock:
            self._closed = True
            games = list(self._open.values())
            self._open.clear()
        for game in games:
            game.stop(0)
        until = time.monotonic() + _CLOSING_S
        for game in games:
            game.stop(max(0.0, until - time.monotonic()))

    def _taken_of_many(self) -> list[Game]:
        """Take out the games that were opened first, where there are too many; finished ones before others."""
        taken = []
        while len(self._open) >= _MOST_OPEN:
            name = next((name for name, game in self._open.items() if not game.alive), next(iter(self._open)))
            taken.append(self._open.pop(name))
        return taken


def _config(player: str, level: str, episodes: str, n: int, picture_px: int, out: Path) -> dict[str, Any]:
    """Configuration of ``eval.py`` with the person as the agent; played in this process."""
    config = eval_config(
        "agent=human", f"habit_level={level}", "env.observe=pixels", "workers=0", "pictures=0", "progress=false",
        f"limit={n}", f"env.width_px={picture_px}", f"env.height_px={picture_px}",
    )  # fmt: skip
    config["agent"]["player"] = player  # as an override, 7 or null would not be a text
    return config | {"episodes": episodes, "out": str(out)}


def _journal_of(out: Path) -> Path:
    return out / "journal.jsonl"


def _records_of(evaluation: Evaluation) -> list[EpisodeRecord]:
    """Records of a run that an earlier server left."""
    if has_summary(evaluation.out):
        return read_records(evaluation.out)
    path = evaluation.out / PARTIAL
    if not path.is_file():
        return []
    left = read_partial(path, [episode.id for episode in evaluation.episodes])
    return [played.record for _, played in sorted(left.done.items())]


def _options_of(path: Path) -> dict[str, Any] | None:
    """The options of a run, from the name of its folder; None where it is no such run."""
    name, picture_px = path.name, PICTURES[0]
    for px in PICTURES[1:]:
        if f"-{px}px" in name:
            name, picture_px = name.partition(f"-{px}px")[0], px
    if (found := _RUN.fullmatch(name)) is None:
        return None
    episodes, level, n = found.groups()
    return {"player": path.parent.name, "episodes": episodes, "level": level, "n": int(n), "picture_px": picture_px}


def _lines(path: Path) -> int:
    """Number of episodes in a partial file."""
    try:
        return max(0, path.read_bytes().count(b"\n") - 1)
    except (OSError, DataError):
        return 0
