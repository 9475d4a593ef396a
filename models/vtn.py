"""VTN: the Visual Transformer Network (Du, Yu, Zheng, ICLR 2021), with the sizes of its released code.

Kept: all sizes, the order of the layers, initialisation, the target as a mark on tokens of its label and nothing else,
the last action as the policy's own probabilities. Different here, because the task is: seven actions in place of six;
frames of 128 pixels, enlarged to 224 for the frozen ResNet-18, in place of 300; labels of the catalogue, scaled to
VTNet's range. By default tokens come from the environment's detector with a learned feature a category, since DETR's
weights are not shipped (:mod:`models.nets.vision.detr_tokens` reads them). Habits are not read: the paper's table has
none.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn.functional import relu

from models.nets.policy_defaults import N_ACTIONS, PolicyModule, lstm_state, run_lstm
from models.nets.vision.detr_tokens import DetrTokens
from models.nets.vision.local_tokens import LabelTokens, indicator
from models.nets.vision.resnet18 import FrozenResNet18
from models.nets.vision.visual_transformer import VISUAL_WIDTH, VisualTransformer, described, glorot_
from ucon.core.errors import ConfigError
from ucon.core.rng import derived_seed
from ucon.learning.policies.action_policy import Arrays, PolicyOutputs, Tensors
from ucon.learning.run.network_files import load_network

_ACTION_WIDTH, _HIDDEN = 64, 512


Tokens = LabelTokens | DetrTokens


class _Seeing(PolicyModule):
    """Tokens, frozen map and visual transformer: what VTN and its pre-training share."""

    def __init__(self, tokens: Tokens | None, backbone: FrozenResNet18 | None, dropout: float) -> None:
        super().__init__()
        if not 0.0 <= dropout < 1.0:
            raise ConfigError(f"agent.policy.dropout={dropout}: expected 0 to below 1")
        self.tokens = tokens or LabelTokens()
        self._backbone = backbone or FrozenResNet18()
        self.visual = VisualTransformer(dropout)

    @property
    def arguments(self) -> Mapping[str, Any]:
        """See :class:`ucon.learning.policies.action_policy.ActionPolicy`."""
        return {"tokens": self.tokens.name, "backbone": self._backbone.name}

    def check(self) -> None:
        """See :class:`models.nets.policy_defaults.PolicyModule`."""
        self.tokens.check()
        self._backbone.check()

    def fingerprint(self) -> str | None:
        """See :class:`models.nets.policy_defaults.PolicyModule`."""
        parts = self.tokens.fingerprint(), self._backbone.fingerprint()
        return None if None in parts else "".join(part for part in parts if part)

    def context(self, info: Mapping[str, Any]) -> Arrays:
        """``target`` () int64: the label that is looked for."""
        return {"target": np.array(self.tokens.label_of(str(info["target"])), np.int64)}

    def frame(self, observation: Mapping[str, Any], info: Mapping[str, Any]) -> Arrays:
        """``rgb`` (H, W, 3) uint8 and what the tokens need.

        Raises:
            ConfigError: the environment shows no images.
        """
        if "rgb" not in observation:
            raise ConfigError(f"agent {self.architecture}: observations without images; give env.observe=pixels")
        return {"rgb": observation["rgb"], **self.tokens.frame(observation, info)}

    def features(self, frames: Tensors) -> Tensors:
        """``map`` (..., 512, 7, 7) float16 in place of ``rgb``, and tokens; 50 kB a frame."""
        if "map" in frames:
            return frames
        rgb = frames["rgb"]
        maps = self._backbone.maps(rgb.reshape(-1, *rgb.shape[-3:])).unflatten(0, rgb.shape[:-3])
        return {name: t for name, t in self.tokens.features(frames).items() if name != "rgb"} | {"map": maps}

    def seen(self, frames: Tensors, context: Tensors) -> Tensor:
        """What T x B frames show (T, B, 3136)."""
        frames = self.features(frames)
        steps, batch = frames["map"].shape[:2]
        flat = {name: tensor.flatten(0, 1) for name, tensor in frames.items()}
        marked = indicator(flat, context["target"].repeat(steps))
        things = described(flat["label"], self.tokens.n_labels, flat["box"], flat["score"], marked)
        found: Tensor = self.visual(self.tokens(flat), things, flat["map"].float())
        return found.unflatten(0, (steps, batch))


class VTN(_Seeing):
    """17.9 M parameters, 9.7 M of them in the LSTM, which reads 3200 numbers: 49 regions of 64, and 64 of actions."""

    architecture = "vtn"

    def __init__(
        self,
        tokens: Tokens | None = None,
        backbone: FrozenResNet18 | None = None,
        *,
        dropout: float = 0.1,
        pretrained: str | None = None,
        seed: int = 0,
    ) -> None:
        """Build it with random weights.

        Args:
            tokens: source of local tokens; None: :class:`LabelTokens`.
            backbone: frozen network of the frame; None: random weights.
            dropout: of the visual transformer while training.
            pretrained: weights of :class:`VTNPretraining`, a run of ``train.py agent=vtn_pretraining``; training of
                all at once is said to collapse.
            seed: of the weights.
        """
        super().__init__(tokens, backbone, dropout)
        self.action_embed = nn.Linear(N_ACTIONS, _ACTION_WIDTH)
        self.lstm = nn.LSTM(VISUAL_WIDTH + _ACTION_WIDTH, _HIDDEN, num_layers=2)
        self.actor = nn.Linear(_HIDDEN, N_ACTIONS)
        self.critic = nn.Sequential(nn.Linear(_HIDDEN, 64), nn.Linear(64, 1))
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(derived_seed(seed, self.architecture))
            _initialise(self)
        if pretrained is not None:
            self._take_over(VTNPretraining(self.tokens, self._backbone), pretrained)

    def initial_state(self, batch: int) -> Tensors:
        """LSTM ``hidden`` and ``cell`` (B, 2, 512), and the last ``probabilities`` (B, 7): zeros."""
        return lstm_state(batch, self.lstm) | {"probabilities": torch.zeros(batch, N_ACTIONS, device=self.device)}

    def forward(self, frames: Tensors, context: Tensors, state: Tensors) -> PolicyOutputs:
        """See :mod:`ucon.learning.policies.action_policy`. Steps go one by one: each reads the last one's answer."""
        logits, hidden = [], []
        for seen in self.seen(frames, context):  # (B, 3136)
            inputs = torch.cat([seen, relu(self.action_embed(state["probabilities"]))], -1)
            outputs, memory = run_lstm(self.lstm, inputs[None], state)
            logits.append(self.actor(outputs[0]).float())
            hidden.append(outputs[0])
            state = memory | {"probabilities": logits[-1].softmax(-1)}
        return PolicyOutputs(torch.stack(logits), self.critic(torch.stack(hidden))[..., 0].float(), state)

    def _take_over(self, pretraining: VTNPretraining, path: str) -> None:
        load_network(path, pretraining, how="train it with `python train.py agent=vtn_pretraining learner=imitation`")
        self.visual.load_state_dict(pretraining.visual.state_dict())


class VTNPretraining(_Seeing):
    """The visual transformer alone, which is to tell the expert's action from one frame and the target.

    VTNet's supervised stage: no memory, no dropout, a linear head of 3136 to 7; AdamW at 1e-4, weight decay 1e-4,
    batches of 128 frames, the rate divided by ten every ten epochs, gradients clipped at 0.1.
    """

    architecture = "vtn_pretraining"

    def __init__(self, tokens: Tokens | None = None, backbone: FrozenResNet18 | None = None, *, seed: int = 0) -> None:
        """As :class:`VTN`."""
        super().__init__(tokens, backbone, dropout=0.0)
        self.head = nn.Linear(VISUAL_WIDTH, N_ACTIONS)
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(derived_seed(seed, self.architecture))
            _initialise(self)

    def forward(self, frames: Tensors, context: Tensors, state: Tensors) -> PolicyOutputs:
        """See :class:`ucon.learning.policies.action_policy.ActionPolicy`; values are 0."""
        logits = self.head(self.seen(frames, context)).float()
        return PolicyOutputs(logits, torch.zeros_like(logits[..., 0]), {})


def _initialise(policy: _Seeing) -> None:
    """VTNet's rules: Glorot; rows of the actor of length 0.01, of the critic 1; an LSTM without bias."""
    policy.apply(glorot_)
    for module in policy.modules():
        if isinstance(module, nn.Embedding):
            nn.init.normal_(module.weight)
            nn.init.zeros_(module.weight[0])
        elif isinstance(module, nn.LSTM):
            bound = module.hidden_size**-0.5
            for name, weights in module.named_parameters():
                nn.init.zeros_(weights) if name.startswith("bias") else nn.init.uniform_(weights, -bound, bound)
    if isinstance(policy, VTN):
        for linear, length in ((policy.actor, 0.01), (policy.critic[0], 1.0), (policy.critic[1], 1.0)):
            assert isinstance(linear, nn.Linear)
            nn.init.normal_(linear.weight)
            linear.weight.data.mul_(length / linear.weight.data.norm(dim=1, keepdim=True))
