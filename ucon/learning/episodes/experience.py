"""Experience of PPO: an episode that the policy played, with log-probabilities, advantages and value targets."""

from __future__ import annotations

import base64
import binascii
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import DataError
from ucon.learning.imitation.trajectories import Replay, Trajectory, trajectories_from_json
from ucon.task.episode import Episode

Floats = NDArray[np.float32]
#: Names of the arrays among the frames that the loss reads.
LOG_P, ADVANTAGE, TARGET = "old_log_p", "advantage", "value_target"
_ARRAYS: Final = ("log_p", "advantage", "target")
#: Fields of a plain trajectory in JSON, without ``led``.
_FIELDS: Final = 4


@dataclass(frozen=True, eq=False)
class Experience(Trajectory):
    """An episode that the policy played by itself; its labels are its actions."""

    log_p: Floats
    """(T,) float32 log-probability of each action, by the policy that played."""
    advantage: Floats
    """(T,) float32 generalised advantage of each action (Schulman et al., 2016)."""
    target: Floats
    """(T,) float32 return that the value should have predicted: advantage plus the value when it was played."""
    success: bool
    spl: float
    gained: float = 0.0
    """Discounted rewards of the whole episode."""

    def to_json(self) -> list[Any]:
        """As for a trajectory, then the arrays as base64 of little-endian float32, success, SPL and ``gained``.

        Last is ``led``.
        """
        plain, arrays = super().to_json(), (_text(getattr(self, name)) for name in _ARRAYS)
        return [*plain[:_FIELDS], *arrays, self.success, self.spl, self.gained, *plain[_FIELDS:]]


def generalised_advantages(rewards: Floats, values: Floats, discount: float, trace: float) -> Floats:
    """Advantages (T,) float32 of the actions of an episode that is over after the last one.

    Args:
        rewards: (T,) of each action.
        values: (T,) of the state before it.
        discount: of rewards, per step.
        trace: lambda; 1 compares the whole return with the value, 0 only the next step.
    """
    found, later, after = np.zeros(len(rewards), np.float32), 0.0, 0.0
    for step in range(len(rewards) - 1, -1, -1):
        surprise = float(rewards[step]) + discount * after - float(values[step])
        later = surprise + discount * trace * later
        found[step], after = later, float(values[step])
    return found


def discounted(rewards: Floats, discount: float) -> float:
    """Sum of the rewards (T,) of an episode, discounted per step."""
    return float(rewards.astype(np.float64) @ discount ** np.arange(len(rewards)))


def compared(experience: Sequence[Experience], repeats: int, by: str) -> list[Experience]:
    """Experience with one advantage for all actions of an episode: how much better it went than its repetitions.

    The outcome of an episode depends mostly on where the target is: the returns of two plays of one ``val`` episode by
    the shipped end-to-end policy correlate at .88, and its value predicts .17 of their variance. The mean of the
    *other* plays of the same episode is a baseline that leaves the gradient unbiased (Kool, van Hoof and Welling 2019).

    Args:
        experience: ``repeats`` plays of one episode, then of the next.
        repeats: at least 2.
        by: a name of :data:`COMPARE`.
    """
    came = np.array([COMPARE[by](one) for one in experience]).reshape(-1, repeats)
    better = (came - (came.sum(1, keepdims=True) - came) / (repeats - 1)).ravel()
    return [
        replace(one, advantage=np.full(len(one.actions), value, np.float32))
        for one, value in zip(experience, better, strict=True)
    ]


#: What repetitions of an episode can be compared by.
COMPARE: Final[Mapping[str, Callable[[Experience], float]]] = {
    "spl": lambda one: one.spl,
    "return": lambda one: one.gained,
}


def normalised(experience: Sequence[Experience]) -> list[Experience]:
    """Experience whose advantages have mean 0 and deviation 1 over all steps."""
    every = np.concatenate([one.advantage for one in experience]).astype(np.float64)
    mean, deviation = every.mean(), every.std() + 1e-6
    return [replace(one, advantage=((one.advantage - mean) / deviation).astype(np.float32)) for one in experience]


def with_experience(replay: Replay, experience: Experience) -> Replay:
    """A replay with the arrays of the experience among its frames, for the loss."""
    arrays = {LOG_P: experience.log_p, ADVANTAGE: experience.advantage, TARGET: experience.target}
    return replace(replay, frames={**replay.frames, **arrays})


def experience_from_json(rows: Any, episodes: Mapping[str, Episode]) -> list[Experience]:
    """Read what :meth:`Experience.to_json` wrote.

    Args:
        rows: plain values; not trusted.
        episodes: known episodes by id.

    Raises:
        DataError: a row of another form, of an unknown episode, or with impossible arrays.
    """
    width = _FIELDS + len(_ARRAYS) + 3
    if not isinstance(rows, list) or not all(isinstance(row, list) and len(row) in (width, width + 1) for row in rows):
        raise DataError("state with experience of another form; resume with the run's own configuration")
    trajectories = trajectories_from_json([[*row[:_FIELDS], *row[width:]] for row in rows], episodes)
    found = []
    for one, row in zip(trajectories, rows, strict=True):
        log_p, advantage, target = (_array(text, len(one.actions)) for text in row[_FIELDS : _FIELDS + len(_ARRAYS)])
        success, spl, gained = row[width - 3 : width]
        sound = type(success) is bool and type(spl) is float and 0.0 <= spl <= 1.0 and type(gained) is float
        if not sound or not np.isfinite(gained) or (log_p > 0).any():
            raise DataError(f"state with invalid experience of episode {one.episode.id}")
        made = Experience(
            one.episode, one.level, one.actions, one.labels, log_p, advantage, target, success, spl, gained, led=one.led
        )
        found.append(made)
    return found


def _text(array: Floats) -> str:
    return base64.b64encode(array.astype("<f4").tobytes()).decode("ascii")


def _array(text: Any, length: int) -> Floats:
    """An array (length,) of :func:`_text`; refused where it is of another length or not finite."""
    try:
        found = np.frombuffer(base64.b64decode(text, validate=True), "<f4").astype(np.float32)
    except (TypeError, ValueError, binascii.Error):
        found = np.full(0, np.nan, np.float32)
    if len(found) != length or not np.isfinite(found).all():
        raise DataError("state with experience that is cut off or not finite")
    return found
