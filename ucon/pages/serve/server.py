"""Serves the pages on this machine alone, until Ctrl-C."""

from __future__ import annotations

import errno
import socket
from collections.abc import Callable
from typing import Final

import uvicorn

from ucon.core.errors import ConfigError
from ucon.core.sole_writer import sole_writer
from ucon.pages.serve.app import make_app
from ucon.pages.serve.desk import Desk
from ucon.pages.serve.guard import new_token

HOST: Final = "127.0.0.1"
#: Port where none is asked for; if it is taken, a free one is used.
PORT: Final = 8765


def listening(port: int | None) -> socket.socket:
    """A socket that listens on the loopback.

    Args:
        port: 0 for any free one; None for :data:`PORT`, or any free one where it is taken.

    Raises:
        ConfigError: the port is taken, or may not be used.
    """
    # The protocol is named, since otherwise asyncio lets small packets wait, 40 ms for each answer.
    made = socket.socket(socket.AF_INET, socket.SOCK_STREAM, socket.IPPROTO_TCP)
    made.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        made.bind((HOST, PORT if port is None else port))
        made.listen(128)
    except OSError as error:
        made.close()
        if port is None:
            return listening(0)
        if error.errno == errno.EADDRINUSE:
            raise ConfigError(f"--port {port}: taken by another program; give another, or 0 for any free one") from None
        raise ConfigError(f"--port {port}: cannot be used ({error.strerror}); give another, or 0") from None
    return made


def serve(desk: Desk, port: int | None, ready: Callable[[str], None]) -> None:
    """Serve the pages until Ctrl-C.

    Args:
        desk: folders and habits.
        port: see :func:`listening`.
        ready: is called with the address once the server listens there.

    Raises:
        ConfigError: the port cannot be used, or another server writes to the same folder.
        KeyboardInterrupt: Ctrl-C; everything is closed by then.
    """
    with listening(port) as opened, sole_writer(desk.out):
        number, token = opened.getsockname()[1], new_token()
        config = uvicorn.Config(
            make_app(desk, token, number),
            access_log=False, log_level="warning", server_header=False, ws="none", limit_concurrency=200,
            timeout_graceful_shutdown=3,
        )  # fmt: skip
        ready(f"http://{HOST}:{number}/{token}/")
        uvicorn.Server(config).run(sockets=[opened])
