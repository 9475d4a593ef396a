"""Picture of a training run: its losses and validation figures against its steps."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final

from ucon.core.errors import DataError
from ucon.learning.run.run_folder import CURVE, METRICS, check_run_folder, read_metrics, read_seconds
from ucon.learning.run.trainer_state import SCORE
from ucon.learning.run.training_run import OnFigures

_VALIDATED: Final = "val/"
#: The only figure of steps that is drawn; of validations, all are.
_DRAWN: Final = "loss"
#: Weight of a step in the smoothed loss.
_SMOOTH: Final = 0.05


@contextmanager
def learning_curve(folder: Path) -> Iterator[OnFigures]:
    """Context manager that draws ``learning_curve.png`` after each validation, where matplotlib is installed.

    Args:
        folder: of the run.

    Yields:
        A function of step and figures, called after the figures were written to ``metrics.jsonl``.
    """
    installed = find_spec("matplotlib") is not None

    def draw(step: int, figures: Mapping[str, float]) -> None:
        if installed and any(name.startswith(_VALIDATED) for name in figures):
            draw_curve(folder)

    yield draw


def draw_curve(folder: Path) -> None:
    """Draw the figures in ``metrics.jsonl``.

    Args:
        folder: of the run.
    """
    from ucon.evaluation.figures.plotting import COLORS, LIGHT, STYLE, new_figure, save_png

    lines = [json.loads(line) for line in (folder / METRICS).read_text(encoding="utf-8").splitlines()]
    validated = {name for line in lines for name in line if name.startswith(_VALIDATED)} - {_VALIDATED + SCORE}
    names = [_DRAWN, *sorted(validated)]
    import matplotlib

    with matplotlib.rc_context(STYLE):
        figure = new_figure(4.2 * min(len(names), 3), 3.2 * -(-len(names) // 3), f"Training run {folder.name}")
        axes = figure.subplots(-(-len(names) // 3), min(len(names), 3), squeeze=False).ravel()
        for ax, name in zip(axes, names, strict=False):
            x, y = _series(lines, name)
            ax.set_title(name.removeprefix(_VALIDATED) + (" (validation)" if name != _DRAWN else ""))
            ax.grid(axis="y")
            ax.set_xlabel("step")
            if name == _DRAWN:
                ax.plot(x, y, color=LIGHT[0], linewidth=0.8)
                ax.plot(x, _smooth(y), color=COLORS[0], linewidth=1.8)
            else:
                ax.plot(x, y, color=COLORS[1], linewidth=1.8, marker="o", markersize=3)
        for ax in axes[len(names) :]:
            ax.set_axis_off()
        save_png(figure, folder / CURVE)


def _series(lines: Iterable[Mapping[str, Any]], name: str) -> tuple[list[int], list[float]]:
    """Steps and values of one figure."""
    found = [(line["step"], line[name]) for line in lines if name in line]
    return [step for step, _ in found], [value for _, value in found]


def _smooth(values: list[float]) -> list[float]:
    """Moving average with exponential weights."""
    out: list[float] = []
    for value in values:
        out.append(value if not out else out[-1] + _SMOOTH * (value - out[-1]))
    return out


def draw_curves(folders: Sequence[Path], path: Path) -> None:
    """Draw the validation figures of several runs in one picture, against learned frames and against minutes.

    Minutes are those of the whole run, spread evenly over its steps.

    Args:
        folders: of the runs.
        path: of the PNG.

    Raises:
        DataError: a run without validation figures, or without learned frames.
    """
    import matplotlib
    from matplotlib.ticker import EngFormatter, MaxNLocator

    from ucon.evaluation.figures.plotting import STYLE, new_figure, save_png

    curves = {folder: _Curves.of(folder) for folder in folders}
    names = [n for n in _COMPARED if any(n in c.values for c in curves.values())]
    with matplotlib.rc_context(STYLE):
        figure = new_figure(10, 2.9 * len(names), "Learning curves on validation episodes")
        axes = figure.subplots(len(names), 2, squeeze=False, sharey="row")
        for row, name in zip(axes, names, strict=True):
            for ax, unit in zip(row, ("frames", "minutes"), strict=True):
                for folder, curve in curves.items():
                    if name in curve.values:
                        at = [
                            curve.frames[step] if unit == "frames" else curve.minutes(step)
                            for step in curve.steps(name)
                        ]
                        ax.plot(
                            at,
                            list(curve.values[name].values()),
                            marker="o",
                            markersize=3.5,
                            label=folder.resolve().name,
                        )
                ax.set_xlabel({"frames": "learned frames", "minutes": "minutes"}[unit])
                ax.xaxis.set_major_locator(MaxNLocator(5))
                ax.xaxis.set_major_formatter(EngFormatter(sep=""))
                ax.set_ylim(bottom=0)
                ax.grid(axis="y")
            row[0].set_title(name.removeprefix(_VALIDATED).replace("_", " "))
        axes[0][1].legend(fontsize=9)
        save_png(figure, path)


#: Figures that are drawn in the picture of several runs.
_COMPARED: Final = ("val/success_rate", "val/spl", "val/cross_entropy")


@dataclass(frozen=True)
class _Curves:
    """Validation figures of one run: by name the values by step; learned frames by step; and its seconds."""

    values: Mapping[str, Mapping[int, float]]
    frames: Mapping[int, float]
    seconds: float

    @classmethod
    def of(cls, folder: Path) -> _Curves:
        check_run_folder(folder)
        rows = read_metrics(folder)
        learned = {0: 0.0} | {row["step"]: float(row["frames"]) for row in rows if "frames" in row}
        values = {name: {row["step"]: row[name] for row in rows if name in row} for name in _COMPARED}
        values = {name: {step: v for step, v in found.items() if step in learned} for name, found in values.items()}
        if not any(values.values()):
            raise DataError(f"{folder / METRICS}: no validation figures with learned frames; let it validate once")
        return cls({name: found for name, found in values.items() if found}, learned, read_seconds(folder))

    def steps(self, name: str) -> Sequence[int]:
        return list(self.values[name])

    def minutes(self, step: int) -> float:
        return self.seconds / 60 * step / max(1, *self.frames)
