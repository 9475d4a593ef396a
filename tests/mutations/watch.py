"""Side effects of a call: programs that it starts, sockets that it opens, memory that it takes."""

import contextlib
import sys
from collections.abc import Iterator
from pathlib import Path

_WATCHED = (
    "subprocess.",
    "os.system",
    "os.exec",
    "os.posix_spawn",
    "os.spawn",
    "os.fork",
    "pty.spawn",
    "socket.",
    "webbrowser.",
)
_HARMLESS = ("socket.gethostname",)
_seen: list[str] | None = None
_hooked = False


def _hook(event: str, arguments: tuple[object, ...]) -> None:
    if _seen is not None and event.startswith(_WATCHED) and event not in _HARMLESS:
        _seen.append(f"{event}{arguments!r}"[:200])


@contextlib.contextmanager
def watched() -> Iterator[list[str]]:
    """Yield the audit events of the code inside; hooks cannot be removed, so there is one per process."""
    global _seen, _hooked
    if not _hooked:
        sys.addaudithook(_hook)
        _hooked = True
    _seen = []
    try:
        yield _seen
    finally:
        _seen = None


@contextlib.contextmanager
def limited(more_bytes: int = 4 << 30) -> Iterator[None]:
    """Limit the memory that the code inside may take in addition; more is a MemoryError (on Linux)."""
    size = Path("/proc/self/statm")
    if not size.is_file():
        yield
        return
    import resource

    before = resource.getrlimit(resource.RLIMIT_AS)
    has = int(size.read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (has + more_bytes, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, before)
