"""A real chat server on the loopback interface that misbehaves as a test tells it to."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any


class ChatServer(ThreadingHTTPServer):
    """Plays ``script``, one act per request; the last act is repeated. Keeps the requests."""

    daemon_threads = True
    request_queue_size = 64
    """Many clients connect at once. One that finds the queue full retries after a second, longer than it waits."""

    def __init__(self, script: list[Callable[[Handler], None]]) -> None:
        super().__init__(("127.0.0.1", 0), Handler)
        self.script = script
        self.models: Callable[[Handler], None] = fails(404)
        self.asked: list[dict[str, Any]] = []
        self.headers: list[dict[str, str]] = []
        self.times: list[float] = []
        self.lock = threading.Lock()

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.server_address[1]}/v1"

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Ignore clients that went away: they are part of the tests."""


class Handler(BaseHTTPRequestHandler):
    server: ChatServer

    def do_POST(self) -> None:
        body = self.rfile.read(int(self.headers["Content-Length"]))
        with self.server.lock:
            number = len(self.server.asked)
            self.server.asked.append(json.loads(body) | {"path": self.path})
            self.server.headers.append(dict(self.headers))
            self.server.times.append(time.monotonic())
        self.server.script[min(number, len(self.server.script) - 1)](self)

    def do_GET(self) -> None:
        """Answer the request for the list of models."""
        self.server.headers.append(dict(self.headers))
        self.server.models(self)

    def log_message(self, *_: Any) -> None:
        pass

    def send(self, status: int, body: bytes, **headers: str) -> None:
        self.send_response(status)
        for name, value in {"Content-Type": "application/json", **headers}.items():
            self.send_header(name.replace("_", "-"), value)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)


Act = Callable[[Handler], None]


def says(content: Any, finish: str = "stop") -> Act:
    """A completion with this content: text, or an object as JSON."""
    text = content if isinstance(content, str | None) else json.dumps(content)
    answer = {
        "choices": [{"message": {"role": "assistant", "content": text}, "finish_reason": finish}],
        "usage": {"prompt_tokens": 100, "completion_tokens": 20},
    }
    return sends(json.dumps(answer).encode())


def sends(body: bytes, status: int = 200, **headers: str) -> Act:
    return lambda handler: handler.send(status, body, **headers)


def fails(status: int, message: str = "no", **headers: str) -> Act:
    return sends(json.dumps({"error": {"message": message}}).encode(), status, **headers)


def hangs(seconds: float) -> Act:
    return lambda handler: time.sleep(seconds)


def closes(handler: Handler) -> None:
    """Closes the connection without an answer."""
    handler.close_connection = True


def breaks_off(handler: Handler) -> None:
    """Announces more bytes than it sends."""
    handler.send_response(200)
    handler.send_header("Content-Length", "1000")
    handler.end_headers()
    handler.wfile.write(b'{"choices": [')


def dribbles(handler: Handler) -> None:
    """Sends a byte now and then, so that no single read waits for long."""
    handler.send_response(200)
    handler.send_header("Content-Length", "1000")
    handler.end_headers()
    for _ in range(100):
        handler.wfile.write(b" ")
        handler.wfile.flush()
        time.sleep(0.05)


@contextmanager
def chat_server(*script: Act) -> Iterator[ChatServer]:
    server = ChatServer(list(script))
    thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.02}, daemon=True)
    thread.start()
    try:
        yield server
    finally:
        server.shutdown()
        server.server_close()
