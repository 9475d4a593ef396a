"""Language models behind an OpenAI-compatible server: ``POST {base_url}/chat/completions``.

An answer that was once good is kept on disk by the hash of its request. What fails for a while is asked again, waiting
longer each time; what fails for good ends in one typed error. The key is read from the environment when a request is
sent, and is in no file, no message and no cache.
"""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

from ucon.core.errors import AnswerError, ConfigError, ServerError
from ucon.core.files import canonical_json, sha256_bytes
from ucon.core.rng import stream
from ucon.language.answer_cache import AnswerCache
from ucon.language.answers import CUT_OFF, Said, json_object, read_answer, refusal
from ucon.language.post import Outcome, checked_url, post_json

Message = Mapping[str, str]
"""``role`` (system, user, assistant) and ``content``."""

_PASSING: Final = frozenset({408, 409, 425, 429})
"""Refusals (beside 5xx) that may be gone a moment later."""
_NO_SCHEMA: Final = frozenset({400, 404, 415, 422, 501})
"""How servers refuse a ``response_format`` that they do not know."""
_REMEDY: Final = {
    401: "check the key in the environment variable that api_key_env names",
    403: "check the key in the environment variable that api_key_env names",
    404: "check base_url (it usually ends in /v1) and model",
    413: "the prompt is too long for this server; shorten it",
}


@dataclass(frozen=True, slots=True)
class Reply:
    """An answer and what it cost when it was given."""

    text: str
    data: dict[str, Any] | None
    """The JSON object in it, where one was asked for."""
    cut_off: bool
    """Whether it ended at ``max_tokens`` and not by itself."""
    prompt_tokens: int
    completion_tokens: int
    seconds: float
    attempts: int
    """Requests that were sent for it; 0 if it was kept from an earlier run and cost nothing now."""


@dataclass(frozen=True, slots=True)
class Usage:
    """What a client did so far. Tokens and seconds are those really spent, cached answers cost none."""

    calls: int = 0
    cached: int = 0
    attempts: int = 0
    prompt_tokens: int = 0
    completion_tokens: int = 0
    seconds: float = 0.0


class ChatClient:
    """Asks one model of one server. Threads may share it."""

    def __init__(
        self,
        base_url: str,
        model: str,
        *,
        api_key_env: str = "",
        timeout_s: float = 120.0,
        temperature: float = 0.0,
        seed: int = 0,
        max_tokens: int = 2048,
        attempts: int = 6,
        backoff_s: float = 1.0,
        max_wait_s: float = 60.0,
        cache: AnswerCache | None = None,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        """Describe server and model; nothing is sent yet.

        Args:
            base_url: such as ``http://127.0.0.1:8000/v1``.
            model: name of the model as the server knows it.
            api_key_env: environment variable that holds the key; empty for servers without one.
            timeout_s: wall time of one attempt.
            temperature: of the sampling.
            seed: of the sampling and of the waits.
            max_tokens: longest answer.
            attempts: how often one question is sent at most.
            backoff_s: first wait; it doubles up to ``max_wait_s``, which caps ``Retry-After`` as well.
            max_wait_s: longest wait.
            cache: answers on disk; default in the user's cache folder.
            sleep: how to wait.

        Raises:
            ConfigError: a ``base_url`` that is none or carries a name or a key; a number out of range.
        """
        self.base_url = checked_url(base_url)
        if not model or attempts < 1 or min(timeout_s, max_tokens) <= 0 or min(backoff_s, max_wait_s, temperature) < 0:
            raise ConfigError(
                f"chat client of model '{model}': expected a model name, attempts >= 1, timeout_s and max_tokens > 0, "
                "backoff_s, max_wait_s and temperature >= 0"
            )
        self.model = model
        self.api_key_env = api_key_env
        self.timeout_s = timeout_s
        self.temperature = temperature
        self.seed = seed
        self.max_tokens = max_tokens
        self.attempts = attempts
        self.backoff_s = backoff_s
        self.max_wait_s = max_wait_s
        self._cache = cache or AnswerCache()
        self._sleep = sleep
        self._schemas = True
        self._usage = Usage()
        self._lock = threading.Lock()

    @property
    def usage(self) -> Usage:
        """What was asked and spent so far."""
        return self._usage

    def ask(self, messages: Sequence[Message], *, schema: Mapping[str, Any] | None = None, seed: int = 0) -> Reply:
        """Answer to a conversation.

        Args:
            messages: the conversation so far, the last one the user's.
            schema: JSON schema of an object; the answer's ``data`` is then an object, which the server may not have
                held to the schema: validate it.
            seed: added to the client's, for another answer to the same question.

        Raises:
            ConfigError: the variable of the key is not set.
            AnswerError: the server answers, but never with what can be used.
            ServerError: it cannot be reached, refuses, or gave no answer in time.
        """
        payload: dict[str, Any] = {
            "model": self.model,
            "messages": [dict(message) for message in messages],
            "temperature": self.temperature,
            "seed": (self.seed + seed) % 2**31,
            "max_tokens": self.max_tokens,
        }
        key = sha256_bytes(canonical_json([self.base_url, payload, schema]).encode("utf-8", "replace"))
        kept = self._cache.get(key)
        data = json_object(kept[0].text, _required(schema)) if kept and schema is not None else None
        if kept is not None and (data is not None or schema is None):
            self._count(Usage(calls=1, cached=1))
            return _reply(kept[0], data, kept[1], 0)
        return _Question(self, payload, schema, key).answered()

    def _count(self, more: Usage) -> None:
        with self._lock:
            names = Usage.__dataclass_fields__
            self._usage = Usage(**{name: getattr(self._usage, name) + getattr(more, name) for name in names})

    def _headers(self) -> dict[str, str]:
        key = self._key()
        return {"Authorization": f"Bearer {key}"} if key else {}

    def _key(self) -> str:
        if not self.api_key_env:
            return ""
        key = os.environ.get(self.api_key_env, "").strip()
        if not key or not (key.isascii() and key.isprintable()):
            raise ConfigError(
                f"{self.base_url}: environment variable '{self.api_key_env}' holds no usable key; set it, or leave "
                "api_key_env empty for a server without keys"
            )
        return key


class _Question:
    """One request on its way to an answer."""

    def __init__(self, client: ChatClient, payload: dict[str, Any], schema: Mapping[str, Any] | None, key: str) -> None:
        self._client = client
        self._payload = payload
        self._schema = schema
        self._key = key
        self._rng = stream(client.seed, "chat", "wait", key)
        self._attempts = 0
        self._unusable = 0
        self._spent = Usage()

    def answered(self) -> Reply:
        """Send it until there is a usable answer; raises what :meth:`ChatClient.ask` says."""
        start = time.monotonic()
        try:
            return self._until_good(start)
        finally:
            spent = replace(self._spent, attempts=self._attempts, seconds=time.monotonic() - start)
            self._client._count(spent)

    def _until_good(self, start: float) -> Reply:
        client, left = self._client, self._client.attempts
        structured = self._schema is not None and client._schemas
        while True:
            outcome = self._send(structured)
            found = self._usable(outcome) if outcome.status is not None and outcome.status < 300 else None
            if isinstance(found, tuple):
                said, data = found
                seconds = time.monotonic() - start
                client._schemas = client._schemas and (structured or self._schema is None)
                client._cache.put(self._key, said, seconds)
                self._spent = replace(self._spent, calls=1)
                return _reply(said, data, seconds, self._attempts)
            if structured and outcome.status in _NO_SCHEMA:
                structured = False  # it does not know response_format: ask in words, at once
                continue
            left -= 1
            if left <= 0 or not _passing(outcome):
                raise self._error(outcome, found, time.monotonic() - start)
            self._wait(client.attempts - left, outcome.retry_after_s)

    def _send(self, structured: bool) -> Outcome:
        client, payload = self._client, dict(self._payload)
        # The same seed would bring the same unusable answer.
        payload["seed"] = (payload["seed"] + self._unusable) % 2**31
        if structured:
            schema = {"name": "answer", "strict": True, "schema": self._schema}
            payload["response_format"] = {"type": "json_schema", "json_schema": schema}
        elif self._schema is not None:
            payload["messages"] = _in_words(payload["messages"], self._schema)
        headers = client._headers()
        self._attempts += 1
        return post_json(f"{client.base_url}/chat/completions", payload, headers, client.timeout_s)

    def _usable(self, outcome: Outcome) -> tuple[Said, dict[str, Any] | None] | str:
        """What an answer says, with the object that was asked for; or what is wrong with it."""
        try:
            said = read_answer(outcome.body)
            spent = self._spent
            self._spent = replace(
                spent,
                prompt_tokens=spent.prompt_tokens + said.prompt_tokens,
                completion_tokens=spent.completion_tokens + said.completion_tokens,
            )
            data = None if self._schema is None else json_object(said.text, _required(self._schema))
            if data is None and self._schema is not None:
                raise ValueError("an answer without a whole JSON object" + CUT_OFF * said.cut_off)
        except ValueError as error:
            self._unusable += 1
            return str(error)
        return said, data

    def _wait(self, failures: int, asked_s: float | None) -> None:
        """Exponential backoff with jitter, or what the server asks for; capped either way."""
        client = self._client
        grown = client.backoff_s * 2 ** min(failures - 1, 30) * (0.5 + 0.5 * float(self._rng.random()))
        client._sleep(min(client.max_wait_s, grown if asked_s is None else asked_s))

    def _error(self, outcome: Outcome, unusable: str | None, seconds: float) -> ServerError:
        client = self._client
        count = f"{self._attempts} attempt{'s' * (self._attempts > 1)} in {seconds:.0f} s"
        facts = {"server": client.base_url, "status": outcome.status, "attempts": self._attempts}
        head = f"{client.base_url} (model '{client.model}'): "
        if unusable is not None:
            text = f"{head}{unusable} (HTTP {outcome.status}), {count}; try another model, seed or max_tokens"
            return AnswerError(text, **facts)  # type: ignore[arg-type]
        said = refusal(outcome.body, client._key())
        remedy = _REMEDY.get(outcome.status or 0, "see what the server says and mend the request")
        if _passing(outcome):
            remedy = "see that the server runs and is not overloaded, or raise timeout_s, attempts or max_wait_s"
        elif outcome.status is None:
            remedy = "give a base_url whose certificate this machine trusts"
        return ServerError(f"{head}{outcome.problem}{said}, {count}; {remedy}", **facts)  # type: ignore[arg-type]


def _reply(said: Said, data: dict[str, Any] | None, seconds: float, attempts: int) -> Reply:
    return Reply(said.text, data, said.cut_off, said.prompt_tokens, said.completion_tokens, seconds, attempts)


def _passing(outcome: Outcome) -> bool:
    """Whether the same request may do better later."""
    if outcome.status is None:
        return not outcome.hopeless
    return outcome.status < 300 or outcome.status >= 500 or outcome.status in _PASSING


def _required(schema: Mapping[str, Any] | None) -> tuple[str, ...]:
    return tuple((schema or {}).get("required", ()))


def _in_words(messages: list[dict[str, str]], schema: Mapping[str, Any]) -> list[dict[str, str]]:
    """The conversation with the schema told in the last message."""
    told = "Answer with one JSON object of this JSON schema and with nothing else:\n" + canonical_json(schema)
    return [*messages[:-1], {**messages[-1], "content": f"{messages[-1]['content']}\n\n{told}"}]
