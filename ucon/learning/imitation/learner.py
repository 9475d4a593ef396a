"""``learner=imitation``: a policy over the seven actions is trained to predict a demonstrator's action at every step.

One step is a batch of whole episodes, each at its own habit level. They are read in chunks: the recurrent state passes
from chunk to chunk, gradients do not (:mod:`ucon.learning.policies.sequences`); a policy without memory reads their
steps in random order. The best checkpoint is chosen by the policy's own play on validation episodes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cached_property
from itertools import count
from typing import Any, cast

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from ucon.core.device import batch_size, torch_device, torch_precision
from ucon.core.errors import ConfigError, DivergedError
from ucon.core.files import sha256_bytes
from ucon.core.fingerprint import fingerprint_of
from ucon.core.progress import part
from ucon.core.rng import derived_seed, stream
from ucon.habits.splits import entry_parts
from ucon.learning.imitation.demonstrators import Demonstrator, SolutionDemonstrator
from ucon.learning.imitation.feeding import Feeder
from ucon.learning.imitation.trajectories import Replay, Trajectory
from ucon.learning.policies.action_policy import ActionPolicy, scores_views
from ucon.learning.policies.playing import Job, Players
from ucon.learning.policies.sequences import Batch, Chunk, ChunkLoss, detached_state
from ucon.learning.policies.validation import Validation, evenly_spaced
from ucon.learning.run.network_files import load_network, network_files, set_max_habits
from ucon.learning.run.option_checks import check, check_parts, text_weights
from ucon.learning.run.options import ImitationOptions
from ucon.learning.run.protocol import Card, Figures, State
from ucon.learning.run.updates import Updates, learn_only, require_finite
from ucon.task.episode import Episode
from ucon.task.sets import load_episodes


class ImitationLearner:
    """Behaviour cloning of demonstrations, by batches of whole episodes (see the module).

    Args:
        policy: an :class:`ucon.learning.policies.action_policy.ActionPolicy` that is a torch module; training starts
            from its present weights.
        env: makes an environment of ``UcON-v0`` with what the policy reads; pickled and sent to workers.
        loss: loss of a chunk.
        validation: validation episodes, and the figure that chooses the best checkpoint.
        demonstrator: gives the trajectories to imitate; by default the episodes' stored shortest solutions.
        options: fields of :class:`ucon.learning.run.options.ImitationOptions`.

    Raises:
        ConfigError: a value of the wrong type or out of range, or episodes outside the ``train`` part.
        DataError: ``initial`` holds no weights, or those of another network.
    """

    title = "imitation"

    options_of: type[ImitationOptions] = ImitationOptions
    """Dataclass of the options that ``**options`` may hold; read by the check of configurations."""

    def __init__(
        self,
        policy: nn.Module,
        env: Callable[[], Any],
        loss: ChunkLoss,
        validation: Validation,
        demonstrator: Demonstrator | None = None,
        **options: Any,
    ) -> None:
        self.options = given = self.options_of(**options)
        if not isinstance(policy, nn.Module):
            raise ConfigError("agent has no policy that can be trained; choose one that has, such as agent=vtn")
        if scores_views(policy):
            scorer = type(policy).__name__
            raise ConfigError(f"{scorer} scores views, and stored solutions name actions; train it with learner=ppo")
        self.device = torch_device(given.device, "learner.device")
        self._precision = torch_precision(given.precision, self.device, on_cpu=True)
        self.demonstrator = demonstrator or SolutionDemonstrator()
        batch = batch_size(given.batch, self.device, self.demonstrator.batch)
        check("above 0 and whole", lambda x: x > 0, (int,), batch=batch)
        self.policy, self.make_env, self.loss, self.validation = policy, env, loss, validation
        self.seed, self.batch = given.seed, batch
        self.act = cast(ActionPolicy, policy)
        self.levels = tuple(given.levels) if self.act.uses_habits else ("none",)
        self.episodes = evenly_spaced(load_episodes(given.episodes), given.n_episodes, "learner.n_episodes")
        probe = env().unwrapped
        self.source = probe.source
        self.dataset = self.source.dataset
        check_parts(self.episodes, validation.all, entry_parts(self.dataset))
        self._initial = "" if given.initial is None else load_network(str(given.initial), cast(Any, policy))
        set_max_habits(policy, probe)
        self.feeder = self._made_feeder()
        self.policy.to(self.device)
        if given.only is not None:
            learn_only(policy, given.only)
        self.updates = Updates(
            policy, lr=given.lr, clip=given.clip, steps=given.steps,
            warm_up=given.warm_up, decay=given.decay, average=given.average,
        )  # fmt: skip
        self.done, self.frames, self.labels = 0, 0, 0
        self._stream: Iterator[list[tuple[Trajectory, Replay]]] | None = None
        self._ordered: tuple[int, NDArray[np.int64]] = (-1, np.empty(0, np.int64))

    def _made_feeder(self, **players: Any) -> Feeder:
        """The feeder, with further ``players`` of its workers."""
        given = self.options
        options: dict[str, Any] = {"workers": given.workers, "memory_bytes": int(given.memory_gb * (1 << 30))}
        options |= {"worker_timeout_s": given.worker_timeout_s, **players}
        return Feeder(self.policy, self.make_env, demonstrator=self.demonstrator, **options)

    @property
    def identity(self) -> Mapping[str, str]:
        """Hashes of everything that training starts from; a checkpoint with other hashes is refused.

        Keys: ``habits``, ``episodes``, and where they apply ``frozen`` (weights of frozen networks), ``demonstrator``,
        ``initial`` and ``text`` (weights that embed and rank habits).
        """
        of_episodes = [f"{e.id} {e.home_hash} {e.solution}" for e in (*self.episodes, *self.validation.all)]
        frozen, shown = fingerprint_of(self.policy), self.demonstrator.fingerprint()
        hashes = {"habits": self.dataset.sha256, "episodes": sha256_bytes("\n".join(of_episodes).encode())}
        text = text_weights(self.source, (*self.levels, self.validation.level))
        others = {"frozen": frozen, "demonstrator": shown, "initial": self._initial, "text": text}
        return hashes | {name: by for name, by in others.items() if by}

    @property
    def resolved_options(self) -> Mapping[str, str | int]:
        """Values chosen for options given as ``auto``, by option: ``device``, ``precision``, ``batch``.

        The run stores them, so that it continues with the same values on another machine.
        """
        precision = str(self._precision).removeprefix("torch.")
        return {"device": self.device, "precision": precision, "batch": self.batch}

    @property
    def n_labels(self) -> int:
        """Number of different labelled frames so far; an episode counts once, at whatever habit levels it was seen."""
        return self.labels

    def assigned(self, item: int) -> tuple[Episode, str]:
        """Episode and habit level of training item ``item``, from 0.

        Each epoch goes once through all episodes in a random order (a function of seed and epoch); levels take turns.
        """
        epoch, place = divmod(item, len(self.episodes))
        return self.episodes[int(self._order(epoch)[place])], self.levels[(item + epoch) % len(self.levels)]

    def batches(self) -> Iterator[Sequence[Trajectory | Job]]:
        """Episodes and habit levels to demonstrate in each step from now on, without end; ``batch`` a step."""
        for step in count(self.done):
            items = range(step * self.batch, (step + 1) * self.batch)
            yield [Job(*self.assigned(item)) for item in items]

    def step(self) -> Figures:
        """Learn from one batch.

        Returns:
            The figures of the loss, ``gradient`` (norm before clipping), ``rate``, ``frames`` (trained on so far) and
            ``labels`` (different ones so far).

        Raises:
            DivergedError: a loss or gradient that is not finite.
        """
        if self._stream is None:
            self._stream = self.feeder(self.batches())
        pairs = self.prepared(next(self._stream))
        batch = Batch(pairs, self.loss.discount, self.device)
        seed = derived_seed(self.seed, "step", self.done)
        torch.manual_seed(seed)
        self.augment(batch, seed)
        self.train_mode()
        for frames in batch.frames:
            self.act.update_statistics(frames)
        sums, taken = self._learn_from(batch)
        figures = self.loss.figures(sums) | taken
        self.labels += sum(len(replay) for _, replay in pairs[: max(0, len(self.episodes) - self.done * self.batch)])
        self.done += 1
        self.frames += sum(batch.lengths)
        return figures | {"frames": float(self.frames), "labels": float(self.n_labels)}

    def train_mode(self) -> None:
        """Put the policy into the mode in which it learns."""
        self.policy.train()

    def augment(self, batch: Batch, seed: int) -> None:
        """Change the frames of a batch at random, as the policy asks for."""
        batch.augment(self.act, seed)

    def prepared(self, pairs: list[tuple[Trajectory, Replay]]) -> list[tuple[Trajectory, Replay]]:
        """The episodes of a batch, with everything that the loss reads."""
        return pairs

    def validate(self) -> Figures:
        """Loss and accuracy on validation demonstrations, SR and SPL of the policy's own play, and ``score``.

        All are figures of the averaged weights.
        """
        with self.updates.averaged():
            self.policy.eval()
            found = self.measured(self.validation.demonstrations(self.levels))
            found |= self.validation.played(self.players, self.seed)
        return found | self.validation.score(found)

    @cached_property
    def players(self) -> Players:
        """Environments in which the policy plays validation episodes; made on first use."""
        return Players(self.policy, self.make_env, self.validation.slots, self.validation.max_steps)

    def measured(self, trajectories: Sequence[Trajectory]) -> Figures:
        """Loss and accuracy on trajectories, without gradients; figures of the loss."""
        batches = [trajectories[at : at + self.batch] for at in range(0, len(trajectories), self.batch)]
        sums = torch.zeros(self.loss.n_sums, dtype=torch.float64)
        with torch.no_grad(), part("validating demonstrations", len(batches)) as tick:
            for number, pairs in enumerate(self.feeder(batches), 1):
                tick(number)
                batch = Batch(pairs, self.loss.discount, self.device)
                for _, of_chunk in self._passed(batch, self._chunks(batch)[1]):
                    sums += of_chunk
        return self.loss.figures(sums)

    def state_dict(self) -> State:
        """Weights, their moving average, optimiser moments, and the counters ``done``, ``frames`` and ``labels``."""
        return State(self.updates.tensors(), {"done": self.done, "frames": self.frames, "labels": self.labels})

    def load_state_dict(self, state: State) -> None:
        """Restore a state of :meth:`state_dict`; the next step is number ``done``.

        Raises:
            DataError: a state of another network or learner.
        """
        self.done, self.frames = state.count("done"), state.count("frames")
        self.labels = (
            state.count("labels") if "labels" in state.values else self.frames
        )  # absent in states of earlier versions
        self.updates.load(state.tensors, self.done)
        self._stream = None

    def lengthen(self, steps: int) -> bool:
        """Stretch the learning-rate schedule to ``steps`` in all, from the next step on.

        False where the rate is constant.
        """
        return self.updates.lengthen(steps)

    def product(self) -> Mapping[str, bytes]:
        """Files of the averaged policy, by name, as :class:`models.agents.policy.PolicyAgent` loads them.

        Raises:
            DataError: a weight that is not finite, or too large for float16.
        """
        with self.updates.averaged():
            return network_files(cast(Any, self.policy), half=self.options.half)

    @property
    def teacher(self) -> str:
        """The demonstrator in words, for the model card."""
        return self.demonstrator.title

    def card(self) -> Card:
        """Text of the model card: architecture, size, training episodes, levels and how to use the weights."""
        size = sum(value.numel() for value in self.updates.parameters.values())
        name = self.act.architecture
        return Card(
            f"Policy over the seven actions: {name}, by {self.title}",
            f"`{name}`, {size:,} trained parameters. Learned from episodes drawn from {len(self.episodes)} of the "
            f"`train` part, {self.n_labels:,} different labelled frames, {self.frames:,} with repetitions; habit "
            f"levels {', '.join(self.levels)}. Validation episodes chose the state; `test` was not touched.\n\n"
            f"Use: `python eval.py agent={name} agent.checkpoint=RUN`.\n\n"
            f"It learned from {self.teacher}; in homes unlike these it was not measured.",
            self.dataset.name,
        )

    def close(self) -> None:
        """Kill worker processes and close the environments of validation."""
        self.feeder.close()
        self._stream = None  # batches ahead were lost with the workers
        self.players.close()

    def _learn_from(self, batch: Batch) -> tuple[Tensor, Figures]:
        """Update the policy on a batch, once or every few chunks.

        Returns:
            Sums (n_sums,) float64 on the CPU, from which the loss computes figures; and the figures of the updates, as
            means over the updates.
        """
        n_chunks, chunks = self._chunks(batch)
        every = self.options.update_every or n_chunks
        n_updates = -(-n_chunks // every)
        total, taken = torch.zeros(self.loss.n_sums, dtype=torch.float64), []
        self.updates.begin()
        for number, (loss, sums) in enumerate(self._passed(batch, chunks), 1):
            (n_updates * loss).backward()  # type: ignore[no-untyped-call]
            total += sums
            if number % every == 0 or number == n_chunks:
                taken.append(self.updates.take(self.done))
                self.updates.begin()
        return total, {name: float(np.mean([figures[name] for figures in taken])) for name in taken[0]}

    def _chunks(self, batch: Batch) -> tuple[int, Iterator[Chunk]]:
        """Number of chunks of a batch, and the chunks.

        They hold consecutive steps or, for a policy without memory, steps drawn from all episodes of the batch.
        """
        steps = self.options.chunk
        if self.act.initial_state(1):
            return -(-batch.lengths[0] // steps), batch.chunks(steps)
        steps *= len(batch.lengths)
        seed = derived_seed(self.seed, "mixed", self.done)
        return -(-sum(batch.lengths) // steps), batch.mixed(steps, seed)

    def _passed(self, batch: Batch, chunks: Iterator[Chunk]) -> Iterator[tuple[Tensor, Tensor]]:
        """Forward pass over a batch: for each chunk its share of the loss, and the sums for the figures."""
        scale = self.loss.scale(batch)
        state: Mapping[str, Tensor] = self.act.initial_state(len(batch.lengths))
        kind = torch.device(self.device).type
        for chunk in chunks:
            state = detached_state(state, chunk.labels.shape[1])
            with torch.autocast(kind, self._precision, enabled=self._precision != torch.float32):
                outputs = self.act(chunk.frames, chunk.context, state)
            state = outputs.state
            loss, sums = self.loss(outputs, chunk, scale)
            if not bool(torch.isfinite(loss)):
                self._diverged(chunk, outputs._asdict())
            yield loss, sums

    def _diverged(self, chunk: Chunk, outputs: Mapping[str, Any]) -> None:
        """Raise an error that names the first tensor, from inputs to loss, that is not finite."""
        parts = {"frames": chunk.frames, "context": chunk.context, "parameter": self.updates.parameters}
        for kind, tensors in parts.items():
            require_finite({f"{kind} {name}": tensor for name, tensor in tensors.items()}, self.done)
        require_finite({name: outputs[name] for name in ("logits", "value")}, self.done)
        raise DivergedError(f"step {self.done + 1}: the loss is not finite; start a new run with a smaller learner.lr")

    def _order(self, epoch: int) -> NDArray[np.int64]:
        """Order of the episodes in an epoch, (n_episodes,) int64 permutation."""
        if self._ordered[0] != epoch:
            self._ordered = (epoch, stream(self.seed, "order", epoch).permutation(len(self.episodes)))
        return self._ordered[1]
