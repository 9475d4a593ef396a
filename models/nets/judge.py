"""The judge of suspects: how probable it is that a thing on the map is the target, given the evidence.

A small network corrects the arithmetic posterior (:func:`ucon.search.suspects.arithmetic`). It is trained by
``python train.py learner=judge`` on hypotheses of searches in training homes.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any, Final

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from ucon.core.errors import ConfigError, DataError, brief
from ucon.core.files import MANIFEST, read_verified, sha256_file
from ucon.core.tensor_files import read_fitting
from ucon.core.untrusted.strict_json import JsonError, parse_json
from ucon.language.encoder import one_thread
from ucon.learning.judge.learner import CONFIG, WEIGHTS
from ucon.learning.run.run_folder import MODEL
from ucon.search.suspects import EVIDENCE, OF_HABITS

#: The shipped judge, as a run of ``python train.py learner=judge`` leaves it.
SHIPPED: Final = Path(__file__).parents[2] / "checkpoints" / "judge" / "model"
#: Decimals of probabilities, which are rounded so that the last bits of a processor's sums decide nothing.
DECIMALS: Final = 5
_WIDEST: Final = 512


class JudgeNet(nn.Module):
    """Logit of a suspect: the arithmetic posterior's, scaled, plus a correction by two hidden layers.

    Shapes: (m, F) float32 to (m,) float32.
    """

    mean: Tensor
    scale: Tensor
    used: Tensor

    def __init__(self, width: int = 64, *, habits: bool = True) -> None:
        """Make the network.

        Args:
            width: of the hidden layers.
            habits: False leaves out what comes from the habits (ablation).

        Raises:
            ConfigError: a width out of range.
        """
        super().__init__()
        if type(width) is not int or not 1 <= width <= _WIDEST:
            raise ConfigError(f"learner.judge.width={brief(width)}: expected a whole number from 1 to {_WIDEST}")
        self.options = {"width": width, "habits": bool(habits)}
        n = len(EVIDENCE)
        self.register_buffer("mean", torch.zeros(n))
        self.register_buffer("scale", torch.ones(n))
        used = torch.tensor([habits or name not in OF_HABITS for name in EVIDENCE], dtype=torch.float32)
        self.register_buffer("used", used)
        self.hidden = nn.Sequential(nn.Linear(n, width), nn.GELU(), nn.Linear(width, width), nn.GELU())
        self.correction = nn.Linear(width, 1)
        self.weights = nn.Parameter(torch.tensor([1.0, 1.0 if habits else 0.0]))

    def forward(self, evidence: Tensor) -> Tensor:
        """Logits (m,) of suspects by their evidence (m, F), columns as in :data:`ucon.search.suspects.EVIDENCE`."""
        arithmetic = evidence[:, [EVIDENCE.index("looks"), EVIDENCE.index("ratio")]] * self._kept
        x = ((evidence - self.mean) / self.scale * self.used).clamp(-6.0, 6.0)
        out: Tensor = (arithmetic * self.weights).sum(1) + self.correction(self.hidden(x))[:, 0]
        return out

    @property
    def _kept(self) -> Tensor:
        """(2,) 1 for the parts of the arithmetic posterior that are used."""
        return self.used[[EVIDENCE.index("looks"), EVIDENCE.index("ratio")]]


class TrainedJudge:
    """A trained judge; a :data:`ucon.search.suspects.Judge`."""

    def __init__(self, net: JudgeNet, weights: str = "") -> None:
        """Wrap a network.

        Args:
            net: trained; is set to evaluation mode.
            weights: hash of its files.
        """
        self.net, self._weights = net.eval(), weights

    @classmethod
    def load(cls, folder: str | Path | None = None) -> TrainedJudge:
        """The judge in a folder.

        Args:
            folder: a run, or its ``model``; None: the shipped judge.

        Raises:
            DataError: no judge there, a damaged one, or one of another version.
        """
        path = SHIPPED if folder is None else Path(folder).expanduser()
        return _loaded(path / MODEL if (path / MODEL).is_dir() else path)

    def fingerprint(self) -> str:
        """Hash of the judge's files; see :mod:`ucon.evaluation.playing.needed_weights`."""
        return self._weights

    def __call__(self, evidence: NDArray[np.float32]) -> NDArray[np.float64]:
        """Probabilities (m,) of suspects by their evidence (m, F)."""
        with torch.no_grad(), one_thread():
            p = torch.sigmoid(self.net(torch.from_numpy(evidence)).double()).numpy()
        return np.asarray(np.round(p, DECIMALS), np.float64)

    def __deepcopy__(self, memo: dict[int, Any]) -> TrainedJudge:
        return self


@cache
def _loaded(path: Path) -> TrainedJudge:
    """See :meth:`TrainedJudge.load`."""
    where = path / CONFIG
    try:
        options = parse_json(read_verified(where), max_bytes=1 << 16)
    except JsonError as error:
        raise DataError(f"{where}{error.at}: {error}; train it again (learner=judge)") from None
    if not isinstance(options, dict) or options.get("evidence") != list(EVIDENCE):
        raise DataError(f"{where}: trained on other evidence than is collected now; train it again (learner=judge)")
    width, habits = options.get("width"), options.get("habits")
    if type(width) is not int or not 1 <= width <= _WIDEST or type(habits) is not bool:
        raise DataError(f"{where}: width={brief(width)}, habits={brief(habits)}: no judge; train one (learner=judge)")
    net = JudgeNet(width, habits=habits)
    net.load_state_dict(read_fitting(path / WEIGHTS, net.state_dict())[0])
    return TrainedJudge(net, sha256_file(path / MANIFEST))
