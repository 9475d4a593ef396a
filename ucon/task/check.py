"""Checks that an episode fits its home."""

from __future__ import annotations

from ucon.core.errors import EpisodeError
from ucon.sim.house import House
from ucon.sim.shapes import item_solid, object_solid
from ucon.task.check_data import expect
from ucon.task.episode import Episode


def check_home(episode: Episode, house: House) -> None:
    """Refuse an episode that does not fit its home.

    Args:
        episode: the episode.
        house: the compiled home of its ``scene``.

    Raises:
        EpisodeError: the episode was made for another version of the home, or names a node or instance that the home
            lacks.
    """
    where = f"episode {episode.id}"
    if house.spec.hash != episode.home_hash:
        raise EpisodeError(
            f"{where}: made for home {episode.home_hash[:12]}, {episode.scene} is now {house.spec.hash[:12]}; "
            "make the episodes again (python -m ucon episodes make)"
        )
    nx, ny = house.grid.shape
    for cell in ((episode.start.i, episode.start.j), *episode.arrangement.blocked):
        expect(0 <= cell[0] < nx and 0 <= cell[1] < ny, where, "node", cell, f"below ({nx}, {ny})")
    start = (episode.start.i, episode.start.j)
    free = bool(house.grid.free[start]) and start not in episode.arrangement.blocked
    expect(free, where, "start", start, f"a free node of {episode.scene}")
    total = house.n_instances + len(episode.arrangement.objects)
    for number, placed in enumerate(episode.arrangement.objects):
        own = house.n_instances + number
        for name, value in (("anchor", placed.anchor), ("holder", placed.holder)):
            what = f"{name} of object {number} ({placed.category})"
            expect(-1 <= value < total, where, what, value, f"an instance below {total}")
            expect(value != own, where, what, value, "another instance than itself")
        if placed.compartment >= 0:
            count = _compartments(episode, house, placed.holder)
            what = f"compartment of object {number} ({placed.category})"
            expect(placed.compartment < count, where, what, placed.compartment, f"one of the holder's {count}")


def _compartments(episode: Episode, house: House, instance: int) -> int:
    """Number of compartments of an instance."""
    if 0 <= instance < house.n_items:
        return len(item_solid(house.spec.items[instance]).model.compartments)
    if instance >= house.n_instances:
        return len(object_solid(episode.arrangement.objects[instance - house.n_instances]).model.compartments)
    return 0
