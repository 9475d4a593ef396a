"""Progress of an evaluation with SR and SPL so far, on stderr, so that stdout stays clean."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager
from types import TracebackType

from ucon.core.progress import Progress
from ucon.evaluation.playing.play import PlayedEpisode


class EvaluationProgress:
    """Progress line of an evaluation: ``with EvaluationProgress(...) as progress: progress.add(played)``."""

    def __init__(self, label: str, total: int, *, visible: bool = True, done: Iterable[PlayedEpisode] = ()) -> None:
        """Prepare the line.

        Args:
            label: text at its beginning.
            total: number of episodes.
            visible: False shows nothing.
            done: episodes that were played before.
        """
        self._played = self._successes = 0
        self._spl = 0.0
        for played in done:
            self._count(played)
        self._progress = Progress(
            label, total, unit="episodes", done=self._played, note=self._figures(), visible=visible
        )

    def add(self, played: PlayedEpisode) -> None:
        """Count a finished episode and update the line."""
        self._count(played)
        self._progress.update(self._played, self._figures())

    def _count(self, played: PlayedEpisode) -> None:
        self._played += 1
        self._successes += played.record.success
        self._spl += played.record.spl

    def _figures(self) -> str:
        n = self._played
        return f"SR {100 * self._successes / n:.0f} % SPL {self._spl / n:.2f}" if n else ""

    def __enter__(self) -> EvaluationProgress:
        self._progress.__enter__()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._progress.__exit__(kind, error, trace)


@contextmanager
def embedding_progress(*, visible: bool = True) -> Iterator[Callable[[int, int], None]]:
    """Context manager with a progress line for encoding habits; it is shown only where some are not cached.

    Yields:
        A function of the number of texts done and the number of all texts.
    """
    with ExitStack() as stack:
        shown: list[Progress] = []

        def on_text(done: int, total: int) -> None:
            if not shown:
                progress = Progress("embedding habits, once", total, unit="texts", visible=visible)
                shown.append(stack.enter_context(progress))
            shown[0].update(done)

        yield on_text
