"""Makes episodes and habits from a home file, once, and keeps them; also makes single searches from Python."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

import ucon
from ucon.core.errors import ConfigError, DataError, UconError, brief
from ucon.core.files import canonical_json, sha256_bytes, user_cache, user_pack
from ucon.core.output import say_once
from ucon.envs.knowledge import HabitSource
from ucon.habits.datafile import SUFFIX as HABITS
from ucon.habits.datafile import load_dataset_file, save_dataset
from ucon.habits.types import HabitDataset, Placement
from ucon.objects.catalogue import catalogue
from ucon.scenes.library import check_home_name
from ucon.sim.cache import load_house
from ucon.task.episode import Episode
from ucon.task.own_home.building import build, home_name, unplaced
from ucon.task.own_home.placing import placed_requests
from ucon.task.own_home.reading import read_home
from ucon.task.own_home.shipped import CASES, home_path, is_shipped
from ucon.task.own_home.wish import OwnHome
from ucon.task.rules import PAPER, task_rules
from ucon.task.sets import SUFFIX as EPISODES
from ucon.task.sets import load_episodes, save_episodes
from ucon.task.spoken import target_place

#: The worked example.
EXAMPLE: Final = Path(ucon.__file__).parent / "task" / "own_home" / "data" / "example.yaml"
#: Endings of home files.
ENDINGS: Final = (".yaml", ".yml")
#: Packages whose code and data manifests decide the episodes of a home, besides its file.
_DECIDES: Final = ("core", "habits", "language", "objects", "perception", "readers", "scenes", "sim", "task")


class OwnSet(NamedTuple):
    """The episodes of a home file, and the habits that they use."""

    name: str
    """Name of the home."""
    episodes: tuple[Episode, ...]
    dataset: HabitDataset
    key: str
    """Hash of everything that decides the episodes; names the files in which they are kept."""


def is_home_file(name: object) -> bool:
    """Whether ``episodes=`` names a home file or a shipped home, rather than a set."""
    return isinstance(name, str | Path) and (Path(name).suffix.lower() in ENDINGS or is_shipped(name))


def episodes_of(name: str | Path, task: str = PAPER.name, *, context: bool = False) -> tuple[Episode, ...]:
    """The episodes of a set, a file of episodes, or a home.

    Args:
        name: name of the set, file or shipped home.
        task: rule set.
        context: load the version of a set whose episodes state their context.

    Raises:
        UconError: no such set, or a fault in the file.
    """
    if not is_home_file(name):
        return load_episodes(name, task, context=context)
    if context:
        raise ConfigError(f"{name}: episodes of a home file state no context; leave task.context=true out")
    return own_set(Path(name), task).episodes


def own_set(path: Path, task: str = PAPER.name) -> OwnSet:
    """Episodes and habits of a home file; made once, then kept in the user's cache for this version of the code.

    A pack is searched for them too. A case is a single search of a shipped home.

    Args:
        path: the file, or the name of a shipped home or case.
        task: rule set under which the episodes are solvable.

    Raises:
        DataError: faults in the file, each with its line, or PyBullet, which places things, is missing.
        SceneError: the home cannot be built.
    """
    wish = read_home(home_path(path))
    if not wish.requests:
        raise DataError(f"{wish.where}: nothing to search; add 'requests', such as - mug: on the breakfast table")
    made = _made(_Wish(wish, _content(wish, task)), task)
    if (case := CASES.get(str(path))) is None:
        return made
    shown = [e for e in made.episodes if (e.target_category, e.seed) == (case.target, case.day)]
    return made._replace(episodes=tuple(shown))


class _Wish:
    """A home compared by its content, so that the same home is made once per process."""

    def __init__(self, home: OwnHome, key: str) -> None:
        self.home, self.key = home, key

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Wish) and self.key == other.key

    def __hash__(self) -> int:
        return hash(self.key)


@lru_cache(maxsize=16)
def _made(wish: _Wish, task: str) -> OwnSet:
    name, pack = home_name(wish.home), user_pack()
    for folder in (*(() if pack is None else (pack,)), user_cache()):
        episodes, habits = _files(folder, wish.key)
        with contextlib.suppress(UconError):
            return OwnSet(name, load_episodes(episodes, task), load_dataset_file(habits, catalogue().names), wish.key)
    house = build(wish.home)[1]
    placed, dataset = placed_requests(wish.home, name, house, read_places, task_rules(task))
    made = OwnSet(name, tuple(episode for one in placed for episode in one.episodes), dataset, wish.key)
    with contextlib.suppress(OSError):  # a read-only cache costs time, not correctness
        keep_set(made, user_cache())
    return made


def keep_set(made: OwnSet, folder: Path) -> str:
    """Write episodes and habits of a home file, for :func:`own_set` to find.

    Args:
        made: what was made from the file.
        folder: the user's cache, or a pack.

    Returns:
        The name of the home.
    """
    episodes, habits = _files(folder, made.key)
    save_dataset(made.dataset, habits)
    save_episodes(made.episodes, episodes)
    return made.name


def _files(folder: Path, key: str) -> tuple[Path, Path]:
    return folder / "own" / f"{key}{EPISODES}", folder / "own" / f"{key}{HABITS}"


def say_made(path: Path, made: OwnSet) -> None:
    """Print once per process what was made from a home file, and warnings about furniture that found no place.

    Args:
        path: the file.
        made: its episodes.
    """
    kept = dict.fromkeys(f"{e.target_category.replace('_', ' ')} {target_place(e)}" for e in made.episodes)
    n = len(made.episodes)
    say_once(f"{path}: {made.name}, {n} search{'es' if n > 1 else ''}: {', '.join(kept)}")
    for one in unplaced(read_home(home_path(path)), load_house(made.name), nearest=False):
        say_once(f"warning: {one}; `python -m ucon home check {path}` says what fits instead")


def read_places(target: str, habits: Sequence[str]) -> tuple[Sequence[str], NDArray[np.float64]]:
    """Where a thing is kept according to its habits; a :data:`ucon.task.making.own_household.ReadPlaces`."""
    from ucon.perception.belief.from_habits import ReadHabits

    found = ReadHabits()({"target": target, "habits": tuple(habits), "habit_level": "gt"})
    return found.names, found.p


def _content(home: OwnHome, task: str) -> str:
    """Hash of everything that decides the episodes of a home."""
    asked = [
        [(one.target, [asdict(place) for place in one.places], [habit.text for habit in one.habits]) for one in group]
        for group in (home.requests, home.things)
    ]
    what = [home_name(home), asked, home.others, home.starts, task, _code_version()]
    return sha256_bytes(canonical_json(what).encode())[:16]


@lru_cache(maxsize=1)
def _code_version() -> str:
    """SHA-256 of the code and the manifests of data that decide where things are put."""
    root = Path(ucon.__file__).parent
    ends = ("*.py", "MANIFEST.json")
    files = sorted(path for part in _DECIDES for end in ends for path in (root / part).rglob(end))
    parts = [f"{path.relative_to(root).as_posix()} {sha256_bytes(path.read_bytes())}" for path in files]
    return sha256_bytes("\n".join(parts).encode())


@dataclass(frozen=True)
class OwnEpisode:
    """A search that can be played.

    Attributes:
        episode: the episode.
        dataset: the habits that it uses.
        place: where the thing is kept. Privileged.
    """

    episode: Episode
    dataset: HabitDataset
    place: Placement

    @cached_property
    def source(self) -> HabitSource:
        """Source of the episode's habits."""
        return HabitSource(self.dataset)

    def env(self, **options: Any) -> Any:
        """The environment ``UcON-v0`` of this search.

        Args:
            **options: options of :class:`ucon.envs.ucon_env.UcONEnv`, such as ``habit_level="none"``.
        """
        import gymnasium as gym

        return gym.make("UcON-v0", **{"episodes": (self.episode,), "source": self.source, **options})

    def save(self, folder: str | Path) -> tuple[Path, Path]:
        """Write the search as files, for ``eval.py episodes=FILE habits=folder habits.path=FILE``.

        Args:
            folder: destination; made if missing.

        Returns:
            The files of the episode and of the habits.
        """
        episodes, habits = Path(folder) / f"own{EPISODES}", Path(folder) / f"own{HABITS}"
        save_dataset(self.dataset, habits)
        save_episodes([self.episode], episodes)
        return episodes, habits


def make_episode(
    home: str | Path | Mapping[str, Any],
    habits: Sequence[str] = (),
    target: str | None = None,
    place: str | None = None,
    *,
    seed: int = 0,
    task: str = PAPER.name,
) -> OwnEpisode:
    """Make one search in a home, with your own habits.

    Args:
        home: a home file; the same content as a dict; or the name of a home (``robot_flat``, ``Rs_int``,
            ``procedural:flat:3``).
        habits: sentences, which replace those of the file.
        target: what to search for, such as ``mug``; by default the first request of the file.
        place: where the target is kept, such as ``in the top cabinet``; by default where the habits say.
        seed: draws where the search starts and where everything else is.
        task: rule set under which the search must be solvable.

    Raises:
        UconError: lists every fault in the arguments and the file, with the nearest valid value.
    """
    instead: dict[str, Any] = {"starts": 1}
    if habits:
        instead["habits"] = [habits] if isinstance(habits, str) else list(habits)
    if target is not None:
        instead["requests"] = [{target: place}]
    elif place is not None:
        raise ConfigError(f"place={brief(place)}: no target; give target, too, such as target='mug'")
    wish = read_home(_source(home), instead)
    if not wish.requests:
        raise ConfigError("target: nothing to search; give target='mug', or a file that has requests")
    name, house = build(wish)
    placed, dataset = placed_requests(wish, name, house, read_places, task_rules(task), seed)
    return OwnEpisode(placed[0].episodes[0], dataset, placed[0].place)


def _source(home: str | Path | Mapping[str, Any]) -> Path | Mapping[str, Any]:
    """The home in a form that can be read: a file or a dict; the name of a home becomes a dict."""
    if isinstance(home, Mapping):
        return home
    if is_home_file(home) or isinstance(home, Path):
        return home_path(home)
    check_home_name(str(home))
    return {"home": str(home)}
