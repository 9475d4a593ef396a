"""Picture of a training run: its losses and validation figures against its steps."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final

from ucon.learning.run.run_folder import CURVE, METRICS
from ucon.learning.run.trainer_state import SCORE
from ucon.learning.run.training_run import OnFigures

_VALIDATED: Final = "val/"
#: Beside the loss, figures of steps are not drawn; of validations all are.
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
