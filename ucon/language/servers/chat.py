"""Client of OpenAI-compatible servers: ``POST {base_url}/chat/completions``.

Usable answers are kept on disk by the hash of their request. Temporary failures are retried with growing waits;
permanent ones end in one typed error. The key is read from the environment when a request is sent, and is in no file,
no message and no cache.
"""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from ucon.core.errors import ConfigError, ServerError
from ucon.core.files import canonical_json, sha256_bytes
from ucon.language.servers.answer_cache import AnswerCache
from ucon.language.servers.answers import Reply, Usage
from ucon.language.servers.chat_request import AskLimits, ChatRequest, usable_data
from ucon.language.servers.post import checked_url, get_status

Message = Mapping[str, Any]
"""``role`` (system, user, assistant) and ``content``: a text, or a list of parts (texts and images)."""

__all__ = ["ChatClient", "Message", "Reply", "Usage"]


class ChatClient:
    """Asks one model of one server. Threads may share it."""

    from_command_line = ("base_url", "api_key_env")
    """The server that habits and a secret are sent to: only the command line may name it, no stored configuration."""

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
        """Choose server and model; nothing is sent yet.

        Args:
            base_url: such as ``http://127.0.0.1:8000/v1``.
            model: name of the model as the server knows it.
            api_key_env: environment variable that holds the key; "" for servers without one.
            timeout_s: seconds of one attempt.
            temperature: of the sampling.
            seed: of the sampling and of the waits.
            max_tokens: longest answer.
            attempts: most requests for one question.
            backoff_s: first wait; it doubles up to ``max_wait_s``, which also limits ``Retry-After``.
            max_wait_s: longest wait.
            cache: answers on disk; by default in the user's cache folder.
            sleep: how to wait.

        Raises:
            ConfigError: ``base_url`` is no address or contains a name or a key; a number out of range.
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
        self.cache = cache or AnswerCache()
        self.sleep = sleep
        self.schemas = True
        """Whether the server accepts ``response_format``, as far as is known."""
        self._usage = Usage()
        self._lock = threading.Lock()

    @property
    def usage(self) -> Usage:
        """What was asked and spent so far."""
        return self._usage

    def check(self) -> None:
        """Ask the server for the list of its models, to see that it is there and accepts the key.

        Raises:
            ConfigError: the variable of the key is not set, or the server refuses the key.
            ServerError: it cannot be reached.
        """
        status, problem = get_status(f"{self.base_url}/models", self.headers(), self.timeout_s)
        if status in (401, 403):
            raise self.refused(status)
        if status is None:
            raise ServerError(
                f"{self.base_url} (model '{self.model}'): {problem}; check that the server is running, or fix base_url",
                server=self.base_url,
                status=None,
                attempts=1,
            )

    def refused(self, status: int | None) -> ConfigError:
        """The error for a key that the server refuses with this HTTP status."""
        how = f"'{self.api_key_env}'" if self.api_key_env else "that api_key_env names"
        what = f"{self.base_url} (model '{self.model}'): HTTP {status}, the key is refused"
        return ConfigError(f"{what}; put the right one into the environment variable {how}")

    def ask(
        self,
        messages: Sequence[Message],
        *,
        schema: Mapping[str, Any] | None = None,
        seed: int = 0,
        usable: Callable[[str], bool] | None = None,
        limits: AskLimits | None = None,
    ) -> Reply:
        """The answer to a conversation, from the cache or the server.

        Args:
            messages: the conversation so far; the last one is the user's.
            schema: JSON schema of an object. ``data`` of the reply is then an object, but the server may have ignored
                the schema: validate it.
            seed: added to the client's, for another answer to the same question.
            usable: decides whether a text is an answer; by default it must be JSON of ``schema``. With it, ``data`` may
                be None.
            limits: of attempts and wall time; by default the client's attempts, each with its timeout.

        Raises:
            ConfigError: the variable of the key is not set.
            AnswerError: the server answers, but never with something usable.
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
        kept = self.cache.get(key)
        found = usable_data(kept[0].text, schema, usable) if kept else None
        if kept is not None and found is not None:
            self.count(Usage(calls=1, cached=1))
            return Reply.of(kept[0], found[0], kept[1], 0)
        return ChatRequest(self, payload, schema, key, usable, limits or AskLimits(self.attempts)).answered()

    def count(self, more: Usage) -> None:
        """Add to :attr:`usage`; safe between threads."""
        with self._lock:
            names = Usage.__dataclass_fields__
            self._usage = Usage(**{name: getattr(self._usage, name) + getattr(more, name) for name in names})

    def headers(self) -> dict[str, str]:
        """Headers of a request, with the key.

        Raises:
            ConfigError: the variable of the key is not set.
        """
        key = self.key()
        return {"Authorization": f"Bearer {key}"} if key else {}

    def key(self) -> str:
        """The key; "" for servers without one.

        Raises:
            ConfigError: the variable is not set, or holds no printable ASCII.
        """
        if not self.api_key_env:
            return ""
        key = os.environ.get(self.api_key_env, "").strip()
        if not key or not (key.isascii() and key.isprintable()):
            raise ConfigError(
                f"{self.base_url}: environment variable '{self.api_key_env}' holds no usable key; set it, or leave "
                "api_key_env empty for a server without keys"
            )
        return key
