"""Routes of the page *Homes*: plans, cards of things, and frames of a walk."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from starlette.responses import Response
from starlette.routing import Route

from ucon.core.errors import ConfigError, brief
from ucon.pages.home_plan import plan_of
from ucon.pages.serve.answers import asked, number, text, whole
from ucon.pages.serve.home_cards import Cards
from ucon.pages.serve.house_by_name import house_by_name
from ucon.pages.serve.walk import Camera, Walks
from ucon.scenes import SCENES
from ucon.scenes.own import kept_names
from ucon.sim.house import House
from ucon.sim.state import SceneState

_Words = Mapping[str, Any]
#: Names of homes: scenes, their variants, generated ones and users' own. Nothing that could be a path.
_NAME: Final = re.compile(
    r"[A-Za-z0-9_]{1,60}(~[0-9]{1,9})?|procedural:[a-z_]{1,30}:[0-9]{1,9}|own:[a-z0-9_]{1,40}:[0-9a-f]{12}"
)
#: Largest number of users' own homes that are listed.
_MOST_OWN: Final = 50
#: Largest number of things that are open at once in a walk.
_MOST_OPEN: Final = 200


def home_of(words: _Words) -> House:
    """The home that a request names.

    Args:
        words: of the request; ``home`` is its name.

    Raises:
        ConfigError: this cannot be the name of a home.
        UconError: there is no such home, or it cannot be built here.
    """
    name = text(words, "home", 100)
    if not _NAME.fullmatch(name):
        raise ConfigError(f"home '{brief(name)}': expected a name such as Rs_int, Rs_int~3 or procedural:house:17")
    return house_by_name(name)


def home_routes(cards: Cards) -> list[Route]:
    """Routes of the page.

    Args:
        cards: say what can be kept where.
    """
    walks = Walks()

    def names(_: _Words) -> tuple[str, ...]:
        return (*kept_names()[:_MOST_OWN], *SCENES)

    def plan(words: _Words) -> dict[str, Any]:
        return _plan(home_of(words))

    def card(words: _Words) -> dict[str, Any]:
        house = home_of(words)
        return cards.card(house, whole(words, "thing", 0, house.n_items - 1))

    def frame(words: _Words) -> Response:
        house = home_of(words)
        return Response(walks.frame(house, _camera(words), _open(words, house)), media_type="image/jpeg")

    def pick(words: _Words) -> dict[str, Any]:
        house = home_of(words)
        u, v = number(words, "u", 0, 1), number(words, "v", 0, 1)
        thing = walks.pick(house, _camera(words), _open(words, house), u, v)
        return {"thing": thing}

    return [
        asked("/api/homes/names", names),
        asked("/api/homes/plan", plan),
        asked("/api/homes/card", card),
        asked("/api/homes/frame", frame),
        asked("/api/homes/pick", pick),
    ]


def _plan(house: House) -> dict[str, Any]:
    """The plan with what the walk needs: where one can stand, what opens, rooms and middles of the things."""
    grid, openable = house.grid, SceneState(house).openable
    return {
        **plan_of(house),
        "kind": house.spec.kind,
        "area_m2": round(house.spec.area_m2, 1),
        "origin": [float(v) for v in grid.origin_xy],
        "free": ["".join("1" if cell else "0" for cell in row) for row in grid.free.tolist()],
        "middles": [
            [round(float(box[k] + box[k + 3]) / 2, 2) for k in range(3)] for box in house.boxes[: house.n_items]
        ],
        "room_of": [item.room for item in house.spec.items],
        "openable": np.flatnonzero(openable[: house.n_items]).tolist(),
    }


def _camera(words: _Words) -> Camera:
    return Camera(
        number(words, "x", -1000, 1000), number(words, "y", -1000, 1000), number(words, "yaw", -1000, 1000),
        number(words, "pitch", -60, 60),
    )  # fmt: skip


def _open(words: _Words, house: House) -> frozenset[int]:
    """Numbers of the things that are open."""
    listed = [word for word in text(words, "open", 2000, "").split(",") if word]
    usable = {str(k) for k in np.flatnonzero(SceneState(house).openable[: house.n_items]).tolist()}
    if len(listed) > _MOST_OPEN or not usable.issuperset(listed):
        raise ConfigError(f"open={brief(words.get('open'))}: expected numbers of things that open")
    return frozenset(map(int, listed))
