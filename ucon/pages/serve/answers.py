"""Answers in JSON: what a handler returns, errors in one line, requests of limited size."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, Final

from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from ucon.core.errors import ConfigError, UconError, brief
from ucon.core.untrusted.strict_json import JsonError, parse_json

#: Largest request in bytes: an answer of a study or an action has a few hundred.
MOST_BYTES: Final = 1 << 16

#: From the query's words (GET) or the body's object (POST) to the answer: plain values, or a response.
Handler = Callable[[Mapping[str, Any]], Any]


def asked(path: str, handler: Handler) -> Route:
    """A route that answers a GET from the words of the query.

    Args:
        path: of the address.
        handler: is called in a thread.
    """

    async def answer(request: Request) -> Response:
        return await _answered(handler, {**request.query_params, **request.path_params})

    return Route(path, answer, methods=["GET"])


def told(path: str, handler: Handler) -> Route:
    """A route that takes a POST of a JSON object.

    Args:
        path: of the address.
        handler: is called in a thread.
    """

    async def answer(request: Request) -> Response:
        if request.headers.get("content-type", "").partition(";")[0].strip() != "application/json":
            return _error("expected JSON", 415)
        body = bytearray()
        async for chunk in request.stream():
            body += chunk
            if len(body) > MOST_BYTES:
                return _error(f"more than {MOST_BYTES} bytes", 413)
        try:
            value = parse_json(bytes(body))
        except JsonError as error:
            return _error(str(error), 400)
        if not isinstance(value, dict):
            return _error("expected an object", 400)
        return await _answered(handler, {**value, **request.path_params})

    return Route(path, answer, methods=["POST"])


async def _answered(handler: Handler, words: Mapping[str, Any]) -> Response:
    try:
        found = await run_in_threadpool(handler, words)
    except UconError as error:
        return _error(" ".join(str(error).split()), 400)
    except OSError as error:
        where = error.filename2 or error.filename or "the disk"
        return _error(f"{where}: {error.strerror}; make room or fix permissions, and try again", 500)
    return found if isinstance(found, Response) else JSONResponse(found)


def _error(message: str, status: int) -> JSONResponse:
    return JSONResponse({"error": message}, status)


def text(words: Mapping[str, Any], name: str, most: int = 200, default: str | None = None) -> str:
    """A text of a request.

    Args:
        words: of the request.
        name: of the text.
        most: longest length in characters.
        default: value where none is given; None: one is required.

    Raises:
        ConfigError: it is missing, not a text, or too long.
    """
    value = words.get(name, default)
    if not isinstance(value, str) or len(value) > most:
        raise ConfigError(f"{name}={brief(value)}: expected a text of at most {most} characters")
    return value


def whole(words: Mapping[str, Any], name: str, low: int, high: int, default: int | None = None) -> int:
    """A whole number of a request, written as a number or in digits.

    Args:
        words: of the request.
        name: of the number.
        low: least value.
        high: largest value.
        default: value where none is given; None: one is required.

    Raises:
        ConfigError: it is missing, not a whole number, or out of range.
    """
    value = words.get(name, default)
    if isinstance(value, str) and value.isascii() and value.isdecimal() and len(value) < 12:
        value = int(value)
    if type(value) is not int or not low <= value <= high:
        raise ConfigError(f"{name}={brief(value)}: expected a whole number from {low} to {high}")
    return value


def number(words: Mapping[str, Any], name: str, low: float, high: float) -> float:
    """A number of a query.

    Args:
        words: of the request.
        name: of the number.
        low: least value.
        high: largest value.

    Raises:
        ConfigError: it is missing, not a number, or out of range.
    """
    try:
        value = float(text(words, name, 32))
    except ValueError:
        value = math.nan
    if not low <= value <= high:  # also refuses NaN
        raise ConfigError(f"{name}={brief(words.get(name))}: expected a number from {low:g} to {high:g}")
    return value


def choice(words: Mapping[str, Any], name: str, among: tuple[str, ...]) -> str:
    """One of several words.

    Args:
        words: of the request.
        name: of the word.
        among: those that may be chosen.

    Raises:
        ConfigError: it is not one of them.
    """
    value = words.get(name)
    if not isinstance(value, str) or value not in among:
        raise ConfigError(f"{name}={brief(value)}: expected one of {', '.join(among)}")
    return value
