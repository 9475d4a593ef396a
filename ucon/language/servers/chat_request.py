"""One question to a chat server: requests until there is a usable answer, within a deadline."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Final, Protocol

from ucon.core.errors import AnswerError, ServerError
from ucon.core.files import canonical_json
from ucon.core.rng import stream
from ucon.language.servers.answer_cache import AnswerCache
from ucon.language.servers.answers import CUT_OFF, Completion, Reply, Usage, json_object, read_answer, refusal
from ucon.language.servers.post import Outcome, post_json

Usable = Callable[[str], bool]
"""Whether a text can be used as an answer."""

#: No further attempt begins with less time than this left, seconds.
_LEAST_S: Final = 0.005

_PASSING: Final = frozenset({408, 409, 425, 429})
"""HTTP statuses (besides 5xx) of temporary failures."""
_NO_SCHEMA: Final = frozenset({400, 404, 415, 422, 501})
"""HTTP statuses by which servers refuse ``response_format``."""
_REMEDY: Final = {
    401: "check the key in the environment variable that api_key_env names",
    403: "check the key in the environment variable that api_key_env names",
    404: "check base_url (it usually ends in /v1) and model",
    413: "the prompt is too long for this server; shorten it",
}


@dataclass(frozen=True, slots=True)
class AskLimits:
    """Limits of one question.

    Attributes:
        attempts: most requests.
        wall_s: seconds of all attempts and waits together; None: unlimited.
    """

    attempts: int
    wall_s: float | None = None


class Connection(Protocol):
    """What a request needs of its client (:class:`ucon.language.servers.chat.ChatClient`)."""

    base_url: str
    model: str
    seed: int
    timeout_s: float
    backoff_s: float
    max_wait_s: float
    schemas: bool
    """Whether the server accepts ``response_format``."""
    cache: AnswerCache
    sleep: Callable[[float], None]

    def headers(self) -> dict[str, str]:
        """Headers of a request, with the key."""
        ...

    def key(self) -> str:
        """The key; no message may contain it."""
        ...

    def count(self, more: Usage) -> None:
        """Add what was spent."""
        ...


class ChatRequest:
    """One question on its way to an answer."""

    def __init__(
        self,
        client: Connection,
        payload: dict[str, Any],
        schema: Mapping[str, Any] | None,
        key: str,
        usable: Usable | None,
        limits: AskLimits,
    ) -> None:
        """Prepare a request; nothing is sent yet.

        Args:
            client: server, timeouts and cache.
            payload: of the request.
            schema: see :meth:`ucon.language.servers.chat.ChatClient.ask`.
            key: the cache key of the answer.
            usable: see :meth:`ucon.language.servers.chat.ChatClient.ask`.
            limits: of attempts and wall time.
        """
        self._client = client
        self._payload = payload
        self._schema = schema
        self._key = key
        self._wanted = usable
        self._limits = limits
        self._deadline = time.monotonic() + (float("inf") if limits.wall_s is None else limits.wall_s)
        self._rng = stream(client.seed, "chat", "wait", key)
        self._attempts = 0
        self._unusable = 0
        self._spent = Usage()

    def answered(self) -> Reply:
        """Send requests until there is a usable answer.

        Raises:
            ConfigError: the variable of the key is not set.
            AnswerError: the server answers, but never with something usable.
            ServerError: it cannot be reached, refuses, or gave no answer in time.
        """
        start = time.monotonic()
        try:
            return self._until_good(start)
        finally:
            spent = replace(self._spent, attempts=self._attempts, seconds=time.monotonic() - start)
            self._client.count(spent)

    def _until_good(self, start: float) -> Reply:
        client, left = self._client, self._limits.attempts
        structured = self._schema is not None and client.schemas
        while True:
            outcome = self._send(structured)
            found = self._usable(outcome) if outcome.status is not None and outcome.status < 300 else None
            if isinstance(found, tuple):
                said, data = found
                seconds = time.monotonic() - start
                client.schemas = client.schemas and (structured or self._schema is None)
                client.cache.put(self._key, said, seconds)
                self._spent = replace(self._spent, calls=1)
                return Reply.of(said, data, seconds, self._attempts)
            late = time.monotonic() > self._deadline - _LEAST_S
            if structured and outcome.status in _NO_SCHEMA and not late:
                structured = False  # it does not know response_format: ask in words, at once
                continue
            left -= 1
            if left <= 0 or not _passing(outcome) or not self._waited(outcome.retry_after_s, left):
                raise self._error(outcome, found, time.monotonic() - start)

    def _send(self, structured: bool) -> Outcome:
        client, payload = self._client, dict(self._payload)
        # The same seed would give the same unusable answer.
        payload["seed"] = (payload["seed"] + self._unusable) % 2**31
        if structured:
            schema = {"name": "answer", "strict": True, "schema": self._schema}
            payload["response_format"] = {"type": "json_schema", "json_schema": schema}
        elif self._schema is not None:
            payload["messages"] = _in_words(payload["messages"], self._schema)
        headers = client.headers()
        self._attempts += 1
        seconds = max(min(client.timeout_s, self._deadline - time.monotonic()), _LEAST_S)
        return post_json(f"{client.base_url}/chat/completions", payload, headers, seconds)

    def _usable(self, outcome: Outcome) -> tuple[Completion, dict[str, Any] | None] | str:
        """The completion and the object that was asked for, or the fault as text."""
        try:
            said = read_answer(outcome.body)
            spent = self._spent
            self._spent = replace(
                spent,
                prompt_tokens=spent.prompt_tokens + said.prompt_tokens,
                completion_tokens=spent.completion_tokens + said.completion_tokens,
            )
            if not said.text:
                raise ValueError("an empty answer" + CUT_OFF * said.cut_off)
            found = usable_data(said.text, self._schema, self._wanted)
            if found is None:
                what = "an answer without a whole JSON object" if self._wanted is None else "an unusable answer"
                raise ValueError(what + CUT_OFF * said.cut_off)
        except ValueError as error:
            self._unusable += 1
            return str(error)
        return said, found[0]

    def _waited(self, asked_s: float | None, left: int) -> bool:
        """Wait with exponential backoff and jitter, or as the server asks; capped either way.

        False, at once, where the wait would leave no time for another attempt.
        """
        client, failures = self._client, self._limits.attempts - left
        grown = client.backoff_s * 2 ** min(failures - 1, 30) * (0.5 + 0.5 * float(self._rng.random()))
        wait = min(client.max_wait_s, grown if asked_s is None else asked_s)
        if time.monotonic() + wait > self._deadline - _LEAST_S:
            return False
        client.sleep(wait)
        return True

    def _error(self, outcome: Outcome, unusable: str | None, seconds: float) -> ServerError:
        client = self._client
        count = f"{self._attempts} attempt{'s' * (self._attempts > 1)} in {seconds:.0f} s"
        facts = {
            "server": client.base_url,
            "status": outcome.status,
            "attempts": self._attempts,
            "prompt_tokens": self._spent.prompt_tokens,
            "completion_tokens": self._spent.completion_tokens,
        }
        head = f"{client.base_url} (model '{client.model}'): "
        if unusable is not None:
            text = f"{head}{unusable} (HTTP {outcome.status}), {count}; try another model, seed or max_tokens"
            return AnswerError(text, **facts)  # type: ignore[arg-type]
        said = refusal(outcome.body, client.key())
        remedy = _REMEDY.get(outcome.status or 0, "read what the server says and fix the request")
        if _passing(outcome):
            remedy = "check that the server is running and not overloaded, or raise timeout_s, attempts or max_wait_s"
        elif outcome.status is None:
            remedy = "give a base_url whose certificate this machine trusts"
        return ServerError(f"{head}{outcome.problem}{said}, {count}; {remedy}", **facts)  # type: ignore[arg-type]


def usable_data(
    text: str, schema: Mapping[str, Any] | None, usable: Usable | None
) -> tuple[dict[str, Any] | None] | None:
    """Whether a text is an answer, and the JSON object in it.

    Args:
        text: of the completion.
        schema: of the object, or None.
        usable: replaces the test for an object.

    Returns:
        A tuple with the object (or None, for an answer without one); None where the text is no answer.
    """
    data = None if schema is None else json_object(text, _required(schema))
    good = (schema is None or data is not None) if usable is None else usable(text)
    return (data,) if good else None


def _passing(outcome: Outcome) -> bool:
    """Whether the same request may do better later."""
    if outcome.status is None:
        return not outcome.hopeless
    return outcome.status < 300 or outcome.status >= 500 or outcome.status in _PASSING


def _required(schema: Mapping[str, Any] | None) -> tuple[str, ...]:
    return tuple((schema or {}).get("required", ()))


def _in_words(messages: list[dict[str, Any]], schema: Mapping[str, Any]) -> list[dict[str, Any]]:
    """The conversation with the schema described in the last message."""
    told = "Answer with one JSON object of this JSON schema and with nothing else:\n" + canonical_json(schema)
    content = messages[-1]["content"]
    if isinstance(content, str):
        said: Any = f"{content}\n\n{told}"
    else:
        said = [*content, {"type": "text", "text": told}]
    return [*messages[:-1], {**messages[-1], "content": said}]
