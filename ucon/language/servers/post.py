"""One HTTP request to a server, with a typed result within a time limit."""

from __future__ import annotations

import http.client
import json
import queue
import ssl
import threading
import time
import urllib.error
import urllib.parse
import urllib.request
from dataclasses import dataclass
from datetime import datetime, timezone
from email.utils import parsedate_to_datetime
from typing import IO, Any, Final

from ucon.core.errors import ConfigError

MAX_BYTES: Final = 16 * 2**20
_PIECE: Final = 1 << 16
_LOOPBACK: Final = frozenset({"127.0.0.1", "::1", "localhost"})


@dataclass(frozen=True, slots=True)
class Outcome:
    """The result of a request; without a body, ``problem`` says why."""

    status: int | None
    """HTTP status; None where there was no response."""
    body: bytes = b""
    problem: str = ""
    retry_after_s: float | None = None
    """Seconds the server asks to wait (Retry-After)."""
    hopeless: bool = False
    """Whether a retry is pointless although there was no response."""


class _NoRedirect(urllib.request.HTTPRedirectHandler):
    """Does not follow redirects: that would send the key to another host."""

    def redirect_request(self, *_: Any, **__: Any) -> None:
        return None


def checked_url(base_url: str) -> str:
    """A server's address, without the slash at its end.

    Raises:
        ConfigError: not an http address, or one with a name, a key or a query, which would appear in messages.
    """
    try:
        parts = urllib.parse.urlsplit(base_url)
        good = parts.scheme in ("http", "https") and bool(parts.hostname) and parts.port != 0
    except ValueError:
        good = False
    if not good or not base_url.isprintable() or " " in base_url:
        raise ConfigError("chat server: base_url is not an http address; expected one like http://127.0.0.1:8000/v1")
    if "@" in parts.netloc or parts.query or parts.fragment:
        raise ConfigError(
            f"chat server {parts.hostname}: base_url with a name, key or query; give the address alone, and the key in "
            "the environment variable that api_key_env names"
        )
    return base_url.rstrip("/")


def post_json(url: str, payload: dict[str, Any], headers: dict[str, str], timeout_s: float) -> Outcome:
    """POST a JSON payload and read the whole response within a time limit.

    A socket's timeout limits each read but not the name look-up. So the exchange has its own thread, which is abandoned
    when the time is up.

    Args:
        url: the address.
        payload: the body.
        headers: of the request.
        timeout_s: seconds of wall time.
    """
    data = json.dumps(payload).encode()
    request = urllib.request.Request(url, data, {"Content-Type": "application/json", **headers}, method="POST")
    return _exchanged(request, timeout_s)


def get_status(url: str, headers: dict[str, str], timeout_s: float) -> tuple[int | None, str]:
    """HTTP status of a GET.

    Args:
        url: the address.
        headers: of the request.
        timeout_s: seconds of wall time.

    Returns:
        The status (None without a response), and what was wrong.
    """
    outcome = _exchanged(urllib.request.Request(url, headers=headers), timeout_s)
    return outcome.status, outcome.problem


def _exchanged(request: urllib.request.Request, timeout_s: float) -> Outcome:
    box: queue.SimpleQueue[Outcome] = queue.SimpleQueue()
    threading.Thread(target=lambda: box.put(_exchange(request, timeout_s)), daemon=True).start()
    try:
        return box.get(timeout=timeout_s)
    except queue.Empty:
        return Outcome(None, problem=_why(TimeoutError(), timeout_s))


def _exchange(request: urllib.request.Request, timeout_s: float) -> Outcome:
    deadline = time.monotonic() + timeout_s
    try:
        with _opener(request.full_url).open(request, timeout=timeout_s) as answer:
            return Outcome(answer.status, _read(answer, deadline))
    except urllib.error.HTTPError as error:
        return _refused(error, deadline)
    except urllib.error.URLError as error:
        bad_certificate = isinstance(error.reason, ssl.SSLCertVerificationError)
        return Outcome(None, problem=_why(error.reason, timeout_s), hopeless=bad_certificate)
    except (OSError, http.client.HTTPException, ValueError) as error:  # ValueError: an invalid header
        return Outcome(None, problem=_why(error, timeout_s))


def _refused(error: urllib.error.HTTPError, deadline: float) -> Outcome:
    with error:
        try:
            body = _read(error, deadline)
        except (OSError, http.client.HTTPException):
            body = b""  # the status alone says enough
        wait = _retry_after(error.headers.get("Retry-After"))
        return Outcome(error.code, body, f"HTTP {error.code}", wait)


def _opener(url: str) -> urllib.request.OpenerDirector:
    handlers: list[urllib.request.BaseHandler] = [_NoRedirect()]
    if urllib.parse.urlsplit(url).hostname in _LOOPBACK:
        handlers.append(urllib.request.ProxyHandler({}))  # a server on this machine is behind no proxy
    return urllib.request.build_opener(*handlers)


def _read(answer: IO[bytes] | http.client.HTTPResponse, deadline: float) -> bytes:
    """The body; a server that sends a little at a time is cut off at the deadline like one that sends nothing."""
    out = bytearray()
    while piece := answer.read1(_PIECE):  # type: ignore[union-attr]
        out += piece
        if len(out) > MAX_BYTES:
            raise http.client.HTTPException(f"an answer of more than {MAX_BYTES >> 20} MiB")
        if time.monotonic() > deadline:
            raise TimeoutError
    length = getattr(answer, "length", None)
    if length:
        raise http.client.IncompleteRead(bytes(out), length)
    return bytes(out)


def _why(reason: Any, timeout_s: float) -> str:
    if isinstance(reason, TimeoutError):
        return f"no whole answer within {timeout_s:g} s"
    if isinstance(reason, http.client.IncompleteRead):
        return "the connection broke in the middle of the answer"
    if isinstance(reason, http.client.BadStatusLine | ConnectionResetError | BrokenPipeError):
        return "the connection was closed without an answer"
    text = getattr(reason, "strerror", None) or str(reason) or type(reason).__name__
    return " ".join(str(text).split())


def _retry_after(value: str | None) -> float | None:
    """Seconds of a Retry-After header: a number, or a date; None where there is none or it cannot be read."""
    if value is None:
        return None
    try:
        seconds = float(value)
    except ValueError:
        try:
            when = parsedate_to_datetime(value)
        except (TypeError, ValueError):
            return None
        when = when if when.tzinfo else when.replace(tzinfo=timezone.utc)
        seconds = (when - datetime.now(timezone.utc)).total_seconds()
    return max(seconds, 0.0) if seconds == seconds else None  # NaN is no number of seconds
