"""An episode: plain data that is made once, checked once, stored, and replayed."""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields
from functools import cached_property
from typing import Any

from ucon.core.errors import EpisodeError, brief
from ucon.core.files import canonical_json, sha256_bytes
from ucon.core.sharing import Shared
from ucon.habits.contexts import Context
from ucon.sim.arrangement import Arrangement, PlacedObject
from ucon.task.check_data import check_data

#: Version of the stored form.
FORMAT = 2


@dataclass(frozen=True)
class Start:
    """The agent's first pose: node (i, j) of the home's grid, heading in quarter turns, pitch 0."""

    i: int
    j: int
    heading: int


@dataclass(frozen=True)
class Episode(Shared):
    """One search: a home, what was placed in it, the household's habits, and the target.

    The arrangement, the entries' placements and ``solution`` are privileged: agents must not read them.
    """

    id: str
    scene: str
    """Name of the home."""
    home_hash: str
    """Hash of the home's specification."""
    habits: str
    """Name of the habit dataset."""
    habits_hash: str
    """SHA-256 of the habit dataset."""
    task: str
    """Rule set under which the episode is solvable."""
    seed: int
    split: str
    """Label of the group within its set."""
    arrangement: Arrangement
    """What was removed from the home and what was placed in it."""
    target: int
    """Index of the target in ``arrangement.objects``."""
    placed_by: tuple[tuple[str, int], ...]
    """For each object, the placement that put it there as (entry id, placement index); ("", -1) for added anchors."""
    entries: tuple[str, ...]
    """Ids of the entries whose habits form the knowledge base: all the household's entries of the placed categories."""
    task_entries: tuple[str, ...]
    """One entry per category, that of the drawn placement: the knowledge base of mode ``task``."""
    start: Start
    """The agent's first pose."""
    shortest_path_m: float
    """Length of the shortest solution, metres; the l of SPL."""
    solution: str
    """Actions of a shortest solution, as digits."""
    context: Context | None = None
    """Time and asker, where the episode states them; the placements then follow this context."""

    @property
    def target_object(self) -> PlacedObject:
        """The target as it was placed. Privileged."""
        return self.arrangement.objects[self.target]

    @property
    def target_category(self) -> str:
        """Category of the target, for example ``coffee_cup``."""
        return self.target_object.category

    @cached_property
    def hash(self) -> str:
        """SHA-256 of the canonical JSON, in hexadecimal."""
        return sha256_bytes(canonical_json(self.to_json()).encode())

    def to_json(self) -> dict[str, Any]:
        """The episode as JSON data; placed objects are lists in the order of their fields."""
        data = asdict(self) | {"format": FORMAT}
        data["arrangement"] = {
            "removed": list(self.arrangement.removed),
            "blocked": [list(cell) for cell in self.arrangement.blocked],
            "objects": [[_plain(getattr(o, f.name)) for f in fields(o)] for o in self.arrangement.objects],
        }
        data["start"] = [self.start.i, self.start.j, self.start.heading]
        data["context"] = self.context and self.context.to_json()
        return data

    @classmethod
    def from_json(cls, data: dict[str, Any], *, where: str = "episode") -> Episode:
        """Read an episode from JSON data.

        Args:
            data: what :meth:`to_json` returns.
            where: names file and line in errors.

        Raises:
            EpisodeError: a field is missing or of the wrong type, or the format is another one.
        """
        try:
            if data.get("format") != FORMAT:
                found = brief(repr(data.get("format")))
                raise EpisodeError(f"{where}: episode format {found}, expected {FORMAT}; make it again")
            raw = dict(data)
            del raw["format"]
            change = raw.pop("arrangement")
            objects = tuple(
                PlacedObject(**dict(zip((f.name for f in fields(PlacedObject)), map(_frozen, row), strict=True)))
                for row in change["objects"]
            )
            arrangement = Arrangement(
                removed=tuple(int(i) for i in change["removed"]),
                objects=objects,
                blocked=tuple((int(i), int(j)) for i, j in change["blocked"]),
            )
            start = Start(*(int(v) for v in raw.pop("start")))
            told = raw.pop("context")
            context = None if told is None else Context.from_json(told)
            plain = {k: _frozen(v) for k, v in raw.items()}
            episode = cls(arrangement=arrangement, start=start, context=context, **plain)
            check_data(episode, where)
        except (LookupError, TypeError, ValueError, ArithmeticError, AttributeError) as error:
            raise EpisodeError(
                f"{where}: not a usable episode ({brief(str(error))}); restore or make the file again"
            ) from None
        return episode


def _plain(value: Any) -> Any:
    """JSON data of a value; floats are rounded to 6 decimals."""
    if isinstance(value, float):
        return round(value, 6) + 0.0
    return [_plain(v) for v in value] if isinstance(value, tuple) else value


def _frozen(value: Any) -> Any:
    """The value with its lists turned into tuples, recursively."""
    return tuple(_frozen(v) for v in value) if isinstance(value, list) else value
