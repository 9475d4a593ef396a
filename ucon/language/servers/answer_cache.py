"""Answers of language models on disk, by the hash of the request: a rerun costs nothing and gives the same answers."""

from __future__ import annotations

import json
import math
import sys
from pathlib import Path
from typing import Any

from ucon.core.files import canonical_json, sha256_bytes, user_cache, write_atomic
from ucon.core.untrusted.plain_file import read_bounded
from ucon.core.untrusted.strict_json import MAX_BYTES, parse_json
from ucon.language.servers.answers import MOST_TOKENS, Completion


class AnswerCache:
    """One file per answer. A damaged file is noticed by its checksum, and its question is asked again."""

    def __init__(self, folder: Path | None = None) -> None:
        """``folder``: by default ``chat`` in the user's cache folder."""
        self._folder = folder or user_cache() / "chat"
        self._warned = False

    def get(self, key: str) -> tuple[Completion, float] | None:
        """The cached answer to a request.

        Args:
            key: hash of the request.

        Returns:
            The answer and the seconds it took; None if it is not cached or is damaged.
        """
        path = self._path(key)
        try:
            kept: dict[str, Any] = parse_json(read_bounded(path, MAX_BYTES), surrogates=True)
            if kept.pop("sha256") != sha256_bytes(canonical_json(kept).encode()) or kept.pop("request") != key:
                raise ValueError("checksum")
            seconds, said = float(kept.pop("seconds")), Completion(**kept)
            _require_usable(said, seconds)
            return said, seconds
        except OSError:
            return None
        except (ValueError, KeyError, TypeError, AttributeError):
            self._warn(f"warning: {path} is damaged; its question is asked again")
            return None

    def put(self, key: str, said: Completion, seconds: float) -> None:
        """Keep an answer; where the folder cannot be written, warn once and continue.

        Args:
            key: hash of the request.
            said: the answer.
            seconds: wall time it took.
        """
        kept: dict[str, Any] = {
            "request": key,
            "text": said.text,
            "prompt_tokens": said.prompt_tokens,
            "completion_tokens": said.completion_tokens,
            "cut_off": said.cut_off,
            "seconds": round(seconds, 3),
        }
        whole = kept | {"sha256": sha256_bytes(canonical_json(kept).encode())}
        try:
            write_atomic(self._path(key), json.dumps(whole) + "\n")
        except OSError as error:
            if not self._warned:
                self._warn(f"warning: {self._folder} cannot be written ({error.strerror}); answers are not kept")
            self._warned = True

    def _path(self, key: str) -> Path:
        return self._folder / key[:2] / f"{key}.json"

    def _warn(self, text: str) -> None:
        print(text, file=sys.stderr)  # noqa: T201


def _require_usable(said: Completion, seconds: float) -> None:
    counts = (said.prompt_tokens, said.completion_tokens)
    right = isinstance(said.text, str) and type(said.cut_off) is bool and math.isfinite(seconds) and seconds >= 0
    if not (right and all(type(count) is int and 0 <= count <= MOST_TOKENS for count in counts)):
        raise ValueError("values")
