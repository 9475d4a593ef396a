"""A program at the other end of two pipes: messages with a length before them, a time limit on every answer."""

from __future__ import annotations

import contextlib
import os
import select
import struct
import subprocess
import tempfile
import time
from collections.abc import Sequence
from typing import IO, Any

from ucon.core.errors import DetectorError, brief
from ucon.core.untrusted.strict_json import JsonError, parse_json

#: Larger answers are taken for something else that was printed.
MOST_BYTES = 1 << 24


class WorkerLink:
    """One running program. Any failure ends it, and says in one line what happened and what it printed last."""

    def __init__(self, command: Sequence[str], what: str) -> None:
        """Start ``command``; ``what`` names it in messages."""
        self._what = what
        self._log: IO[bytes] = tempfile.TemporaryFile()  # noqa: SIM115 (closed with the program)
        # Where this Python lives is not where the other one does.
        variables = {key: value for key, value in os.environ.items() if key != "PYTHONHOME"}
        try:
            self._process = subprocess.Popen(
                list(command), stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._log, env=variables
            )
        except OSError as error:
            self._log.close()
            raise DetectorError(f"{what}: {command[0]} cannot be started ({error.strerror})") from None

    def ask(self, parts: Sequence[bytes], timeout_s: float) -> dict[str, Any]:
        """Send messages and wait for one answer, a JSON object.

        Raises:
            DetectorError: the program ended, did not answer in time, or answered something else or an error.
        """
        deadline = time.monotonic() + timeout_s
        with contextlib.suppress(OSError):  # it has ended; reading tells why
            for part in parts:
                self._write(struct.pack(">I", len(part)) + part, deadline, timeout_s)
        (size,) = struct.unpack(">I", self._read(4, deadline, timeout_s))
        if size > MOST_BYTES:
            raise self._failure(f"answered {size} bytes, expected at most {MOST_BYTES}")
        body = self._read(size, deadline, timeout_s)
        try:
            answer = parse_json(body)
        except JsonError:
            answer = None
        if not isinstance(answer, dict):
            raise self._failure(f"answered {brief(repr(body[:60]))}, expected a JSON object")
        if "error" in answer:
            raise self._failure(
                str(answer["error"]).splitlines()[0][:300] if answer["error"] else "an error", log=False
            )
        return answer

    def close(self) -> None:
        """End the program: its stdin is closed, and after two seconds it is killed."""
        process = self._process
        if process.stdin is not None and not process.stdin.closed:
            with contextlib.suppress(OSError):
                process.stdin.close()
        try:
            process.wait(2.0)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        if process.stdout is not None:
            process.stdout.close()
        self._log.close()

    def _write(self, data: bytes, deadline: float, timeout_s: float) -> None:
        """A program that reads nothing, since it hangs or is stopped, would hold up whoever writes more than fits."""
        assert self._process.stdin is not None
        pipe, left = self._process.stdin.fileno(), memoryview(data)
        while left:
            _, ready, _ = select.select([], [pipe], [], max(0.0, deadline - time.monotonic()))
            if not ready:
                raise self._late(timeout_s)
            left = left[os.write(pipe, left[: select.PIPE_BUF]) :]

    def _read(self, size: int, deadline: float, timeout_s: float) -> bytes:
        assert self._process.stdout is not None
        pipe, body = self._process.stdout.fileno(), b""
        while len(body) < size:
            ready, _, _ = select.select([pipe], [], [], max(0.0, deadline - time.monotonic()))
            if not ready:
                raise self._late(timeout_s)
            piece = os.read(pipe, size - len(body))
            if not piece:
                raise self._failure(f"ended with exit code {self._process.wait()}")
            body += piece
        return body

    def _late(self, timeout_s: float) -> DetectorError:
        return self._failure(f"no answer in {timeout_s:g} s; raise the timeout, or use a faster device")

    def _failure(self, problem: str, *, log: bool = True) -> DetectorError:
        self._process.kill()
        self._process.wait()
        lines: list[str] = []
        if log:
            self._log.seek(0)
            lines = self._log.read().decode(errors="replace").strip().splitlines()
        self.close()
        return DetectorError(f"{self._what}: {problem}" + (f"; it printed last: {brief(lines[-1])}" if lines else ""))
