"""Typed errors. Each message says what was wrong, where, what was expected and what to do.

Entry points catch :class:`UconError` and end with its one line; anything else is a bug and keeps its traceback.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Sequence

from ucon.core.text import is_shown


class UconError(Exception):
    """Base of every error that a user can cause and correct."""


class DataError(UconError):
    """A file is missing, truncated or altered, or its content is not valid."""


class ConfigError(UconError):
    """An option, name or combination of options that does not exist."""


class SceneError(UconError):
    """A home that cannot be built, or a scene that does not exist."""


class PlacementError(UconError):
    """An object that cannot be put where it was asked to go."""


class EpisodeError(UconError):
    """An episode that cannot be sampled, loaded or replayed."""


class ActionError(UconError):
    """An action that the environment does not have."""


class DetectorError(UconError):
    """A detector that cannot be loaded, or stopped answering."""


class ServerError(UconError):
    """A server cannot be reached, refuses, or gives no usable answer.

    Attributes:
        server: its address.
        status: the last HTTP status; None without a response.
        attempts: requests sent.
        prompt_tokens: of answers that could not be used.
        completion_tokens: of answers that could not be used.
    """

    def __init__(
        self,
        message: str,
        *,
        server: str,
        status: int | None,
        attempts: int,
        prompt_tokens: int = 0,
        completion_tokens: int = 0,
    ) -> None:
        super().__init__(message)
        self.server = server
        self.status = status
        self.attempts = attempts
        self.prompt_tokens = prompt_tokens
        self.completion_tokens = completion_tokens


class AnswerError(ServerError):
    """A server works, but its answers to one request cannot be used."""


class DivergedError(UconError):
    """Training produced numbers that are not finite."""


def brief(value: object) -> str:
    """A value as messages show it: one line of at most 80 characters that is safe to print."""
    text = value if isinstance(value, str) else repr(value)
    text = text if len(text) <= 80 else f"{text[:80]}..."
    return text if is_shown(text) else ascii(text)[1:-1]


def unknown_name(kind: str, name: str, known: Iterable[str], *, remedy: str = "", meant: Sequence[str] = ()) -> str:
    """The message for a name that does not exist, with the nearest ones that do.

    Args:
        kind: the kind of thing that is named, such as ``detector``.
        name: the unknown name.
        known: the names that exist.
        remedy: added at the end.
        meant: existing names of similar meaning, the most similar first.
    """
    names, name = sorted(known), brief(name)
    close = difflib.get_close_matches(name, names, n=3)
    spelt = f"did you mean {', '.join(close)}?" if close else ""
    meaning = f"near in meaning: {', '.join(meant)}" if meant else ""
    hint = " ".join(part for part in (spelt, meaning) if part) or _sample(names)
    return f"unknown {kind} '{name}': {hint}{' ' + remedy if remedy else ''}"


def _sample(names: list[str]) -> str:
    shown = ", ".join(names[:12])
    more = f", ... ({len(names)} in all)" if len(names) > 12 else ""
    return f"expected one of {shown}{more}"
