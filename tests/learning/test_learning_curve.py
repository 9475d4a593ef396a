"""The plot of a training run."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from ucon.learning.run.learning_curve import draw_curve, learning_curve
from ucon.learning.run.run_folder import CURVE, METRICS

pytest.importorskip("matplotlib")


def written(folder: Path) -> Path:
    lines = [{"step": k, "loss": 1.0 / k, "rate": 1e-3} for k in range(1, 50)]
    lines += [{"step": k, "val/foreseen": k / 60, "val/gain": 0.01, "val/score": k / 60} for k in (0, 20, 40)]
    (folder / METRICS).write_text("".join(json.dumps(line) + "\n" for line in lines))
    return folder


def test_losses_and_figures_of_validations_are_drawn(tmp_path: Path) -> None:
    draw_curve(written(tmp_path))
    image = cv2.imread(str(tmp_path / CURVE))
    third = image.shape[1] // 3
    for k, name in enumerate(("loss", "foreseen", "gain")):
        assert np.ptp(image[:, k * third : (k + 1) * third]) > 100, name
    first = (tmp_path / CURVE).read_bytes()
    draw_curve(tmp_path)
    assert (tmp_path / CURVE).read_bytes() == first


def test_it_is_drawn_after_validations_only(tmp_path: Path) -> None:
    with learning_curve(written(tmp_path)) as draw:
        draw(1, {"loss": 1.0})
        assert not (tmp_path / CURVE).exists()
        draw(1, {"val/score": 1.0})
        assert (tmp_path / CURVE).is_file()
