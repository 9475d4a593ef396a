"""One training run: a folder, a loop that can be stopped anywhere, and what is left when it ends.

config.yaml      what was asked for; `resume=` reads it
metrics.jsonl    a line a step and a validation: no times, so equal runs write equal bytes
checkpoints/     see :mod:`ucon.learning.checkpoints`
model/           what was learned, by the best checkpoint, with a manifest
MODEL_CARD.md, summary.json
seconds.json     while the run lasts: what its checkpoints took, over all interruptions
"""

from __future__ import annotations

import json
import signal
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, fields
from pathlib import Path
from types import FrameType
from typing import Any, Final

from ucon.core.errors import ConfigError, DataError, brief, unknown_name
from ucon.core.files import canonical_json, sha256_bytes, write_atomic, write_manifest
from ucon.core.strict_json import MAX_BYTES, parse_json, read_bounded
from ucon.learning.checkpoints import BEST, LATEST, CheckpointError, Checkpoints
from ucon.learning.learner import Figures, Learner, State

CONFIG: Final = "config.yaml"
METRICS: Final = "metrics.jsonl"
CARD: Final = "MODEL_CARD.md"
SUMMARY: Final = "summary.json"
SECONDS: Final = "seconds.json"
MODEL: Final = "model"
CHECKPOINTS: Final = "checkpoints"
#: Of an evaluation, see :mod:`ucon.evaluation.folder`.
RECORDS: Final = "episodes.jsonl"
#: Figure of :meth:`Learner.validate` that chooses the best checkpoint; larger is better.
SCORE: Final = "score"

OnFigures = Callable[[int, Mapping[str, float]], None]


@dataclass(frozen=True)
class Plan:
    """How long, and how often what.

    Raises:
        ConfigError: a number below 1.
    """

    steps: int
    validate_every: int = 50
    save_every: int = 50
    keep: int = 2

    def __post_init__(self) -> None:
        for name in ("steps", "validate_every", "save_every", "keep"):
            value = getattr(self, name)
            if type(value) is not int or value < 1:
                raise ConfigError(f"training.{name}={brief(value)}: expected a whole number from 1 up")

    @classmethod
    def of(cls, options: Any) -> Plan:
        """The plan that a configuration describes.

        Raises:
            ConfigError: no options at all, an unknown or a missing one, or a number below 1.
        """
        names = [field.name for field in fields(cls)]
        if not isinstance(options, Mapping):
            raise ConfigError(f"training={brief(options)}: expected the options {', '.join(names)}")
        if odd := next((name for name in options if name not in names), None):
            raise ConfigError(unknown_name("option", f"training.{odd}", [f"training.{name}" for name in names]))
        if "steps" not in options:
            raise ConfigError("training.steps has no value; give training.steps=...")
        return cls(**options)


class Interrupted(Exception):  # noqa: N818 (no error: the run was asked to stop and did)
    """Stopped by a signal after everything was saved."""

    def __init__(self, step: int, number: int) -> None:
        super().__init__(step, number)
        self.step, self.number = step, number


class TrainingRun:
    """Trains ``learner`` by ``plan`` in ``folder``. Use :meth:`start` or :meth:`resume`, then :meth:`run`."""

    def __init__(self, folder: Path, learner: Learner, plan: Plan, identity: Mapping[str, str]) -> None:
        """``identity``: hashes of the run beside the learner's own, such as that of the configuration."""
        self.folder, self.learner, self.plan = folder, learner, plan
        self.checkpoints = Checkpoints(folder / CHECKPOINTS, {**identity, **learner.identity}, plan.keep)
        self.step = 0
        self._saved = -1
        self.best: dict[str, float] = {}
        """Validation figures of the best checkpoint and its step; empty before the first validation."""
        self._seconds_before, self._started = 0.0, time.perf_counter()

    def start(self, config_yaml: str) -> None:
        """Begin in a folder that holds no run yet.

        Raises:
            ConfigError: there is a run, or what one left, or the folder cannot be written.
        """
        if (self.checkpoints.folder / LATEST).exists():
            raise ConfigError(
                f"out={self.folder}: holds a run already; go on with resume={self.folder} or choose another folder"
            )
        results = sorted(p.name for name in (SUMMARY, MODEL, f"{RECORDS}*") for p in self.folder.glob(name))
        if results:
            raise ConfigError(
                f"out={self.folder}: {results[0]} there is of another run and would be overwritten; "
                "choose another folder"
            )
        try:
            write_atomic(self.folder / CONFIG, config_yaml)
            write_atomic(self.folder / METRICS, "")
        except OSError as error:
            raise ConfigError(
                f"out={self.folder}: cannot be written ({error.strerror}); choose another folder"
            ) from None

    def resume(self, checkpoint: str = LATEST) -> None:
        """Go on from a checkpoint; what was logged after it is logged again."""
        self.step, state = self.checkpoints.load(checkpoint)
        self._saved = self.step
        self._take(state, checkpoint)
        if checkpoint != LATEST:
            self.checkpoints.rewind(checkpoint)
        if not self.checkpoints.has_best:
            self.best = {}  # the next validation finds one
        self._cut_metrics()
        self._seconds_before = self._kept_seconds()

    def _take(self, state: State, checkpoint: str) -> None:
        """Give learner and trainer a state.

        Raises:
            CheckpointError: it is whole, but not the state of such a run.
        """
        try:
            best = dict(state.values["trainer"]["best"])
            if odd := [value for value in best.values() if type(value) not in (int, float)]:
                raise TypeError(f"{brief(odd[0])} among the best figures")
            self.best = best
            self.learner.load_state_dict(State(state.tensors, state.values["learner"]))
        except (LookupError, TypeError, ValueError, AttributeError, RuntimeError) as error:
            raise CheckpointError(
                f"checkpoint {self.checkpoints.folder / checkpoint}: not the state of this learner "
                f"({type(error).__name__}: {brief(str(error))}); start the run anew"
            ) from None

    def run(self, on_figures: OnFigures = lambda step, figures: None) -> dict[str, Any]:
        """Train to the end and write what is left of it; returns the content of ``summary.json``.

        What training starts from is validated before the first step.

        Raises:
            Interrupted: SIGINT or SIGTERM came; the state after the last whole step is saved.
        """
        self._started = time.perf_counter()
        with _signals() as caught:
            self._begin(on_figures)
            while self.step < self.plan.steps and not caught:
                self._one_step(on_figures)
            if self.step < self.plan.steps:
                if self._saved != self.step:
                    self._save()
                raise Interrupted(self.step, caught[0])
            return self._finish()

    def _begin(self, on_figures: OnFigures) -> None:
        """Validate what a new run starts from."""
        if self._saved < 0:
            on_figures(self.step, self._validate())

    def _one_step(self, on_figures: OnFigures) -> None:
        figures = self.learner.step()
        self.step += 1
        self._log(figures)
        on_figures(self.step, figures)
        last = self.step == self.plan.steps
        if last or self.step % self.plan.validate_every == 0:
            on_figures(self.step, self._validate())
        elif self.step % self.plan.save_every == 0:
            self._save()

    def _validate(self) -> Figures:
        """Validate, log, save; the first of equally good states stays the best."""
        found = self.learner.validate()
        self._log({f"val/{name}": value for name, value in found.items()})
        better = not self.best or found[SCORE] > self.best[SCORE]
        if better:
            self.best = dict(sorted({"step": self.step, **found}.items()))  # as a checkpoint gives it back
        self._save()
        return {f"val/{name}": value for name, value in found.items()}

    def _save(self) -> None:
        state = self.learner.state_dict()
        values = {"learner": dict(state.values), "trainer": {"best": self.best}}
        self._saved = self.step
        best = int(self.best["step"]) if self.best else None
        self.checkpoints.save(self.step, State(state.tensors, values), best=best)
        write_atomic(self.folder / SECONDS, json.dumps({"seconds": self._seconds()}) + "\n")

    def _seconds(self) -> float:
        """What the run took so far, with what earlier calls took up to their last checkpoints."""
        return round(self._seconds_before + time.perf_counter() - self._started, 1)

    def _kept_seconds(self) -> float:
        """What earlier calls took; 0 where nothing says it, as in runs of earlier versions."""
        for name in (SECONDS, SUMMARY):
            try:
                seconds = float(parse_json(read_bounded(self.folder / name, MAX_BYTES))["seconds"])
            except (OSError, ValueError, LookupError, TypeError):
                continue
            if seconds >= 0:
                return seconds
        return 0.0

    def _log(self, figures: Mapping[str, float]) -> None:
        with (self.folder / METRICS).open("a", encoding="utf-8") as file:
            file.write(canonical_json({"step": self.step, **figures}) + "\n")

    def _cut_metrics(self) -> None:
        """Keep the lines up to the checkpoint; a last line that was cut off goes too."""
        path = self.folder / METRICS
        raw = path.read_bytes() if path.is_file() else b""
        kept = []
        for number, line in enumerate(raw[: raw.rfind(b"\n") + 1].splitlines(), 1):
            try:
                if int(parse_json(line)["step"]) <= self.step:
                    kept.append(line + b"\n")
            except (ValueError, LookupError, TypeError):
                raise DataError(f"{path}:{number}: not a line of metrics; restore it, or start the run anew") from None
        write_atomic(path, b"".join(kept))

    def _finish(self) -> dict[str, Any]:
        best, (_, state) = self.best, self.checkpoints.load(BEST)
        self._take(state, BEST)
        self.best = best
        product = self.learner.product()
        for name, content in product.items():
            write_atomic(self.folder / MODEL / name, content)
        write_manifest(self.folder / MODEL, product)
        summary = {
            "steps": self.step,
            "best": self.best,
            "seconds": self._seconds(),
            "hashes": self.checkpoints.identity,
            "files": {name: {"bytes": len(c), "sha256": sha256_bytes(c)} for name, c in product.items()},
        }
        write_atomic(self.folder / CARD, self._card(summary))
        write_atomic(self.folder / SUMMARY, json.dumps(summary, indent=1) + "\n")
        (self.folder / SECONDS).unlink(missing_ok=True)
        return summary

    def _card(self, summary: Mapping[str, Any]) -> str:
        card = self.learner.card()
        rows = "".join(f"| {name} | {value:g} |\n" for name, value in self.best.items() if name != SCORE)
        hashes = "".join(f"- {name}: `{value}`\n" for name, value in summary["hashes"].items())
        files = "".join(
            f"- `{MODEL}/{name}`, {file['bytes']:,} bytes, SHA-256 `{file['sha256']}`\n"
            for name, file in summary["files"].items()
        )
        return (
            f"# {card.title}\n\n{card.text}\n\n## Validation, best checkpoint\n\n| figure | value |\n|---|---|\n{rows}"
            f"\n## Files\n\n{files}\n## Made from\n\n{hashes}\n## Licence\n\n{card.licence}\n"
        )


@contextmanager
def _signals() -> Iterator[list[int]]:
    """SIGINT and SIGTERM end the loop after the step in hand; a second SIGINT ends it at once."""
    caught: list[int] = []

    def remember(number: int, frame: FrameType | None) -> None:
        if caught and number == signal.SIGINT:
            raise KeyboardInterrupt
        caught.append(number)

    try:
        before = {number: signal.signal(number, remember) for number in (signal.SIGINT, signal.SIGTERM)}
    except ValueError:  # not the main thread: whoever runs us deals with signals
        yield caught
        return
    try:
        yield caught
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
