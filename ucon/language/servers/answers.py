"""Answers of chat servers: text and cost, and the JSON object inside the text."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any, Final

from ucon.core.text import shown
from ucon.core.untrusted.strict_json import JsonError, parse_first, parse_json

_THOUGHT = re.compile(r"<(think|thinking|reasoning)>.*?</\1>", re.DOTALL)
_FENCED = re.compile(r"\s*```\w*\s*\n(.*?)\n?\s*```\s*", re.DOTALL)
_MOST_BRACES: Final = 200
#: Largest credible number of tokens of an answer or a prompt.
MOST_TOKENS: Final = 10**9
CUT_OFF: Final = " that was cut off at max_tokens (raise it)"


@dataclass(frozen=True, slots=True)
class Completion:
    """The text of a completion and its tokens; 0 where the server does not count them."""

    text: str
    prompt_tokens: int
    completion_tokens: int
    cut_off: bool
    """Whether it was cut off at ``max_tokens``."""


@dataclass(frozen=True, slots=True)
class Reply:
    """An answer and its cost."""

    text: str
    data: dict[str, Any] | None
    """The JSON object in it, where one was asked for."""
    cut_off: bool
    """Whether it was cut off at ``max_tokens``."""
    prompt_tokens: int
    completion_tokens: int
    seconds: float
    attempts: int
    """Requests sent for it; 0 if it came from the cache."""

    @classmethod
    def of(cls, said: Completion, data: dict[str, Any] | None, seconds: float, attempts: int) -> Reply:
        """The reply for a completion.

        Args:
            said: the completion.
            data: the JSON object in it, or None.
            seconds: wall time.
            attempts: requests sent.
        """
        return cls(said.text, data, said.cut_off, said.prompt_tokens, said.completion_tokens, seconds, attempts)


@dataclass(frozen=True, slots=True)
class Usage:
    """What a client did and spent so far; cached answers cost nothing."""

    calls: int = 0
    cached: int = 0
    attempts: int = 0
    prompt_tokens: int = 0
    completion_tokens: int = 0
    seconds: float = 0.0


def read_answer(body: bytes) -> Completion:
    """The first choice of a chat completion; a choice without text is "", since it has a cost too.

    Raises:
        ValueError: the body is not UTF-8, not JSON, or no chat completion.
    """
    try:
        answer = parse_json(body, surrogates=True)
    except JsonError as error:
        raise ValueError(f"an answer that is not usable: {error}") from None
    try:
        choice = answer["choices"][0]
        text = choice["message"]["content"]
    except (KeyError, IndexError, TypeError):
        raise ValueError("an answer without choices[0].message.content") from None
    cut_off = choice.get("finish_reason") == "length"
    text = text.strip() and text if isinstance(text, str) else ""
    used = answer.get("usage")
    used = used if isinstance(used, dict) else {}
    return Completion(text, _count(used.get("prompt_tokens")), _count(used.get("completion_tokens")), cut_off)


def refusal(body: bytes, key: str) -> str:
    """A server's own message about a refusal, in brackets.

    Args:
        body: of the response.
        key: secret that is replaced in the message.

    Returns:
        At most 200 characters; "" if the body is empty.
    """
    text = body[:4000].decode("utf-8", "replace")
    try:
        error = parse_json(text)
        error = error.get("error", error)
        text = str(error.get("message", text) if isinstance(error, dict) else error)
    except (JsonError, AttributeError):
        pass
    text = text.replace(key, "***") if key else text
    text = " ".join(shown(text).split())[:200]
    return f" ('{text}')" if text else ""


def without_thoughts(text: str) -> str:
    """The text without the parts that a model marks as reasoning."""
    return _THOUGHT.sub("", text).strip()


def json_object(text: str, required: tuple[str, ...] = ()) -> dict[str, Any] | None:
    """The JSON object in a model's text; None where there is none.

    A text that is one object, fenced or not, is taken as it is. In prose, only an object with all ``required`` keys is
    taken, so that an inner part of an object that was cut off does not pass for the whole.

    Args:
        text: the model's text.
        required: keys.
    """
    bare = without_thoughts(text)
    fenced = _FENCED.fullmatch(bare)
    whole = _decoded(fenced[1] if fenced else bare)
    if whole is not None:
        return whole[0]
    position = bare.find("{")
    for _ in range(_MOST_BRACES):
        if position < 0:
            return None
        found = _decoded(bare[position:], all_of_it=False)
        if found is not None and all(key in found[0] for key in required):
            return found[0]
        position = bare.find("{", position + (found[1] if found else 1))
    return None


def _decoded(text: str, *, all_of_it: bool = True) -> tuple[dict[str, Any], int] | None:
    """The object at the start of a text and its length."""
    stripped = text.strip() if all_of_it else text
    try:
        value, end = parse_first(stripped)
    except JsonError:
        return None
    return (value, end) if isinstance(value, dict) and (not all_of_it or end == len(stripped)) else None


def _count(value: object) -> int:
    """A number of tokens; 0 where the server does not count them.

    Raises:
        ValueError: more than any answer has.
    """
    count = value if type(value) is int and value > 0 else 0
    if count > MOST_TOKENS:
        raise ValueError(f"an answer of {count} tokens")
    return count
