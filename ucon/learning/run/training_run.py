"""One training run: a folder, a loop that can be stopped after any step, and the files that it leaves.

config.yaml      the configuration; `resume=` reads it
metrics.jsonl    one line per step and per validation, without times: equal runs write equal bytes
learning_curve.png   drawn by ``train.py`` where matplotlib is installed
checkpoints/     see :mod:`ucon.learning.run.checkpoints`
model/           files of the best checkpoint's weights, with a manifest
MODEL_CARD.md, summary.json
seconds.json     time taken over all calls: the only file that differs between equal runs
"""

from __future__ import annotations

import copy
import json
import math
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Final

from ucon.core.errors import ConfigError, DataError
from ucon.core.files import canonical_json, sha256_bytes, write_atomic, write_manifest
from ucon.learning.run.checkpoints import LATEST, Checkpoints, step_name
from ucon.learning.run.protocol import Figures, Learner, State
from ucon.learning.run.run_folder import (
    CARD,
    CHECKPOINTS,
    CONFIG,
    METRICS,
    MODEL,
    RECORDS,
    SECONDS,
    SUMMARY,
    check_run_folder,
    cut_metrics,
    read_seconds,
)
from ucon.learning.run.run_plan import Plan
from ucon.learning.run.stopping import Stopping, stopping
from ucon.learning.run.trainer_state import SCORE, TrainerState

#: A checkpoint may be this many times as large as the initial state, which has no optimiser moments yet.
_MORE_TENSORS: Final = 16
#: After a step of more seconds, the state is held in memory before the next step, which may have to be abandoned.
_SLOW_S: Final = 1.0

OnFigures = Callable[[int, Mapping[str, float]], None]


class Interrupted(Exception):  # noqa: N818 (no error: the run was asked to stop and did)
    """A signal stopped the run after its state was saved.

    Attributes:
        step: steps done and saved.
        number: of the signal.
        abandoned: whether a step or validation was abandoned in the middle, to be done again.
    """

    def __init__(self, step: int, number: int, *, abandoned: bool = False) -> None:
        super().__init__(step, number)
        self.step, self.number, self.abandoned = step, number, abandoned


class TrainingRun:
    """Trains a learner by a plan in a folder: call :meth:`start` or :meth:`resume`, then :meth:`run`.

    Args:
        folder: of the run.
        learner: what is trained.
        plan: length and intervals.
        identity: hashes of the run besides the learner's own, such as that of the configuration.
    """

    def __init__(self, folder: Path, learner: Learner, plan: Plan, identity: Mapping[str, str]) -> None:

        self.folder, self.learner, self.plan = folder, learner, plan
        self.checkpoints = Checkpoints(folder / CHECKPOINTS, {**identity, **learner.identity}, plan.keep)
        self.step = 0
        self.rescheduled = False
        """True where the run was extended and the learner's schedules depend on its length."""
        self._saved = -1
        self._pending = True
        """Whether the present state has yet to be validated: at the start, and where a validation was abandoned."""
        self._held: tuple[int, State, bool] | None = None
        """A copy of a state that is not saved: steps done, the state, and whether it has yet to be validated."""
        self._step_s = 0.0
        self.best: dict[str, float] = {}
        """Step and validation figures of the best checkpoint; empty before the first validation."""
        self._seconds_before, self._started = 0.0, time.perf_counter()

    def start(self, config_yaml: str) -> None:
        """Begin in a folder that holds no run yet; writes ``config.yaml``.

        Args:
            config_yaml: text of the configuration.

        Raises:
            ConfigError: there is a run or its results already, or the folder cannot be written.
            DataError: the folder holds a link, or a file where a folder belongs.
        """
        if (self.checkpoints.folder / LATEST).exists():
            raise ConfigError(
                f"out={self.folder}: holds a run already; continue with resume={self.folder} or choose another folder"
            )
        results = sorted(p.name for name in (SUMMARY, MODEL, f"{RECORDS}*") for p in self.folder.glob(name))
        if results:
            raise ConfigError(
                f"out={self.folder}: {results[0]} belongs to another run and would be overwritten; "
                "choose another folder"
            )
        check_run_folder(self.folder)
        try:
            write_atomic(self.folder / CONFIG, config_yaml)
            write_atomic(self.folder / METRICS, "")
        except OSError as error:
            raise ConfigError(
                f"out={self.folder}: cannot be written ({error.strerror}); choose another folder"
            ) from None

    def resume(self, checkpoint: str = LATEST, steps: int | None = None) -> None:
        """Continue from a checkpoint; later lines of ``metrics.jsonl`` are dropped and written again.

        Args:
            checkpoint: its name, or ``latest``.
            steps: new length of the run, longer than planned; :attr:`plan` then has the extension, and the caller has
                to write it to ``config.yaml`` before the run continues. None: as planned.

        Raises:
            DataError: something in the folder is damaged, a link, or of another run.
            ConfigError: ``steps`` is not more than is done or planned.
        """
        check_run_folder(self.folder)
        step, state = self.checkpoints.load(checkpoint, self._most_bytes())
        trainer = self._trainer(state, step)
        plan = self.plan if steps is None else self.plan.extend(step, steps)
        self._load(state)
        self.step, self.plan, self._saved, self._pending = step, plan, step, trainer.pending
        self._keep_to_schedule()
        if checkpoint != LATEST:
            self.checkpoints.rewind(checkpoint)
        # If the best checkpoint is gone, the next validation sets a new one.
        self.best = dict(trainer.best) if self.checkpoints.point_to_best(trainer.best_step) else {}
        cut_metrics(self.folder, step)
        self._seconds_before = read_seconds(self.folder)

    def _trainer(self, state: State, step: int) -> TrainerState:
        """The trainer's state in a checkpoint.

        Raises:
            CheckpointError: it is damaged, or has other extensions than ``config.yaml``.
        """
        try:
            found = TrainerState.of(state.values.get("trainer"), step)
        except DataError as error:
            raise self.checkpoints.unusable(step, str(error)) from None
        if found.extended != self.plan.followed(step):
            raise self.checkpoints.unusable(step, f"{CONFIG} lists other extensions of the run")
        return found

    def _most_bytes(self) -> int:
        """Upper bound of a checkpoint's tensors in bytes: a multiple of the initial state."""
        return _MORE_TENSORS * sum(tensor.nbytes for tensor in self.learner.state_dict().tensors.values()) + (1 << 26)

    def _load(self, state: State) -> None:
        learned = state.values.get("learner")
        self.learner.load_state_dict(State(state.tensors, learned if isinstance(learned, dict) else {}))

    def _keep_to_schedule(self) -> None:
        """Tell the learner the length that its schedules have at the present step."""
        if self.plan.extended:
            self.rescheduled = self.learner.lengthen(self.plan.length_at(self.step))

    def run(
        self,
        on_figures: OnFigures = lambda step, figures: None,
        on_abandoned: Callable[[Interrupted], None] = lambda stop: None,
    ) -> dict[str, Any]:
        """Train to the end and write the results. The initial state is validated before the first step.

        Args:
            on_figures: called with step and figures after each step and validation.
            on_abandoned: called where a step or validation is abandoned, once the state before it is saved; it may end
                the process, since leaving libraries in the middle may take long.

        Returns:
            Content of ``summary.json``.

        Raises:
            Interrupted: SIGINT or SIGTERM; the state after the last whole step is saved. A step or validation that
                does not end within :data:`~ucon.learning.run.stopping.GRACE_S` seconds is abandoned.
            DivergedError: a loss, gradient or validation figure that is not finite.
        """
        self._started = time.perf_counter()

        def abandoned(number: int) -> None:
            self._save_held()
            on_abandoned(Interrupted(self._saved, number, abandoned=True))

        with stopping(abandoned) as stop:
            try:
                self._begin(stop, on_figures)
                while self.step < self.plan.length and not stop.caught:
                    self._one_step(stop, on_figures)
            except BaseException as error:
                if not stop.abandoned or isinstance(error, KeyboardInterrupt):
                    raise
                stop.settle()
                raise Interrupted(self._saved, stop.caught[0], abandoned=True) from None
            if self.step < self.plan.length:
                if self._saved != self.step:
                    self._save()
                raise Interrupted(self.step, stop.caught[0])
            return self._finish()

    def _begin(self, stop: Stopping, on_figures: OnFigures) -> None:
        """Validate the state where that has yet to be done, such as the initial state of a new run."""
        if self._pending:
            on_figures(self.step, self._validate(stop))

    def _one_step(self, stop: Stopping, on_figures: OnFigures) -> None:
        self._keep_to_schedule()
        if self._step_s > _SLOW_S and self._saved != self.step:
            self._hold(pending=False)
        begun = time.monotonic()
        with stop.abandonable():
            figures = self.learner.step()
        self._step_s, self._held = time.monotonic() - begun, None
        self.step += 1
        self._log(figures)
        on_figures(self.step, figures)
        if self.plan.validates(self.step):
            on_figures(self.step, self._validate(stop))
        elif self.plan.saves(self.step):
            self._save()

    def _hold(self, *, pending: bool) -> None:
        """Keep a copy of the present state, since the learner cannot be used after it was abandoned."""
        state = self.learner.state_dict()
        tensors = {name: tensor.detach().to("cpu", copy=True) for name, tensor in state.tensors.items()}
        self._held = (self.step, State(tensors, copy.deepcopy(dict(state.values))), pending)

    def _save_held(self) -> None:
        """Save the held copy; if there is none, the run continues from the last checkpoint."""
        if self._held is not None:
            self._write(*self._held)

    def _validate(self, stop: Stopping) -> Figures:
        """Validate, log and save; among equal scores the first stays the best."""
        self._hold(pending=True)
        with stop.abandonable():
            found = self.learner.validate()
        self._pending, self._held = False, None
        if odd := next((name for name, value in found.items() if not math.isfinite(value)), None):
            from ucon.core.errors import DivergedError

            raise DivergedError(f"step {self.step}: {odd} of the validation is not finite; use a smaller learner.lr")
        self._log({f"val/{name}": value for name, value in found.items()})
        better = not self.best or found[SCORE] > self.best[SCORE]
        if better:
            self.best = dict(sorted({"step": self.step, **found}.items()))  # the order in which JSON is read back
        self._save()
        return {f"val/{name}": value for name, value in found.items()}

    def _save(self) -> None:
        self._write(self.step, self.learner.state_dict(), pending=False)

    def _write(self, step: int, state: State, pending: bool) -> None:
        """Write a checkpoint of the state after ``step`` steps."""
        trainer = TrainerState(self.best, self.plan.followed(step), pending)
        values = {"learner": dict(state.values), "trainer": trainer.to_json()}
        self._saved = step
        self.checkpoints.save(step, State(state.tensors, values), best=trainer.best_step, planned=self.plan.saves)
        self._write_seconds()

    @property
    def seconds(self) -> float:
        """Seconds that the run took so far, with earlier calls up to their last checkpoints."""
        return round(self._seconds_before + time.perf_counter() - self._started, 1)

    def _write_seconds(self) -> None:
        write_atomic(self.folder / SECONDS, json.dumps({"seconds": self.seconds}) + "\n")

    def _log(self, figures: Mapping[str, float]) -> None:
        with (self.folder / METRICS).open("a", encoding="utf-8") as file:
            file.write(canonical_json({"step": self.step, **figures}) + "\n")

    def _finish(self) -> dict[str, Any]:
        """Load the best checkpoint and write model, card and summary."""
        if not self.best:
            raise self.checkpoints.unusable(self.step, "the run's best checkpoint is missing")
        _, state = self.checkpoints.load(step_name(int(self.best["step"])))
        self._load(state)
        product = self.learner.product()
        for name, content in product.items():
            write_atomic(self.folder / MODEL / name, content)
        write_manifest(self.folder / MODEL, product)
        extended = [one.to_json() for one in self.plan.extended]
        summary = {
            "steps": self.step,
            **({"extended": extended} if extended else {}),
            "best": self.best,
            "hashes": self.checkpoints.identity,
            "files": {name: {"bytes": len(c), "sha256": sha256_bytes(c)} for name, c in product.items()},
        }
        write_atomic(self.folder / CARD, self._card(summary))
        write_atomic(self.folder / SUMMARY, json.dumps(summary, indent=1) + "\n")
        self._write_seconds()
        return summary

    def _card(self, summary: Mapping[str, Any]) -> str:
        card, extended = self.learner.card(), self.extended()
        rows = "".join(f"| {name} | {value:g} |\n" for name, value in self.best.items() if name != SCORE)
        hashes = "".join(f"- {name}: `{value}`\n" for name, value in summary["hashes"].items())
        files = "".join(
            f"- `{MODEL}/{name}`, {file['bytes']:,} bytes, SHA-256 `{file['sha256']}`\n"
            for name, file in summary["files"].items()
        )
        extended = f"{extended.capitalize()}.\n\n" if extended else ""
        return (
            f"# {card.title}\n\n{card.text}\n\n{extended}"
            f"## Validation, best checkpoint\n\n| figure | value |\n|---|---|\n{rows}"
            f"\n## Files\n\n{files}\n## Made from\n\n{hashes}\n## Licence\n\n{card.licence}\n"
        )

    def extended(self) -> str:
        """The run's extensions and what they mean for the schedule, in a line; empty where there are none."""
        if not self.plan.extended:
            return ""
        more = "".join(f", extended to {one.steps} after {one.at}" for one in self.plan.extended)
        if self.rescheduled:
            then = (
                "from then on its learning rate follows the longer schedule, unlike in a run planned with that length"
            )
        else:
            then = "no schedule depends on the number of steps"
        return f"planned for {self.plan.steps} steps{more}; {then}"
