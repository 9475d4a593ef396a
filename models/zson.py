"""ZSON: zero-shot object navigation with multimodal goal embeddings (Majumdar et al., NeurIPS 2022).

As in the release: all sizes and the order of layers, running mean and variance of the colours, augmentation, and
initialisation as in Habitat's baselines. Different, because of the task: seven actions; training by imitation with the
goal as text, where ZSON learned image goals by reinforcement over 500 M frames; an encoder with random initial weights,
where ZSON's were self-supervised (OVRL). With CLIP's weights the goal is CLIP's text vector, and the LSTM reads 1568
numbers as in the paper; by default the goal is the shipped sentence encoder's vector, and it reads 928. Habits are not
read.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn

from models.nets.policy_defaults import N_ACTIONS, PolicyModule, lstm_state, run_lstm
from models.nets.vision.augment import color_jitter, random_shift
from models.nets.vision.goals import ClipGoal, SentenceGoal
from models.nets.vision.group_norm_resnet import GroupNormResNet50, RunningMeanAndVar
from ucon.core.errors import ConfigError
from ucon.core.rng import derived_seed
from ucon.learning.policies.action_policy import Arrays, PolicyOutputs, Tensors
from ucon.task.actions import decoded_action

#: Side of a frame in pixels; the encoder's last map is then 4 x 4 with 128 channels, flattened to 2048 numbers.
FRAME_PX = 128
_VISUAL, _ACTION_WIDTH, _HIDDEN = 512, 32, 512
_JITTER, _SHIFT_PX = 0.3, 4


class ZSON(PolicyModule):
    """Recurrent policy with about 14 M parameters; a 2-layer LSTM reads frame, goal and last action."""

    architecture = "zson"

    reads_goal_images = True

    def __init__(self, goal: SentenceGoal | ClipGoal | None = None, *, augmented: bool = True, seed: int = 0) -> None:
        """Build the network with random weights.

        Args:
            goal: embeds the target's name; None: :class:`SentenceGoal`.
            augmented: whether training changes colours and shifts frames.
            seed: of the weights.
        """
        super().__init__()
        self._goal, self._augmented = goal or SentenceGoal(), augmented
        self.normalise, self.encoder = RunningMeanAndVar(), GroupNormResNet50()
        self.compression = nn.Sequential(
            nn.Conv2d(self.encoder.channels, 128, 3, padding=1, bias=False), nn.GroupNorm(1, 128), nn.ReLU()
        )
        self.visual = nn.Sequential(
            nn.Flatten(), nn.Linear(128 * (FRAME_PX // 32) ** 2, 256), nn.ReLU(), nn.Linear(256, _VISUAL)
        )
        self.last_action = nn.Embedding(N_ACTIONS + 1, _ACTION_WIDTH)
        self.lstm = nn.LSTM(_VISUAL + self._goal.dim + _ACTION_WIDTH, _HIDDEN, num_layers=2)
        self.actor, self.critic = nn.Linear(_HIDDEN, N_ACTIONS), nn.Linear(_HIDDEN, 1)
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(derived_seed(seed, self.architecture))
            self._initialise()

    @property
    def arguments(self) -> Mapping[str, Any]:
        """Name and size of the goal's embedding, which the weights depend on."""
        return {"goal": self._goal.name, "goal_dim": self._goal.dim}

    def check(self) -> None:
        """Raise a one-line error where weights of the goal's encoder are missing."""
        self._goal.check()

    def fingerprint(self) -> str | None:
        """Hash of the goal's encoder; None where its weights are missing."""
        return self._goal.fingerprint()

    def context(self, info: Mapping[str, Any]) -> Arrays:
        """``goal`` (D,) float32 with norm 1: embedding of the target's name, or of the goal image if there is one."""
        if "goal_image" in info:
            return {"goal": self._goal.encode_image(info["goal_image"])}
        return {"goal": self._goal.encode(str(info["target"]))}

    def frame(self, observation: Mapping[str, Any], info: Mapping[str, Any]) -> Arrays:
        """``rgb`` (128, 128, 3) uint8, and ``last_action`` () int64: 0 at the start, else the action + 1.

        Raises:
            ConfigError: no images, or images of another size.
        """
        rgb = observation.get("rgb")
        if rgb is None or rgb.shape != (FRAME_PX, FRAME_PX, 3):
            size = f"env.width_px={FRAME_PX} env.height_px={FRAME_PX}"
            raise ConfigError(
                f"agent zson: observations without images of {FRAME_PX} pixels; give env.observe=pixels {size}"
            )
        last = decoded_action(observation["last_action"])
        return {"rgb": rgb, "last_action": np.array((last + 1) % (N_ACTIONS + 1), np.int64)}

    def augment(self, frames: Tensors, generator: torch.Generator) -> Tensors:
        """Frames with colour jitter of 0.3 and a shift of up to 4 pixels; ``rgb`` stays uint8.

        The T steps of an episode are changed alike (:mod:`models.nets.vision.augment`).
        """
        if not self._augmented:
            return frames
        images = frames["rgb"].permute(0, 1, 4, 2, 3).float() / 255
        images = random_shift(color_jitter(images, _JITTER, generator), _SHIFT_PX, generator)
        return {**frames, "rgb": (images * 255).round().to(torch.uint8).permute(0, 1, 3, 4, 2)}

    def update_statistics(self, frames: Tensors) -> None:
        """Update the running mean and variance of the colours from ``rgb`` (N, 128, 128, 3)."""
        self.normalise.update_statistics(_channels_first(frames["rgb"]))

    def initial_state(self, batch: int) -> Tensors:
        """LSTM ``hidden`` and ``cell`` (B, 2, 512), all 0."""
        return lstm_state(batch, self.lstm)

    def forward(self, frames: Tensors, context: Tensors, state: Tensors) -> PolicyOutputs:
        """Read T steps of B episodes; shapes as in :class:`ucon.learning.policies.action_policy.ActionPolicy`."""
        steps, batch = frames["rgb"].shape[:2]
        images = _channels_first(frames["rgb"].flatten(0, 1))
        seen = self.visual(self.compression(self.encoder(self.normalise(images))))  # (T * B, 512)
        goal = context["goal"].float().expand(steps, batch, -1)
        parts = [seen.unflatten(0, (steps, batch)), goal, self.last_action(frames["last_action"].long())]
        hidden, state = run_lstm(self.lstm, torch.cat(parts, -1), state)
        return PolicyOutputs(self.actor(hidden).float(), self.critic(hidden)[..., 0].float(), state)

    def _initialise(self) -> None:
        """Habitat's initialisation: Kaiming for convolutions and linear layers, orthogonal for LSTM and heads."""
        relu_gain = nn.init.calculate_gain("relu")
        for module in [*self.encoder.modules(), *self.compression.modules(), *self.visual.modules()]:
            if isinstance(module, nn.Conv2d | nn.Linear):
                nn.init.kaiming_normal_(module.weight, relu_gain)
                if module.bias is not None:
                    nn.init.zeros_(module.bias)
            elif isinstance(module, nn.GroupNorm):
                nn.init.ones_(module.weight)
                nn.init.zeros_(module.bias)
        for name, weights in self.lstm.named_parameters():
            nn.init.zeros_(weights) if "bias" in name else nn.init.orthogonal_(weights)
        nn.init.normal_(self.last_action.weight)
        for head, gain in ((self.actor, 0.01), (self.critic, 1.0)):
            nn.init.orthogonal_(head.weight, gain)
            nn.init.zeros_(head.bias)


def _channels_first(rgb: Tensor) -> Tensor:
    """(N, H, W, 3) uint8 to (N, 3, H, W) in [0, 1]."""
    return rgb.permute(0, 3, 1, 2).float() / 255
