"""What is known of a detector's errors: agents read this, never the rates of a simulated detector.

Fitted on training homes by ``python -m ucon detector fit`` (:mod:`ucon.fitting.detector_errors`), for any detector that
finds boxes, and kept in a small file.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import cached_property, lru_cache
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import ConfigError, DataError, brief
from ucon.core.files import canonical_json
from ucon.core.sharing import Shared
from ucon.core.untrusted.plain_file import read_plain
from ucon.core.untrusted.strict_json import JsonError, parse_json
from ucon.core.untrusted.typed import read_as
from ucon.objects.catalogue import catalogue
from ucon.perception.detectors.base import vocabulary
from ucon.perception.detectors.confusion import FEATURES, similarity

#: Half the width in pixels of the canonical 128 x 128 view of 90 degrees: its focal length.
FOCAL_PX: Final = 64.0
_FIT: Final = "fit them on training homes: python -m ucon detector fit {} FILE"
_REMEDY: Final = _FIT.format("NAME")
#: Largest file.
_MOST_BYTES: Final = 1 << 20


@dataclass(frozen=True)
class DetectorErrors(Shared):
    """The errors of one detector, fitted on training homes.

    Raises:
        DataError: at construction, if a number is out of its range, or the vocabulary has changed since.
    """

    detector: str
    """Its name in ``configs/detector``."""
    vocabulary: str
    """Checksum of the names that it looks for."""
    looks: int
    """How many looks at things were fitted."""
    knots: tuple[float, ...]
    """Logarithms of pixels at which the slope of the recall's logit may change, ascending."""
    recall: tuple[float, ...]
    """Logit of the probability that a thing is found: constant, slope by the logarithm of its visible pixels and by
    each knot, by the logarithm of its distance in metres, and by the share of it that shows."""
    sighted: tuple[float, ...]
    """The same without the share, for things of known size and distance to which the line of sight is free."""
    right: float
    """Probability that a found thing is called by its own name."""
    score_knots: tuple[float, ...]
    """Scores at which ``score_evidence`` is given, ascending."""
    score_evidence: tuple[float, ...]
    """Logarithm of how much likelier such a score is for a right box than for a wrong one."""
    confusion: tuple[float, ...]
    """Weights of :data:`ucon.perception.detectors.confusion.FEATURES`; they say which wrong name a thing is given."""
    false_boxes: float
    """Mean number of boxes on nothing in a frame."""
    false_share: float
    """Share of boxes on nothing among the boxes at places where no box was before."""
    sides: int
    """Number of sides from which a thing can be looked at."""
    octave: float
    """Looks from one side err together if their distances are within a factor of two to the power of this."""
    repeats: float
    """Correlation of finding a thing in two looks that err together."""
    repeats_elsewhere: float
    """The same in two looks from different sides or distances."""
    names: tuple[str, ...]
    """Names of things seen in training homes."""
    counts: tuple[float, ...]
    """How many things of each of these names a home has on average."""

    def __post_init__(self) -> None:
        chances = {
            "right": self.right, "repeats": self.repeats, "false_share": self.false_share,
            "repeats_elsewhere": self.repeats_elsewhere,
        }  # fmt: skip
        wrong = [f"{name}={value}" for name, value in chances.items() if not 0.0 <= value <= 1.0]
        if wrong or not 0.0 <= self.false_boxes <= 100.0 or not 1 <= self.sides <= 64 or not 0.1 <= self.octave <= 4:
            raise DataError(
                f"errors of detector {brief(self.detector)}: {', '.join(wrong) or 'sides, octave or false boxes'} out "
                f"of range; {_REMEDY}"
            )
        lengths = (len(self.recall), len(self.sighted), len(self.score_evidence), len(self.confusion))
        if lengths != (len(self.knots) + 4, len(self.knots) + 3, len(self.score_knots), len(FEATURES)) or len(
            self.names
        ) != len(self.counts):
            raise DataError(f"errors of detector {brief(self.detector)}: {lengths} weights do not fit; {_REMEDY}")
        if self.vocabulary != vocabulary_hash():
            raise DataError(
                f"errors of detector {brief(self.detector)} were fitted with other category names; {_REMEDY}"
            )

    def __hash__(self) -> int:
        """Cheap, since caches are asked on every step; equality compares everything."""
        return hash((self.detector, self.vocabulary, self.looks, self.right))

    def fingerprint(self) -> str:
        """SHA-256 of the content."""
        return hashlib.sha256(self.to_json().encode()).hexdigest()

    def to_json(self) -> str:
        """The file's content."""
        return canonical_json(asdict(self))

    def found(
        self, pixels: NDArray[np.float64], away_m: NDArray[np.float64], share: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Probability that things are found.

        Args:
            pixels: (n,) that show, in the canonical 128 x 128 view.
            away_m: (n,) distance, metres.
            share: (n,) of the whole thing's pixels that show.

        Returns:
            (n,) float64.
        """
        rows = np.column_stack([size_features(pixels, away_m, self.knots), np.minimum(share, 1.0)])
        return np.asarray(1.0 / (1.0 + np.exp(-rows @ np.array(self.recall))))

    def sighted_curve(self, category: str, away_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Probability that a look finds a thing of a category to which the line of sight is free.

        Args:
            category: a catalogue name; others count as 0.1 m a side.
            away_m: (n,) distances, metres.

        Returns:
            (n,) float64.
        """
        rows = size_features(whole_pixels(category, away_m), away_m, self.knots)
        return np.asarray(1.0 / (1.0 + np.exp(-rows @ np.array(self.sighted))))

    def evidence(self, score: float) -> float:
        """Logarithm of how much likelier a score is for a right box than for a wrong one."""
        return float(np.interp(score, self.score_knots, self.score_evidence))

    @cached_property
    def called(self) -> NDArray[np.float32]:
        """(V, V) float32: logarithm of the probability that a thing of name n (row), called wrongly, is called l."""
        return confusions(self.confusion)


def size_features(
    pixels: NDArray[np.float64], away_m: NDArray[np.float64], knots: Sequence[float]
) -> NDArray[np.float64]:
    """Rows of the recall's logit by size and distance, (n, 3 + len(knots)) float64."""
    size = np.log(np.maximum(pixels, 0.1))
    hinges = [np.maximum(size - knot, 0.0) for knot in knots]
    return np.column_stack([np.ones_like(size), size, *hinges, np.log(np.maximum(away_m, 0.25))])


def whole_pixels(category: str, away_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Pixels that a thing of a category's size would have in the canonical view; it never shows more than 4,000.

    Args:
        category: a catalogue name; others count as 0.1 m a side.
        away_m: (n,) distances, metres.

    Returns:
        (n,) float64.
    """
    book = catalogue()
    x, y, z = book[category].size if category in book else (0.1, 0.1, 0.1)
    area = 0.5 * float(x * y + x * z + y * z)  # mean over directions: a quarter of the surface
    return np.minimum(area * (FOCAL_PX / np.maximum(away_m, 0.1)) ** 2, 4000.0)


@lru_cache(maxsize=4)
def confusions(weights: tuple[float, ...]) -> NDArray[np.float32]:
    """Logarithms of the chances of wrong names by weights of the features; see :attr:`DetectorErrors.called`."""
    logits = similarity() @ np.array(weights)
    np.fill_diagonal(logits, -np.inf)
    top = logits.max(1, keepdims=True)
    logits -= top + np.log(np.exp(logits - top).sum(1, keepdims=True))
    np.fill_diagonal(logits, -30.0)
    return np.maximum(logits, -30.0).astype(np.float32)


@lru_cache(maxsize=1)
def vocabulary_hash() -> str:
    """SHA-256 of the names that detectors look for."""
    return hashlib.sha256("\n".join(vocabulary()).encode()).hexdigest()


def parse_errors(text: str | bytes, where: str) -> DetectorErrors:
    """Read the errors of a detector from a file's content.

    Args:
        text: JSON.
        where: names the file in error messages.

    Raises:
        DataError: the content is not that of such a file, or its numbers are out of range.
    """
    try:
        data: Any = parse_json(text, max_bytes=_MOST_BYTES)
    except JsonError as error:
        raise DataError(f"{where}{error.at}: {error}; {_REMEDY}") from None
    return read_as(DetectorErrors, data, where, "the errors of a detector", remedy=_REMEDY)


def has_errors(name: str) -> bool:
    """Whether the errors of a detector come with the package."""
    return _shipped(name).is_file()


def _shipped(name: str) -> Traversable:
    """Where the package keeps the errors of a detector."""
    return files("ucon.perception.errors").joinpath(f"data/{name}.json")


def read_errors(name: str, path: Path | None = None) -> DetectorErrors:
    """The errors of a detector.

    Args:
        name: of the detector in ``configs/detector``.
        path: a file; None: the errors that come with the package.

    Raises:
        ConfigError: there is no such file, or its errors are those of another detector.
        DataError: the file does not hold the errors of a detector.
    """
    if path is None:
        if not has_errors(name):
            raise ConfigError(f"detector={name}: its errors do not come with the package; {_FIT.format(name)}")
        return parse_errors(_shipped(name).read_bytes(), f"ucon/perception/errors/data/{name}.json")
    if not path.is_file():
        raise ConfigError(f"{path}: no such file; {_FIT.format(name)}")
    found = parse_errors(read_plain(path, _MOST_BYTES), str(path))
    if found.detector != name:
        raise ConfigError(
            f"{path}: the errors of {brief(found.detector)}, expected those of {name}; {_FIT.format(name)}"
        )
    return found
