"""Makes reports of runs, one at a time, each in a separate process."""

from __future__ import annotations

import subprocess
import sys
import threading
from typing import Final

from ucon.core.errors import ConfigError
from ucon.pages.serve.run_list import FoundRun

#: Longest time for a report, seconds: a thousand episodes with beliefs take some minutes.
_PATIENCE_S: Final = 3600.0


class ReportMaker:
    """Runs ``python -m ucon report`` for runs of the page."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._process: subprocess.Popen[str] | None = None
        self._making, self._closed = "", False
        self._faults: dict[str, str] = {}

    def state(self, run: FoundRun) -> dict[str, bool | str]:
        """``making``: whether its report is being made; ``fault``: why the last one could not be made, or ""."""
        return {"making": self._making == run.id, "fault": self._faults.get(run.id, "")}

    def make(self, run: FoundRun) -> None:
        """Start making the report of a run, which is written into its folder.

        Args:
            run: the run.

        Raises:
            ConfigError: an evaluation that is not finished, figures alone, or another report is being made.
        """
        if run.kind == "eval" and not run.finished:
            raise ConfigError("the run is not finished; its report can be made when it is")
        if not run.can_report:
            raise ConfigError("only the figures of this run are kept, and a report needs its episodes")
        with self._lock:
            if self._making:
                raise ConfigError("another report is being made; try again when it is done")
            self._making = run.id
            self._faults.pop(run.id, None)
        threading.Thread(target=self._work, args=(run,), daemon=True).start()

    def close(self) -> None:
        """Stop making the current report; no other is started."""
        with self._lock:
            self._closed = True
            if self._process is not None:
                self._process.terminate()

    def _work(self, run: FoundRun) -> None:
        try:
            if fault := self._fault(run):
                self._faults[run.id] = fault.replace(str(run.path), run.name)
        finally:
            with self._lock:
                self._process, self._making = None, ""

    def _fault(self, run: FoundRun) -> str:
        """Make a report; returns why it could not be made, or ""."""
        try:
            with self._lock:
                if self._closed:
                    return "the server has stopped"
                process = self._process = subprocess.Popen(
                    [sys.executable, "-m", "ucon", "report", str(run.path)],
                    stdout=subprocess.DEVNULL,
                    stderr=subprocess.PIPE,
                    text=True,
                    errors="replace",
                )
        except OSError as error:
            return str(error)
        try:
            _, said = process.communicate(timeout=_PATIENCE_S)
        except subprocess.TimeoutExpired as error:
            process.terminate()
            process.communicate()
            return str(error)
        if not process.returncode:
            return ""
        return (said.strip().splitlines() or ["the report command failed"])[-1].removeprefix("error: ")
