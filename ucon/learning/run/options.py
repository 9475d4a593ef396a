"""Options of the learners, as dataclasses that check their values.

A learner takes its parts (policy, loss, habits) as objects and everything else as one of these dataclasses. In a
configuration both stand side by side, as in ``learner.lr=0.001``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal

from ucon.core.errors import ConfigError, brief
from ucon.learning.run.option_checks import check
from ucon.learning.run.workers import MOST_WORKERS, WORKER_TIMEOUT_S, check_timeout
from ucon.retrieval.levels import check_level

#: Folds of the train categories for cross-fitting.
N_FOLDS: Final = 2
#: Upper bound of numbers, so that infinity is refused.
_MOST: Final = 1e9
#: Highest rank of an adapter; the matrices that it is added to are not larger.
_MOST_RANK: Final = 1024


@dataclass(frozen=True, kw_only=True)
class LearnerOptions:
    """Options of every learner.

    Args:
        steps: length of the run, and of the learning-rate schedule.
        lr: highest learning rate; each learner has its own schedule.
        warm_up: steps of linear rise to the highest rate.
        decay: weight decay (decoupled).
        average: decay of the moving average of the parameters, which is validated and kept; 0 for none.
        seed: of everything that is drawn.
        initial: folder of weights to start from, or a run of ``train.py``; None: the network as it is built.

    Raises:
        ConfigError: a value of the wrong type or out of range.
    """

    steps: int
    lr: float
    warm_up: int
    decay: float
    average: float
    seed: int = 0
    initial: str | None = None

    def __post_init__(self) -> None:
        check("above 0 and whole", lambda x: x > 0, (int,), steps=self.steps)
        check("at least 0 and whole", lambda x: x >= 0, (int,), warm_up=self.warm_up)
        check("above 0", lambda x: 0 < x < _MOST, lr=self.lr)
        check("at least 0", lambda x: 0 <= x < _MOST, decay=self.decay)
        check("at least 0 and below 1", lambda x: 0 <= x < 1, average=self.average)
        check("a whole number", lambda x: True, (int,), seed=self.seed)


@dataclass(frozen=True, kw_only=True)
class PolicyOptions(LearnerOptions):
    """Options of learners of policies.

    Args:
        episodes: a named set or a file; all of the ``train`` part.
        n_episodes: how many of them, evenly spaced; None: all.
        levels: habit levels, mixed in every batch; ignored for a policy that reads no habits.
        chunk: steps through which gradients flow in a policy with memory.
        clip: largest norm of a gradient; larger ones are scaled down to it.
        device: ``cpu``, ``cuda``, or ``auto``: a GPU if there is one. Collections are not played on it.
        precision: ``float32``, or ``bfloat16`` for the network's passes (the loss stays in float32); ``auto``: bfloat16
            where the GPU, or for imitation the processor, has it.
        half: store the trained policy as float16.
    """

    episodes: str = "train"
    n_episodes: int | None = None
    levels: Sequence[str] = ("none", "retrieval", "full", "gt")
    chunk: int = 32
    clip: float
    device: str = "cpu"
    precision: str = "float32"
    half: bool

    def __post_init__(self) -> None:
        super().__post_init__()
        check("above 0 and whole", lambda x: x > 0, (int,), chunk=self.chunk)
        check("above 0", lambda x: 0 < x < _MOST, clip=self.clip)
        if isinstance(self.levels, str) or not self.levels:
            raise ConfigError(f"learner.levels={brief(self.levels)}: expected a list of at least one habit level")
        for level in self.levels:
            check_level(str(level))


@dataclass(frozen=True, kw_only=True)
class ImitationOptions(PolicyOptions):
    """Options of ``learner=imitation``.

    Args:
        batch: episodes of one step; ``auto``: the demonstrator's number, four times as many on a GPU.
        update_every: chunks from one update to the next; None: one update for all of a batch.
        workers: processes that play episodes ahead; 0 plays them in this one. The result does not depend on it.
        worker_timeout_s: seconds that workers may take for the next batch; then they are replaced.
        memory_gb: memory for replays, compressed, that are kept for the next epoch.
        only: names of parameters, or of modules that hold them, that are learned; others stay as they are. None: all.
    """

    lr: float = 3e-4
    warm_up: int = 50
    clip: float = 1.0
    decay: float = 0.0
    average: float = 0.0
    half: bool = True
    batch: int | Literal["auto"] = 16
    update_every: int | None = None
    workers: int = 0
    worker_timeout_s: float = WORKER_TIMEOUT_S
    memory_gb: float = 1.0
    only: Sequence[str] | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.only is not None and (isinstance(self.only, str) or not self.only):
            raise ConfigError(f"learner.only={brief(self.only)}: expected null, or a list of names, as [lstm,choose]")
        wanted = f"at least 0 and whole, at most {MOST_WORKERS}"
        check(wanted, lambda x: 0 <= x <= MOST_WORKERS, (int,), workers=self.workers)
        if self.update_every is not None:
            check("null, or above 0 and whole", lambda x: x > 0, (int,), update_every=self.update_every)
        check("at least 0", lambda x: 0 <= x < _MOST, memory_gb=self.memory_gb)
        check_timeout("learner.worker_timeout_s", self.worker_timeout_s)


@dataclass(frozen=True, kw_only=True)
class CollectingOptions(ImitationOptions):
    """Options of ``learner=dagger`` and ``learner=ppo_episodes``, which play what they learn from.

    Args:
        play_device: device of the policy that plays: ``cpu``, ``cuda`` or ``auto``. A GPU pays off for networks with
            images; what is played then depends on it in the last bits.
    """

    play_device: str = "cpu"


@dataclass(frozen=True, kw_only=True)
class DaggerOptions(CollectingOptions):
    """Options of ``learner=dagger``.

    Args:
        play_precision: as ``precision``, for the policy that plays; bfloat16 pays off for networks with images.
    """

    play_precision: str = "float32"


@dataclass(frozen=True, kw_only=True)
class PPOOptions(PolicyOptions):
    """Options of ``learner=ppo``, whose steps are a collection and many updates each.

    Args:
        frames: environment steps of one collection; ``auto``: 9,000, or fewer where the policy's recurrent state is
            large.
        epochs: passes over a collection.
        minibatch: environment steps of one update.
        discount: of rewards, per step.
        trace: lambda of the generalised advantages.
        kl_stop: no further pass where the KL divergence from the policy that played exceeds this (nats).
        anneal: True: the learning rate falls by half a cosine to a tenth. False: it stays constant.
    """

    lr: float = 5e-4
    warm_up: int = 0
    clip: float = 0.5
    decay: float = 0.0
    average: float = 0.0
    half: bool = False
    frames: int | Literal["auto"] = "auto"
    epochs: int = 2
    minibatch: int = 512
    discount: float = 1.0
    trace: float = 0.97
    kl_stop: float = 0.03
    anneal: bool = False

    def __post_init__(self) -> None:
        super().__post_init__()
        check("above 0 and whole", lambda x: x > 0, (int,), epochs=self.epochs, minibatch=self.minibatch)
        check("above 0", lambda x: 0 < x < _MOST, kl_stop=self.kl_stop)
        check("from 0 to 1", lambda x: 0 <= x <= 1, discount=self.discount, trace=self.trace)


@dataclass(frozen=True, kw_only=True)
class BeliefOptions(LearnerOptions):
    """Options of ``learner=belief``.

    Args:
        households: households of one step.
        relation: weight of the loss of relations; that of the anchors is 1.
        relevance: weight of the loss of the habits' relevance.
        n_folds: folds of the train categories, for habits without scenes; each is read by parts fitted on the others.
        used_folds: how many of the folds are trained on (each takes minutes to fit); None: all.
        scene_evidence: for a dataset bound to scenes: also fit a reader of places on its sentences.
        n_kbs: knowledge bases of one validation.
    """

    lr: float = 2e-3
    warm_up: int = 50
    decay: float = 0.02
    average: float = 0.99
    households: int = 2
    relation: float = 0.3
    relevance: float = 0.5
    n_folds: int = N_FOLDS
    used_folds: int | None = None
    scene_evidence: bool = False
    n_kbs: int = 8

    def __post_init__(self) -> None:
        super().__post_init__()
        whole = {"households": self.households, "warm_up": self.warm_up, "n_kbs": self.n_kbs}
        check("above 0 and whole", lambda x: x > 0, (int,), **whole)
        check("at least 0", lambda x: 0 <= x < _MOST, relation=self.relation, relevance=self.relevance)
        check("true or false", lambda x: True, (bool,), scene_evidence=self.scene_evidence)


@dataclass(frozen=True, kw_only=True)
class JudgeOptions(LearnerOptions):
    """Options of ``learner=judge``.

    Args:
        episodes: set of training episodes.
        searches: how many searches in them.
        validation: set of validation episodes.
        validation_searches: how many searches in them.
        workers: processes that search; the result does not depend on it.
        batch: cases of one step.
    """

    lr: float = 2e-3
    warm_up: int = 50
    decay: float = 0.01
    average: float = 0.99
    episodes: str = "train"
    searches: int = 1620
    validation: str = "val"
    validation_searches: int = 160
    workers: int = 2
    batch: int = 1024

    def __post_init__(self) -> None:
        super().__post_init__()
        counts = {"searches": self.searches, "validation_searches": self.validation_searches, "batch": self.batch}
        check("above 0 and whole", lambda x: x > 0, (int,), **counts)
        check(f"1 to {MOST_WORKERS}", lambda x: 1 <= x <= MOST_WORKERS, (int,), workers=self.workers)
        check("the name of a set", lambda x: bool(x), (str,), episodes=self.episodes, validation=self.validation)


@dataclass(frozen=True, kw_only=True)
class DecisionOptions(LearnerOptions):
    """Options of learners from labelled decisions, such as ``learner=foresight``.

    Args:
        episodes: set of training episodes.
        n_searches: how many searches in them.
        validation: set of validation episodes.
        validation_searches: how many searches in them.
        levels: habit levels, mixed.
        workers: processes that search; the result does not depend on it.
        batch: decisions of one step.
        mirror: whether half of the batches are mirrored left to right.
        clip: largest norm of a gradient; larger ones are scaled down to it.
        device: ``cpu``, ``cuda``, or ``auto``: a GPU if there is one.
        precision: ``float32``, or ``bfloat16`` for the network's passes in training (the loss stays in float32);
            ``auto``: bfloat16 where the GPU or the processor has it.
    """

    episodes: str = "train"
    n_searches: int = 2000
    validation: str = "val"
    validation_searches: int = 200
    levels: Sequence[str] = ("none", "retrieval", "full", "gt")
    workers: int = 2
    batch: int = 128
    mirror: bool = True
    clip: float = 1.0
    device: str = "auto"
    precision: str = "auto"

    def __post_init__(self) -> None:
        super().__post_init__()
        counts = {"n_searches": self.n_searches, "validation_searches": self.validation_searches, "batch": self.batch}
        check("above 0 and whole", lambda x: x > 0, (int,), **counts)
        check(f"1 to {MOST_WORKERS}", lambda x: 1 <= x <= MOST_WORKERS, (int,), workers=self.workers)
        check("the name of a set", lambda x: bool(x), (str,), episodes=self.episodes, validation=self.validation)
        check("above 0", lambda x: 0 < x < _MOST, clip=self.clip)
        check("true or false", lambda x: True, (bool,), mirror=self.mirror)
        if isinstance(self.levels, str) or not self.levels:
            raise ConfigError(f"learner.levels={brief(self.levels)}: expected a list of at least one habit level")
        for level in self.levels:
            check_level(str(level))


@dataclass(frozen=True, kw_only=True)
class RetrieverOptions(LearnerOptions):
    """Options of ``learner=retriever``.

    Args:
        rank: of the adapter's matrices; ``initial`` must have the same.
        temperature: of the loss; cosines are divided by it.
        other_weight: weight of a habit that supports no placement; one that does has weight 1.
        owner: weight of :func:`ucon.learning.retriever.learner.owner_loss`.
        mask: share of tokens that are masked in training.
        n_kbs: knowledge bases of one validation.
        precision: ``bfloat16`` (three times as fast where the processor supports it) or ``float32``.
    """

    lr: float = 7e-4
    warm_up: int = 20
    decay: float = 0.01
    average: float = 0.95
    rank: int = 32
    temperature: float = 0.05
    other_weight: float = 0.05
    owner: float = 1.0
    mask: float = 0.15
    n_kbs: int = 10
    precision: str = "bfloat16"

    def __post_init__(self) -> None:
        super().__post_init__()
        check("above 0 and whole", lambda x: x > 0, (int,), warm_up=self.warm_up, n_kbs=self.n_kbs)
        check(f"above 0 and whole, at most {_MOST_RANK}", lambda x: 1 <= x <= _MOST_RANK, (int,), rank=self.rank)
        check("above 0", lambda x: 0 < x < _MOST, temperature=self.temperature, other_weight=self.other_weight)
        check("at least 0", lambda x: 0 <= x < _MOST, owner=self.owner)
        check("at least 0 and below 1", lambda x: 0 <= x < 1, mask=self.mask)
