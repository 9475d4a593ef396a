"""Logs every attempt of this process to reach another machine.

Python imports a module of this name from its path at start-up, so a command whose ``PYTHONPATH`` contains this folder
is watched, with every Python process that it starts. Attempts are appended to the file named by ``UCON_NETWORK_LOG``,
one per line: event, address, process and command. Loopback, Unix sockets and addresses without a host do not count.
"""

from __future__ import annotations

import ipaddress
import os
import sys
from typing import Any

_LOG = os.environ.get("UCON_NETWORK_LOG", "")
#: Position of the address among the arguments of an event.
_ADDRESS = {
    "socket.connect": 1,
    "socket.sendto": 1,
    "socket.sendmsg": 1,
    "socket.getaddrinfo": 0,
    "socket.gethostbyname": 0,
    "socket.gethostbyaddr": 0,
}


def is_elsewhere(address: Any) -> bool:
    """Whether a socket address or host name belongs to another machine."""
    if isinstance(address, tuple) and address:
        address = address[0]
    host = address.decode(errors="replace") if isinstance(address, bytes) else address
    if not isinstance(host, str) or host in ("", "localhost") or "/" in host or host.startswith("\0"):
        return False
    try:
        return not (ipaddress.ip_address(host).is_loopback or ipaddress.ip_address(host).is_unspecified)
    except ValueError:
        return True


def _watch(event: str, arguments: tuple[Any, ...]) -> None:
    place = _ADDRESS.get(event)
    if place is not None and is_elsewhere(arguments[place]):
        line = f"{event} {arguments[place]!r} {os.getpid()} {sys.argv[:3]}\n"
        kept = os.open(_LOG, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o644)
        os.write(kept, line.encode(errors="replace"))
        os.close(kept)


if _LOG:
    sys.addaudithook(_watch)
