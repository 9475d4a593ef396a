"""Collections of DAgger: a mixture of policy and expert plays some episodes, and the expert labels every step.

A collection is cut into parts of a fixed size. Each is a function of weights, seed and its numbers alone, so it is the
same whichever process plays it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from ucon.core.rng import stream
from ucon.learning.imitation.experts import Corrector
from ucon.learning.imitation.replaying import Replayer, learns_views, with_views
from ucon.learning.imitation.trajectories import NO_LABEL, Replay, Trajectory
from ucon.learning.imitation.view_labels import Label
from ucon.learning.policies.playing import Job, Players, PolicyChooser, Seen
from ucon.task.actions import Action

if TYPE_CHECKING:
    from torch import Tensor, dtype, nn

    from ucon.learning.policies.action_policy import ActionPolicy

Played = tuple[Trajectory, Replay]


@dataclass(frozen=True)
class CollectionPart:
    """Some episodes of a collection, played at once."""

    iteration: int
    """Number of the collection."""
    first: int
    """Number of the first episode in the collection."""
    jobs: tuple[Job, ...]
    weights: Mapping[str, Tensor]
    """State of the policy that plays, by name."""
    share: float
    """Probability that the expert acts."""
    temperature: float
    """The policy's actions are sampled at this temperature; 0: the action with the highest logit."""
    seed: int


class Collector:
    """Plays parts of collections, in this process.

    Args:
        policy: plays, with the weights of each part.
        make_env: makes an environment of ``UcON-v0``; called when the first part comes.
        expert: labels every step.
        slots: most episodes of a part, which are played at once.
        max_steps: episodes are cut off after this many actions.
        device: that the policy plays on; it is moved there when the first part comes.
        precision: of the passes of the policy that plays; None: float32.

    Attributes:
        replayer: plays trajectories again; the expert labels their views again, if the policy learns from them.
    """

    def __init__(
        self,
        policy: nn.Module,
        make_env: Callable[[], Any],
        expert: Corrector,
        slots: int,
        max_steps: int,
        device: str = "cpu",
        precision: dtype | None = None,
    ) -> None:
        self._policy, self._expert, self._device = policy, expert, device
        self.replayer = Replayer(cast("ActionPolicy", policy), make_env, expert if learns_views(policy) else None)
        self._players = Players(policy, make_env, slots, max_steps, keep_frames=True, precision=precision)

    def __call__(self, part: CollectionPart) -> list[Played]:
        """Play one part.

        Returns:
            For each job, its trajectory and what the policy saw along it, in the order of the jobs.
        """
        self._policy.to(self._device).load_state_dict(part.weights)
        chooser = _Mixture(part, self._expert, views=learns_views(self._policy))
        played = []
        for number, one in enumerate(self._players.play(part.jobs, chooser, "collecting")):
            assert one.replay is not None  # keep_frames
            labels = "".join(chooser.labels[number])
            trajectory = Trajectory(one.job.episode, one.job.level, one.actions, labels, led=one.job.led)
            played.append((trajectory, with_views(one.replay, chooser.views.get(number))))
        return played

    def close(self) -> None:
        """Close the environments; a later call makes new ones."""
        self._players.close()
        self.replayer.close()


class _Mixture:
    """Chooses the expert's action with probability ``share``, else the policy's.

    Records the expert's label of every step.

    If the policy says Done where the expert does not, the expert's action is taken: Done would end the episode, and no
    further step could be labelled.
    """

    def __init__(self, part: CollectionPart, expert: Corrector, *, views: bool) -> None:
        self._part, self._expert, self._with_views = part, expert, views
        self.views: dict[int, list[Label]] = {}
        keys = ("stray", part.iteration, part.first)
        self._policy = PolicyChooser(part.temperature > 0, part.seed, *keys, temperature=part.temperature)
        self._slot: dict[int, int] = {}
        """Slot of each job, by number: one for each environment."""
        self._number: dict[int, int] = {}
        self.labels: dict[int, list[str]] = {}

    def begin(self, number: int, job: Job, env: Any, info: Mapping[str, Any]) -> None:
        self.labels[number] = []
        if self._with_views:
            self.views[number] = []
        self._slot[number] = self._number.setdefault(id(env), len(self._number))
        self._expert.begin(self._slot[number], job.episode, env, info)

    def choose(self, number: int, step: int, logits: NDArray[np.float64], seen: Seen) -> int:
        part = self._part
        best = self._expert.label(self._slot[number], *seen)
        self.labels[number].append(NO_LABEL if best is None else str(int(best)))
        if self._with_views:
            self.views[number].append(self._expert.views(self._slot[number]))
        own = self._policy.choose(number, step, logits, seen)
        if best is None:
            return own
        draw = stream(part.seed, "mixture", part.iteration, part.first + number, step)
        too_early = own == Action.DONE and best != Action.DONE
        return int(best) if too_early or draw.random() < part.share else own
