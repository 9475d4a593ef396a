"""A progress bar with the success rate so far, on standard error, so that standard output stays clean."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from types import TracebackType

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TaskID,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

from ucon.evaluation.playing.play import PlayedEpisode


class EvaluationProgress:
    """``with EvaluationProgress(...) as progress: progress.add(played)``."""

    def __init__(self, label: str, total: int, *, visible: bool = True, done: Iterable[PlayedEpisode] = ()) -> None:
        self._progress = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            TextColumn("SR {task.fields[success]} SPL {task.fields[spl]}"),
            TimeElapsedColumn(),
            TimeRemainingColumn(),
            console=Console(stderr=True),
            disable=not visible,
        )
        self._task = self._progress.add_task(label, total=total, success="-", spl="-")
        self._played = self._successes = 0
        self._spl = 0.0
        for played in done:
            self.add(played)

    def add(self, played: PlayedEpisode) -> None:
        """Count one finished episode."""
        self._played += 1
        self._successes += played.record.success
        self._spl += played.record.spl
        success, spl = 100 * self._successes / self._played, self._spl / self._played
        self._progress.update(self._task, advance=1, success=f"{success:.0f} %", spl=f"{spl:.2f}")

    def __enter__(self) -> EvaluationProgress:
        self._progress.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._progress.stop()


@contextmanager
def embedding_progress(*, visible: bool = True) -> Iterator[Callable[[int, int], None]]:
    """A bar for habits that are read by the encoder for the first time; never drawn where all are known."""
    with Progress(console=Console(stderr=True), transient=True, disable=not visible) as bar:
        task: TaskID | None = None

        def on_text(done: int, total: int) -> None:
            nonlocal task
            if task is None:
                task = bar.add_task("embedding habits, once", total=total)
            bar.update(task, completed=done, total=total)

        yield on_text
