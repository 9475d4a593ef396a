"""Homes by their names, each built once: requests come in several threads, and building takes seconds."""

from __future__ import annotations

import threading
from typing import Final

from ucon.sim.cache import load_house
from ucon.sim.house import House

#: Homes that share a lock wait for each other; most do not share one.
_LOCKS: Final = tuple(threading.Lock() for _ in range(16))


def house_by_name(name: str) -> House:
    """The home with a name, as :func:`ucon.sim.cache.load_house` gives it.

    Args:
        name: of the home.

    Raises:
        UconError: there is no such home, or it cannot be built here.
    """
    with _LOCKS[hash(name) % len(_LOCKS)]:
        return load_house(name)
