"""Routes of the page *Play*."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from starlette.routing import Route

from ucon.pages.serve.answers import asked, choice, text, told, whole
from ucon.pages.serve.play.games import LEVELS, PICTURES, Games
from ucon.task.rules import PAPER

_Words = Mapping[str, Any]


def play_routes(games: Games) -> list[Route]:
    """Routes of the page.

    Args:
        games: of the server.
    """

    def choices(_: _Words) -> dict[str, Any]:
        return {
            "levels": LEVELS,
            "sets": games.sets,
            "pictures": PICTURES,
            "left": games.left(),
            "rules": PAPER.actions(),
        }

    def begin(words: _Words) -> dict[str, Any]:
        name = games.open(
            text(words, "player", 40),
            choice(words, "level", LEVELS),
            text(words, "episodes"),
            whole(words, "n", 1, 2000),
            whole(words, "picture_px", PICTURES[0], PICTURES[-1]),
        )
        game = games.get(name)
        return {"game": name, "rules": game.rules(), "state": game.state()}

    def state(words: _Words) -> dict[str, Any]:
        return games.get(text(words, "game")).state()

    def act(words: _Words) -> dict[str, Any]:
        game = games.get(text(words, "game"))
        return game.act(text(words, "episode"), whole(words, "step", 0, 100_000), whole(words, "action", 0, 6))

    def habits(words: _Words) -> list[str]:
        return games.get(text(words, "game")).habits()

    def result(words: _Words) -> dict[str, Any]:
        return games.get(text(words, "game")).result(text(words, "episode"))

    return [
        asked("/api/play/choices", choices),
        told("/api/play/begin", begin),
        asked("/api/play/state", state),
        told("/api/play/act", act),
        asked("/api/play/habits", habits),
        asked("/api/play/result", result),
    ]
