"""Requests to a program over its stdin and stdout: length-prefixed messages, and a time limit for every answer."""

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

#: Longest answer in bytes; a longer one is stray output of the program.
MOST_BYTES = 1 << 24


class WorkerLink:
    """One running program.

    Any failure ends the program. The error says in one line what happened and what the program printed last.
    """

    def __init__(self, command: Sequence[str], what: str) -> None:
        """Start the program.

        Args:
            command: executable and arguments.
            what: names the program in error messages.

        Raises:
            DetectorError: it cannot be started.
        """
        self._what = what
        self._log: IO[bytes] = tempfile.TemporaryFile()  # noqa: SIM115 (closed with the program)
        # PYTHONHOME points to this Python's files; the other Python has its own.
        variables = {key: value for key, value in os.environ.items() if key != "PYTHONHOME"}
        try:
            self._process = subprocess.Popen(
                list(command), stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._log, env=variables
            )
        except OSError as error:
            self._log.close()
            raise DetectorError(f"{what}: {command[0]} cannot be started ({error.strerror})") from None

    def ask(self, parts: Sequence[bytes], timeout_s: float) -> dict[str, Any]:
        """Send messages and wait for one answer.

        Args:
            parts: messages, each sent with its length (4 bytes, big-endian) before it.
            timeout_s: seconds for sending and answering together.

        Returns:
            The answer, a JSON object.

        Raises:
            DetectorError: the program ended, did not answer in time, or answered an error or something else.
        """
        deadline = time.monotonic() + timeout_s
        with contextlib.suppress(OSError):  # the program has ended; reading its output tells why
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
        """End the program: close its stdin, wait two seconds, then kill it."""
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
        """Write with a deadline, in pieces: a program that reads nothing would block a larger write for ever."""
        assert self._process.stdin is not None
        pipe, left = self._process.stdin.fileno(), memoryview(data)
        while left:
            _, ready, _ = select.select([], [pipe], [], max(0.0, deadline - time.monotonic()))
            if not ready:
                raise self._late(timeout_s)
            left = left[os.write(pipe, left[: select.PIPE_BUF]) :]

    def _read(self, size: int, deadline: float, timeout_s: float) -> bytes:
        """Read ``size`` bytes before the deadline."""
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
        """Error for an answer that did not come in time."""
        return self._failure(f"no answer in {timeout_s:g} s; raise the timeout, or use a faster device")

    def _failure(self, problem: str, *, log: bool = True) -> DetectorError:
        """Kill the program; the error names the problem and, with ``log``, the last line that the program printed."""
        self._process.kill()
        self._process.wait()
        lines: list[str] = []
        if log:
            self._log.seek(0)
            lines = self._log.read().decode(errors="replace").strip().splitlines()
        self.close()
        return DetectorError(f"{self._what}: {problem}" + (f"; it printed last: {brief(lines[-1])}" if lines else ""))
