"""Routes of the page *Study*: items without their key, answers, figures, and sheets and key as files."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from starlette.responses import Response
from starlette.routing import Route

from ucon.core.errors import ConfigError, brief
from ucon.core.untrusted.plain_file import read_plain
from ucon.evaluation.datasets.survey import LOOK, QUESTIONS, Rating
from ucon.pages.serve.answers import asked, text, told, whole
from ucon.pages.serve.studies import Studies

_Words = Mapping[str, Any]
_MOST_BYTES = 16 << 20


def study_routes(studies: Studies) -> list[Route]:
    """Routes of the page.

    Args:
        studies: of the server.
    """

    def listed(_: _Words) -> list[dict[str, Any]]:
        return studies.all()

    def make(words: _Words) -> list[dict[str, Any]]:
        studies.make(text(words, "study", 40), whole(words, "n", 2, 5000), whole(words, "seed", 0, 10**6))
        return studies.all()

    def items(words: _Words) -> dict[str, Any]:
        name, rater = text(words, "study", 40), text(words, "rater", 40)
        shown = [
            {"item": one.item, "object": one.object, "habit": one.habit, "place": one.place}
            for one in studies.key(name).values()
        ]
        return {"questions": QUESTIONS, "look": LOOK, "items": shown, "answers": _plain(studies.answers(name, rater))}

    def answer(words: _Words) -> dict[str, Any]:
        real, look = words.get("real"), words.get("look")
        if type(real) not in (int, type(None)) or not isinstance(look, str | None):
            raise ConfigError(f"real={brief(real)}, look={brief(look)}: expected a number and a word, or null")
        name, rater = text(words, "study", 40), text(words, "rater", 40)
        return {"answers": _plain(studies.answer(name, rater, whole(words, "item", 0, 10**9), real, look))}

    def figures(words: _Words) -> Any:
        return {"figures": studies.figures(text(words, "study", 40))}

    def sheet(words: _Words) -> Response:
        name, rater = text(words, "study", 40), text(words, "rater", 40)
        return _csv(studies.sheet(name, rater), f"{rater}.csv")

    def key(words: _Words) -> Response:
        name = text(words, "study", 40)
        return _csv(studies.key_file(name), f"{name}.key.csv")

    return [
        asked("/api/study/list", listed),
        told("/api/study/make", make),
        asked("/api/study/items", items),
        told("/api/study/answer", answer),
        asked("/api/study/figures", figures),
        asked("/api/study/sheet", sheet),
        asked("/api/study/key", key),
    ]


def _plain(answers: Mapping[int, Rating]) -> dict[str, list[Any]]:
    """Answers that are given, by item: number and word."""
    return {str(number): [one.real, one.look] for number, one in answers.items() if one.real is not None or one.look}


def _csv(path: Path, name: str) -> Response:
    """A file to be saved; its name consists of letters, digits, hyphens and underscores."""
    try:
        data = read_plain(path, _MOST_BYTES)
    except FileNotFoundError:
        raise ConfigError("this sheet does not exist yet; it is written with the first answer") from None
    headers = {"Content-Disposition": f'attachment; filename="{name}"'}
    return Response(data, media_type="text/csv; charset=utf-8", headers=headers)
