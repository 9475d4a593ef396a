"""A reader of habits by the belief head, with the same interface as the fitted anchor reader.

An agent uses it as ``models.agents.belief.ReadHabits(HeadReader.load())``. Candidates may be added during an episode;
each name is scored once.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any, Final

import numpy as np
import torch
from numpy.typing import NDArray

from models.nets.belief.belief_head import NEVER, BeliefHead, HeadOutputs
from ucon.core.errors import ConfigError, DataError
from ucon.core.files import MANIFEST, read_verified, sha256_file
from ucon.core.tensor_files import check_header, header
from ucon.core.untrusted.strict_json import JsonError, parse_json
from ucon.habits.contexts import Context
from ucon.language.encoder import one_thread
from ucon.learning.belief_head.learner import CONFIG, PRIOR, WEIGHTS, head_tensors
from ucon.learning.run.run_folder import MODEL
from ucon.objects.model import RELATIONS
from ucon.readers.anchor_prior import AnchorPrior
from ucon.readers.anchor_reader import AnchorBelief
from ucon.readers.conditions.condition_reader import ConditionReader, default_conditions
from ucon.readers.household import Candidates, FittedParts, Household, default_parts, parts_with
from ucon.readers.reader_weights import Array, sigmoid, softmax

#: The shipped head, as a run of ``python train.py learner=belief`` leaves it.
SHIPPED: Final = Path(__file__).parents[3] / "checkpoints" / "belief_head" / "model"
DECIMALS: Final = 4
#: Limits for heads from a folder: bytes of weights, any of the sizes, and number of blocks.
MOST_BYTES: Final = 1 << 28
_MOST_SIZE: Final = 1 << 16
_MOST_BLOCKS: Final = 64


class HeadReading:
    """What H habits say about one target; see :class:`ucon.readers.anchor_reader.Reading`.

    Args:
        reader: scores further candidates.
        target: category that is looked for.
        household: the habits as the fitted parts read them.
        trusted: True if all habits are about the target.
        holds: (H,) how much each habit counts in the given context; None: no context was given.
    """

    def __init__(
        self, reader: HeadReader, target: str, household: Household, trusted: bool, holds: Array | None = None
    ) -> None:
        self.target, self.texts = target, household.texts
        self.household, self.trusted, self.holds, self._reader = household, trusted, holds, reader
        self._score: dict[str, float] = {}
        self._relation: dict[str, Array] = {}
        self._support: dict[str, Array] = {}
        self.relevance: Array = np.zeros(0)
        """(H,) probability that each habit is about the target."""
        self.null = 0.0
        """Logit of everything that is neither a candidate nor known."""

    def belief(self, candidates: Sequence[str]) -> AnchorBelief:
        """Distribution over candidate anchor categories; the target itself gets 0.

        Args:
            candidates: category names; duplicates count once.
        """
        names = tuple(dict.fromkeys(candidates))
        self._read(names)
        hidden = [name for name in self._reader.known if name not in set(names)]
        scores = [self._score[name] for name in (*names, *hidden)]
        p = softmax(np.asarray([*scores, self.null]))
        unseen = {name: float(value) for name, value in zip(hidden, p[len(names) : -1], strict=True)}
        relation = np.stack([self._relation[name] for name in names]) if names else np.zeros((0, len(RELATIONS)))
        return AnchorBelief(names, p[: len(names)], relation, float(sum(unseen.values()) + p[-1]), unseen)

    @property
    def telling(self) -> Array:
        """(H,) how much each habit says about where the target is, 0 to 1."""
        return self.relevance * self.household.said.place

    def support(self, anchor: str) -> Array:
        """(H,) how strongly each habit speaks for the target being at ``anchor``: the reasons for a belief."""
        self._read([anchor])
        return self.relevance * self._support[anchor]

    def _read(self, names: Sequence[str]) -> None:
        """Score the names that have no score yet."""
        new = [name for name in dict.fromkeys(names) if name not in self._score]
        if not new:
            return
        self._reader.fill([self], new)

    def take(self, candidates: Candidates, outputs: HeadOutputs, row: int) -> None:
        """Store the head's outputs for some candidates.

        Args:
            candidates: C candidates.
            outputs: of a batch of targets.
            row: of this target in the batch.
        """
        scores, relation, gate = (
            np.asarray(np.round(value[row].double().numpy(), DECIMALS), np.float64)
            for value in (outputs.anchor, outputs.relation, outputs.relevance)
        )
        if not self._score:
            self.null = float(np.round(float(outputs.unseen[row]), DECIMALS))
            self.relevance = np.ones(len(self.texts)) if self.trusted else sigmoid(gate)
            if self.holds is not None:
                self.relevance = np.minimum(self.relevance * self.holds, 1.0)
        said, usual = self.household.spoken(candidates), softmax(relation)
        for i, name in enumerate(candidates.names):
            self._score[name] = NEVER if name == self.target else float(scores[i])
            self._relation[name] = self._possible(name, usual[i])
            self._support[name] = said[:, i]

    def _possible(self, name: str, p: Array) -> Array:
        """Distribution over the relations that an anchor allows, (4,)."""
        allowed = p * (self._reader.parts.relation_prior([name])[0] > 0)
        return allowed / allowed.sum()


class HeadReader:
    """Reads habits with a trained belief head."""

    def __init__(
        self,
        head: BeliefHead,
        parts: FittedParts | None = None,
        weights: str = "",
        conditions: ConditionReader | None = None,
    ) -> None:
        """Wrap a head.

        Args:
            head: trained; is set to evaluation mode.
            parts: fitted parts that read the sentences for it; the shipped ones by default.
            weights: hash of its files.
            conditions: reads which sentences hold in a given context; the shipped one, loaded at first use.
        """
        self.head = head.eval()
        self.parts = parts or default_parts()
        self._weights = weights
        self.known = self.parts.known
        self.number = self.parts.number
        self.pairs = self.parts.pairs
        self.evidence = self.parts.evidence
        self._conditions = conditions
        self._last: tuple[tuple[str, ...], Household] | None = None

    @classmethod
    def load(cls, folder: str | Path | None = None) -> HeadReader:
        """Reader with the head in a folder.

        Args:
            folder: a run, or its ``model``; None: the shipped head.

        Raises:
            DataError: see :func:`load_head`; or it was trained with other fitted parts than the shipped ones.
        """
        path = _model_folder(SHIPPED if folder is None else Path(folder))
        head, described = load_head(path), _described(path / CONFIG)
        parts = default_parts()
        if isinstance(names := described.get("anchors"), list) and all(isinstance(name, str) for name in names):
            prior = AnchorPrior.from_bytes(read_verified(path / PRIOR), names, str(path / PRIOR))
            parts = parts_with(prior, path if described.get("own_places") else None)
        if described.get("parts") != parts.sha256:
            raise DataError(
                f"{path}: trained with different fitted parts than shipped; train it again (learner=belief)"
            )
        return cls(head, parts, sha256_file(path / MANIFEST))

    @property
    def conditions(self) -> ConditionReader:
        """Reads which sentences hold in a given context."""
        return self._conditions or default_conditions()

    def fingerprint(self) -> str:
        """Hash of the head's files; see :mod:`ucon.evaluation.playing.needed_weights`."""
        return self._weights

    def read(
        self, target: str, texts: Sequence[str], *, trusted: bool = False, context: Context | None = None
    ) -> HeadReading:
        """Read habits once for an episode.

        Args:
            target: category that is looked for.
            texts: the habits.
            trusted: True if all of them are about the target (level ``gt``).
            context: the context given, if any; habits that do not hold in it count less, those that do count more.
        """
        return self.read_all([target], texts, trusted=trusted, context=context)[0]

    def read_all(
        self, targets: Sequence[str], texts: Sequence[str], *, trusted: bool = False, context: Context | None = None
    ) -> list[HeadReading]:
        """Read the same habits for several targets in one forward pass; arguments as for :meth:`read`."""
        given = tuple(texts)
        if self._last is None or self._last[0] != given:
            self._last = (given, Household(self.parts, given))
        holds = None if context is None else self.conditions.weights(given, context, "head")
        readings = [HeadReading(self, target, self._last[1], trusted, holds) for target in targets]
        self.fill(readings, self.known)
        return readings

    def fill(self, readings: Sequence[HeadReading], names: Sequence[str]) -> None:
        """Score further candidates.

        Args:
            readings: of one household.
            names: candidates that they have no scores for.
        """
        if not readings:
            return
        household, candidates = readings[0].household, Candidates.of(names, self.parts)
        given = np.ones((len(readings), len(household.texts)), bool)
        trusted = np.asarray([reading.trusted for reading in readings])
        told = [reading.holds for reading in readings if reading.holds is not None]
        holds = np.stack(told) if told else None
        inputs = household.inputs([reading.target for reading in readings], candidates, given, trusted, holds=holds)
        with torch.inference_mode(), one_thread():
            outputs = self.head(inputs)
        for row, reading in enumerate(readings):
            reading.take(candidates, outputs, row)

    def belief(
        self, target: str, texts: Sequence[str], candidates: Sequence[str], *, trusted: bool = False
    ) -> AnchorBelief:
        """:meth:`read` and :meth:`HeadReading.belief` in one call.

        Args:
            target: category that is looked for.
            texts: the habits.
            candidates: anchor categories.
            trusted: True if all habits are about the target.
        """
        return self.read(target, texts, trusted=trusted).belief(candidates)

    def relation_prior(self, anchor: str) -> NDArray[np.float64]:
        """p(relation | anchor), (4,), before any habit is read."""
        return self.parts.relation_prior([anchor])[0]


def load_head(folder: Path) -> BeliefHead:
    """Load a head from the files of a training run, checked against their manifest.

    Args:
        folder: a run, or its ``model``.

    Raises:
        DataError: a file is missing or altered, or holds no head of this architecture.
    """
    folder = _model_folder(folder)
    options = _described(folder / CONFIG).get("head")
    with torch.device("meta"):  # compare sizes before memory for them is allocated
        planned = _built(options, folder / CONFIG).state_dict()
    weights = folder / WEIGHTS
    check_header(header(read_verified(weights, MOST_BYTES), weights), planned, weights)
    head = _built(options, folder / CONFIG)
    head.load_state_dict(head_tensors(weights, head))
    return head.eval()


def _built(options: Any, config: Path) -> BeliefHead:
    """An untrained head with the options in a file."""
    try:
        sizes = {name: value for name, value in options.items() if type(value) not in (bool, float)}
        if not all(value <= (_MOST_BLOCKS if name == "blocks" else _MOST_SIZE) for name, value in sizes.items()):
            raise ValueError
        return BeliefHead(**options)
    except (ValueError, LookupError, TypeError, AttributeError):
        raise DataError(f"{config}: describes no belief head of this version; train one with learner=belief") from None
    except ConfigError as error:
        raise DataError(f"{config}: describes no belief head ({error}); train one with learner=belief") from None


def _described(config: Path) -> dict[str, Any]:
    """Content of the configuration stored with a head's weights.

    Raises:
        DataError: it is missing or altered, or is not a JSON object.
    """
    try:
        found = parse_json(read_verified(config))
    except JsonError as error:
        raise DataError(f"{config}{error.at}: {error}; train one with learner=belief") from None
    if not isinstance(found, dict):
        raise DataError(f"{config}: describes no belief head of this version; train one with learner=belief")
    return found


def _model_folder(folder: Path) -> Path:
    """``folder``, or the ``model`` in it if it is a run."""
    folder = folder.expanduser()
    return folder / MODEL if (folder / MODEL).is_dir() else folder


@cache
def default_head_reader() -> HeadReader:
    """The shipped head's reader, one per process."""
    return HeadReader.load()
