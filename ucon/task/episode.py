"""An episode: plain data, made once, checked once, stored, and replayed by everybody."""

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

FORMAT = 2


@dataclass(frozen=True)
class Start:
    """Where the agent stands at first: node (i, j) of the home's grid, heading in quarter turns, pitch 0."""

    i: int
    j: int
    heading: int


@dataclass(frozen=True)
class Episode(Shared):
    """One search: a home, what was moved in it, what its people are known to do, and what is to be found.

    ``target`` indexes ``arrangement.objects``. ``solution`` holds the actions of a shortest solution as digits;
    it, the arrangement and the entries' placements are privileged.
    """

    id: str
    scene: str
    home_hash: str
    habits: str
    """Name of the habit dataset."""
    habits_hash: str
    task: str
    """Rule set under which it was checked."""
    seed: int
    split: str
    arrangement: Arrangement
    target: int
    placed_by: tuple[tuple[str, int], ...]
    """(entry id, index of its placement) behind every object of the arrangement; ("", -1) where it was imported."""
    entries: tuple[str, ...]
    """Ids of the entries whose habits make the knowledge base: all that this home has of the sampled categories."""
    task_entries: tuple[str, ...]
    """One entry a category, that of the drawn placement: the knowledge base of mode ``task``."""
    start: Start
    shortest_path_m: float
    solution: str
    context: Context | None = None
    """When it takes place and who asks, where the episode states it; placements then follow it."""

    @property
    def target_object(self) -> PlacedObject:
        """The object to be found."""
        return self.arrangement.objects[self.target]

    @property
    def target_category(self) -> str:
        """Category to be found, for example ``coffee_cup``."""
        return self.target_object.category

    @cached_property
    def hash(self) -> str:
        """SHA-256 of the canonical JSON."""
        return sha256_bytes(canonical_json(self.to_json()).encode())

    def to_json(self) -> dict[str, Any]:
        """JSON-ready dictionary, compact: placed objects are lists in field order."""
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
        """Rebuild an episode; ``where`` names the file and line in errors.

        Raises:
            EpisodeError: a field is missing, of the wrong type, or the format is another one.
        """
        try:
            if data.get("format") != FORMAT:
                found = brief(repr(data.get("format")))
                raise EpisodeError(f"{where}: episode format {found}, expected {FORMAT}; make it anew")
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
                f"{where}: not a usable episode ({brief(str(error))}); restore or make the file anew"
            ) from None
        return episode


def _plain(value: Any) -> Any:
    if isinstance(value, float):
        return round(value, 6) + 0.0
    return [_plain(v) for v in value] if isinstance(value, tuple) else value


def _frozen(value: Any) -> Any:
    return tuple(_frozen(v) for v in value) if isinstance(value, list) else value
