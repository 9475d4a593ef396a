"""What a home file asks for, as it was read: every part knows where it was said."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from ucon.habits.types import Placement
from ucon.sim.placement.spot import Side


@dataclass(frozen=True)
class Thing:
    """Furniture of a room: how many of a category, and where that is said."""

    count: int
    where: str


@dataclass(frozen=True)
class OwnRoom:
    """One room.

    Attributes:
        called: as its owner calls it.
        type: of :data:`ucon.task.own_home.names.ROOM_TYPES`.
        size_m: width and length; None: drawn by the seed.
        furniture: by category; None: drawn by the seed.
        where: file and line.
    """

    called: str
    type: str
    size_m: tuple[float, float] | None
    furniture: Mapping[str, Thing] | None
    where: str


@dataclass(frozen=True)
class Door:
    """An opening between two rooms, by what they are called; ``joint`` is its kind, None the usual one."""

    first: str
    second: str
    joint: str | None
    where: str


@dataclass(frozen=True)
class Sentence:
    """A habit, and where it is said."""

    text: str
    where: str


@dataclass(frozen=True)
class Place:
    """A place as it was said: ``on the shelf in the study``, ``behind the laptop``.

    Attributes:
        placement: relation and anchor.
        side: of the anchor, or None.
        facing: whether the thing's front looks where the anchor's does.
        room: as its owner calls it, or None.
    """

    placement: Placement
    side: Side | None = None
    facing: bool = False
    room: str | None = None


@dataclass(frozen=True)
class Request:
    """Something to be searched.

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
        called: what it is called; of a home that has a name here already, this name.
        known: whether it is such a home, and nothing is built.
        kind: of :data:`ucon.scenes.program.HOME_KINDS`.
        seed: draws what is not said.
        rooms: empty: drawn by the seed.
        doors: None: as in generated homes.
        requests: at least one where something is to be searched.
        things: that are kept where it is said, and never searched.
        others: whether the other things are kept by households of the habit book; else they are where the home has
            them, all requests and things are where the habits say in every search, and these habits are all.
        starts: number of searches for each request, each from another place.
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
