"""What a home file asks for, as it was read; every part knows its file and line."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from ucon.habits.types import Placement
from ucon.sim.placement.spot import Side


@dataclass(frozen=True)
class Thing:
    """Furniture of a room: how many of a category, and file and line."""

    count: int
    where: str


@dataclass(frozen=True)
class OwnRoom:
    """One room.

    Attributes:
        called: name of the room in the home file.
        type: one of :data:`ucon.task.own_home.names.ROOM_TYPES`.
        size_m: width and length; None: drawn from the seed.
        furniture: furniture by category; None: drawn from the seed.
        where: file and line.
    """

    called: str
    type: str
    size_m: tuple[float, float] | None
    furniture: Mapping[str, Thing] | None
    where: str


@dataclass(frozen=True)
class Door:
    """An opening between two rooms, given by their names; ``joint`` is its kind, None for the usual one."""

    first: str
    second: str
    joint: str | None
    where: str


@dataclass(frozen=True)
class Sentence:
    """A habit sentence, with file and line."""

    text: str
    where: str


@dataclass(frozen=True)
class Place:
    """A place as the home file gives it: ``on the shelf in the study``, ``behind the laptop``.

    Attributes:
        placement: relation and anchor.
        side: side of the anchor, or None.
        facing: whether the thing's front faces the same way as the anchor's.
        room: name of the room in the home file, or None.
    """

    placement: Placement
    side: Side | None = None
    facing: bool = False
    room: str | None = None


@dataclass(frozen=True)
class Request:
    """Something to search for.

    Attributes:
        target: its category.
        places: where it may be kept; empty: where the habits say.
        habits: the sentences about it.
        where: file and line.
    """

    target: str
    places: tuple[Place, ...]
    habits: tuple[Sentence, ...]
    where: str

    @property
    def place(self) -> Placement | None:
        """The first place, or None."""
        return self.places[0].placement if self.places else None


@dataclass(frozen=True)
class OwnHome:
    """A home, its habits and its requests.

    Attributes:
        called: the name that the file gives, or that of an existing home.
        known: whether this is an existing home, so that nothing is built.
        kind: one of :data:`ucon.scenes.program.HOME_KINDS`.
        seed: draws what the file does not state.
        rooms: the rooms; empty: drawn from the seed.
        doors: the doors; None: as in generated homes.
        requests: what to search for; at least one if there are to be searches.
        things: things that are kept where the file or the habits say, and never searched for.
        others: whether households of the habit book keep the other things; else these stay where the home has them, all
            requests and things are placed for every search, and the file's habits are the only ones.
        starts: number of searches for each request, each from a different start.
        where: the file and its first line, for messages.
        file: the file.
    """

    called: str
    known: bool
    kind: str
    seed: int
    rooms: tuple[OwnRoom, ...]
    doors: tuple[Door, ...] | None
    requests: Sequence[Request] = field(default=())
    things: Sequence[Request] = field(default=())
    others: bool = True
    starts: int = 1
    where: str = ""
    file: str = ""
