"""The options of learners, checked where they are made: configurations may hold anything.

A learner takes its parts (a policy, a loss, habits) by name and everything else as one of these; in a configuration
both stand side by side, as in ``learner.lr=0.001``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal

from ucon.core.errors import ConfigError, brief
from ucon.learning.run.option_checks import check
from ucon.learning.run.workers import MOST_WORKERS, WORKER_TIMEOUT_S, check_timeout
from ucon.retrieval.levels import check_level

#: Pieces of the train text that are read by parts fitted on the others.
N_FOLDS: Final = 2
#: Above every sensible option; keeps infinity out.
_MOST: Final = 1e9
#: Of an adapter: what is larger than the maps that it adds to is no adapter.
_MOST_RANK: Final = 1024


@dataclass(frozen=True, kw_only=True)
class LearnerOptions:
    """Options of every learner.

    Args:
        steps: length of the run, and of the schedule of the learning rate.
        lr: highest learning rate; the schedule is the learner's.
        warm_up: steps until it is reached.
        decay: weight decay.
        average: decay of the moving average of the parameters, which is what is chosen and kept; 0 for none.
        seed: of all that is drawn.
        initial: folder of the weights that it begins with, or a run of ``train.py``; None: those that it has.

    Raises:
        ConfigError: a value of the wrong type or outside its range.
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
        episodes: a named set or a file, of the ``train`` part alone.
        n_episodes: so many of them, evenly spaced; None: all.
        levels: habit levels that are mixed. One is enough for a policy that reads none.
        chunk: steps through which gradients flow in a policy with memory.
        clip: norm to which gradients are cut.
        device: ``cpu``, ``cuda``, or ``auto``: a GPU if there is one. Playing is done on the CPU.
        precision: ``float32``, or ``bfloat16`` for the passes of the network (the loss stays in float32); ``auto``:
            the latter on a GPU that has it.
        half: leave the policy in float16.
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
    """Options of ``learner=imitation`` and ``learner=dagger``.

    Args:
        batch: episodes of one step; ``auto``: as many as the demonstrator says, four times as many on a GPU.
        workers: processes that play episodes ahead; 0 plays them in this one. Changes nothing that is learned.
        worker_timeout_s: so long may the next batch take them; then they are ended, and the run with them.
        memory_gb: of what was seen, kept for the next time.
    """

    lr: float = 3e-4
    warm_up: int = 50
    clip: float = 1.0
    decay: float = 0.0
    average: float = 0.0
    half: bool = True
    batch: int | Literal["auto"] = 16
    workers: int = 0
    worker_timeout_s: float = WORKER_TIMEOUT_S
    memory_gb: float = 1.0

    def __post_init__(self) -> None:
        super().__post_init__()
        wanted = f"at least 0 and whole, at most {MOST_WORKERS}"
        check(wanted, lambda x: 0 <= x <= MOST_WORKERS, (int,), workers=self.workers)
        check("at least 0", lambda x: 0 <= x < _MOST, memory_gb=self.memory_gb)
        check_timeout("learner.worker_timeout_s", self.worker_timeout_s)


@dataclass(frozen=True, kw_only=True)
class PPOOptions(PolicyOptions):
    """Options of ``learner=ppo``; a step is a collection, of many updates.

    Args:
        frames: steps of the environment that one collection is learned from; ``auto``: 9,000, or fewer where the
            policy's memory is large.
        epochs: passes over a collection.
        minibatch: steps of the environment of one update.
        discount: of rewards, a step.
        trace: of the advantages (lambda).
        kl_stop: no further pass where the policy has moved so far from the one that played.
        anneal: let the learning rate fall by half a cosine to a tenth; else it stays.
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
        households: of one step.
        relation, relevance: weights of these losses beside that of the anchors.
        n_folds: of the parts that read the train text; of habits that belong to no scenes, as ``used_folds``.
        used_folds: so many of them are learned from (each takes minutes to fit); all by default.
        scene_evidence: of a dataset that is bound to scenes, learn also which places its sentences speak for.
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
class RetrieverOptions(LearnerOptions):
    """Options of ``learner=retriever``.

    Args:
        rank: of the adapter's matrices; those of ``initial`` are of the same.
        temperature: of the loss.
        other_weight: what a habit that supports no placement counts against 1 for one that does.
        owner: weight of :func:`ucon.learning.retriever.learner.owner_loss`.
        mask: share of the tokens that are hidden while learning.
        n_kbs: knowledge bases of one validation.
        precision: ``bfloat16`` multiplies in half the bits (three times as fast where the processor can), else
            ``float32``.
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
