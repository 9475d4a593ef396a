"""Builds every constructor of ``configs/`` from a stored configuration with hostile arguments, and watches Python.

    python -m tests.commands.hostile FOLDER (fast | all) < parts.json

Standard input is a JSON object that maps a constructor's name to its place and what is stored there. The output is a
JSON object: the numbers of builds and, under ``seen``, everything done that no stored configuration may do (start
programs, open sockets, run code from ``FOLDER``). ``fast`` tries every eighth value, and for learners only one.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from ucon.configuration.arguments import arguments_of
from ucon.configuration.stored import checked
from ucon.configuration.wiring import Factory
from ucon.core.errors import UconError

#: Audit events that nothing stored may cause.
FORBIDDEN = (
    "subprocess.Popen", "os.system", "os.exec", "os.posix_spawn", "os.spawn", "os.fork", "os.forkpty", "pty.spawn",
    "socket.__new__", "socket.connect", "socket.bind", "socket.getaddrinfo", "socket.gethostbyname", "socket.sendto",
    "urllib.Request", "http.client.connect", "webbrowser.open", "os.putenv", "ctypes.dlopen",
)  # fmt: skip


class Watch:
    """An audit hook that records forbidden events while it is armed."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.armed, self.doing = str(folder), False, ""
        self.seen: list[list[str]] = []
        sys.addaudithook(self._hook)

    def _hook(self, event: str, arguments: tuple[Any, ...]) -> None:
        if not self.armed:
            return
        code = getattr(arguments[0], "co_filename", "") if event == "exec" and arguments else ""
        if event in FORBIDDEN or code.startswith(self.folder):
            self.seen.append([self.doing, event, repr(arguments)[:200]])


def hostile(folder: Path) -> list[Any]:
    """Commands, paths, addresses and code, in every form that an argument can take."""
    program = str(folder / "program")
    texts = [
        program, f"{program};", f"$({program})", f"`{program}`", f"|{program}", str(folder), str(folder / "model"),
        "http://127.0.0.1:9/v1", "file:///etc/passwd", "hf://nobody/nothing", "nobody/nothing", "ssh://127.0.0.1/x",
        f"__import__('os').system('{program}')", "${oc.env:HOME}", "os.system", "mine:evil", "HOME", "127.0.0.1:9",
    ]  # fmt: skip
    link = {"_target_": "ucon.perception.detectors.worker_link.WorkerLink", "command": [program], "what": "x"}
    calls = [link, {"_target_": "os.system", "command": program}, {"_target_": "mine.evil"}, {"_args_": [program]}]
    return [*texts, *calls, [program], [link], {"a": program}, {"a": link}, True]


def cases(target: str, node: dict[str, Any], values: list[Any]) -> Iterator[dict[str, Any]]:
    """The node with each hostile value in each argument, known or unknown; last, with all texts replaced."""
    for name in (*arguments_of(target), "unknown"):
        for value in values:
            yield node | {name: value}
    yield {name: values[0] if isinstance(value, str) and name[0] != "_" else value for name, value in node.items()}


def nested(place: list[str], node: Any) -> dict[str, Any]:
    """A configuration with nothing but ``node`` at a place."""
    for name in reversed(place):
        node = {name: node}
    return node  # type: ignore[no-any-return]


def built(place: list[str], node: dict[str, Any]) -> bool:
    """Build a node as the commands do, and call what they call; raises :class:`UconError` if it is refused."""
    config = checked(nested(place, node), "config.yaml", (place[0],), {}, "--set ")
    for name in place:
        config = config[name]
    try:
        made = Factory(config)()
        for ask in ("check", "fingerprint"):
            getattr(made, ask, lambda: None)()
    except UconError:
        return True  # it was let through, and failed on its own
    except Exception:  # hostile values may trigger bugs elsewhere; here only their side effects count
        return True
    return True


def main(folder: Path, wanted: Callable[[str], bool], every: int) -> dict[str, Any]:
    """Build all, first as they are, so that their imports are not attributed to the hostile values."""
    parts, watch = json.load(sys.stdin), Watch(folder)
    for place, node in parts.values():
        _quietly(place, node)
    os.chdir(folder)
    counts = {"tried": 0, "built": 0}
    for target, (place, node) in parts.items():
        values = [value for value in hostile(folder)[::every] if wanted(target) or isinstance(value, str)]
        for case in cases(target, node, values if wanted(target) else values[:1]):
            watch.doing, watch.armed = f"{target} {case}", True
            counts["tried"] += 1
            counts["built"] += _quietly(place, case)
            watch.armed = False
    return {**counts, "seen": watch.seen}


def _quietly(place: list[str], node: dict[str, Any]) -> bool:
    try:
        return built(place, node)
    except UconError:
        return False


if __name__ == "__main__":
    everything = sys.argv[2] == "all"
    found = main(Path(sys.argv[1]), lambda target: everything or not target.endswith("Learner"), 1 if everything else 8)
    sys.stdout.write(f"\n{json.dumps(found)}\n")
