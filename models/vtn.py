"""VTN: the Visual Transformer Network (Du, Yu and Zheng, ICLR 2021), with the sizes of its released code.

As in the release: all sizes, the order of layers, initialisation, the target only as a mark on tokens with its label,
and the last action as the policy's own probabilities. Different, because of the task: seven actions instead of six;
frames of 128 pixels, enlarged to 224 for the frozen ResNet-18, instead of 300; labels of the catalogue, scaled to
VTNet's range. By default tokens come from the environment's detector with a learned feature per category, since DETR's
weights are not shipped (:mod:`models.nets.vision.detr_tokens` reads them). Habits are not read, as in the paper's
table.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn.functional import linear, relu

from models.nets.policy_defaults import N_ACTIONS, PolicyModule, lstm_state
from models.nets.vision.backbone import FrozenBackbone
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
    """Tokens, frozen feature map and visual transformer: the part that VTN and its pre-training share."""

    def __init__(self, tokens: Tokens | None, backbone: FrozenBackbone | None, dropout: float) -> None:
        super().__init__()
        if not 0.0 <= dropout < 1.0:
            raise ConfigError(f"agent.policy.dropout={dropout}: expected 0 to below 1")
        self.tokens = tokens or LabelTokens()
        self._backbone = backbone or FrozenResNet18()
        self.visual = VisualTransformer(dropout, self._backbone.channels)

    @property
    def arguments(self) -> Mapping[str, Any]:
        """Names of the tokens' source and of the frozen backbone, with hashes where they have weights."""
        return {"tokens": self.tokens.name, "backbone": self._backbone.name}

    def check(self) -> None:
        """Raise a one-line error where weights of tokens or backbone are missing."""
        self.tokens.check()
        self._backbone.check()

    def fingerprint(self) -> str | None:
        """Hashes of tokens and backbone; None where some weights are missing."""
        parts = self.tokens.fingerprint(), self._backbone.fingerprint()
        return None if None in parts else "".join(part for part in parts if part)

    def context(self, info: Mapping[str, Any]) -> Arrays:
        """``target`` () int64: the label of the target."""
        return {"target": np.array(self.tokens.label_of(str(info["target"])), np.int64)}

    def frame(self, observation: Mapping[str, Any], info: Mapping[str, Any]) -> Arrays:
        """``rgb`` (H, W, 3) uint8, and the inputs of the tokens.

        Raises:
            ConfigError: the environment gives no images.
        """
        if "rgb" not in observation:
            raise ConfigError(f"agent {self.architecture}: observations without images; give env.observe=pixels")
        return {"rgb": observation["rgb"], **self.tokens.frame(observation, info)}

    def features(self, frames: Tensors) -> Tensors:
        """``map`` (..., channels, 7, 7) float16 in place of ``rgb``, and tokens; 50 kB per frame."""
        if "map" in frames:
            return frames
        rgb = frames["rgb"]
        maps = self._backbone.maps(rgb.reshape(-1, *rgb.shape[-3:])).unflatten(0, rgb.shape[:-3])
        return {name: t for name, t in self.tokens.features(frames).items() if name != "rgb"} | {"map": maps}

    def seen(self, frames: Tensors, context: Tensors) -> Tensor:
        """Output of the visual transformer for T x B frames, (T, B, 3136) float32."""
        frames = self.features(frames)
        steps, batch = frames["map"].shape[:2]
        flat = {name: tensor.flatten(0, 1) for name, tensor in frames.items()}
        return self._transformed(flat, context["target"].repeat(steps)).unflatten(0, (steps, batch))

    def _transformed(self, flat: Tensors, target: Tensor) -> Tensor:
        """Output (N, 3136) float32 of the visual transformer for features of N frames, each with its target (N,)."""
        marked = indicator(flat, target)
        things = described(flat["label"], self.tokens.n_labels, flat["box"], flat["score"], marked)
        found: Tensor = self.visual(self.tokens(flat), things, flat["map"].float())
        return found


class VTN(_Seeing):
    """Recurrent policy with 17.9 M parameters, 9.7 M of them in the LSTM.

    The LSTM reads 3200 numbers: 49 regions of 64, and 64 of the last action.
    """

    architecture = "vtn"

    def __init__(
        self,
        tokens: Tokens | None = None,
        backbone: FrozenBackbone | None = None,
        *,
        dropout: float = 0.1,
        pretrained: str | None = None,
        freeze_visual: bool = False,
        seed: int = 0,
    ) -> None:
        """Build the network with random weights.

        Args:
            tokens: source of local tokens; None: :class:`LabelTokens`.
            backbone: frozen network of the frame; None: random weights.
            dropout: of the visual transformer in training.
            pretrained: weights of :class:`VTNPretraining`, or a run of ``train.py agent=vtn_pretraining``; the release
                says that training collapses without it.
            freeze_visual: only the LSTM and the layers after it are trained, with the visual transformer of
                ``pretrained`` or of weights that are loaded later. Its output for a frame is computed once.
            seed: of the weights.

        Raises:
            ConfigError: a dropout outside [0, 1).
            DataError: no weights in ``pretrained``, or those of another network.
        """
        super().__init__(tokens, backbone, dropout)
        self._frozen = freeze_visual
        if freeze_visual:  # still a submodule: it was trained before, and is stored with the policy
            self.visual.requires_grad_(False)
            self.tokens.requires_grad_(False)
        self.action_embed = nn.Linear(N_ACTIONS, _ACTION_WIDTH)
        self.lstm = nn.LSTM(VISUAL_WIDTH + _ACTION_WIDTH, _HIDDEN, num_layers=2)
        self.actor = nn.Linear(_HIDDEN, N_ACTIONS)
        self.critic = nn.Sequential(nn.Linear(_HIDDEN, 64), nn.Linear(64, 1))
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(derived_seed(seed, self.architecture))
            _initialise(self)
        if pretrained is not None:
            self._load_pretrained(VTNPretraining(self.tokens, self._backbone), pretrained)

    def train(self, mode: bool = True) -> VTN:
        """As in torch; a frozen visual transformer has no dropout."""
        super().train(mode)
        if self._frozen:
            self.visual.eval()
        return self

    def frame(self, observation: Mapping[str, Any], info: Mapping[str, Any]) -> Arrays:
        """As in pre-training; where the visual transformer is frozen, also the ``target``, which it reads."""
        arrays = super().frame(observation, info)
        return {**arrays, **self.context(info)} if self._frozen else arrays

    def features(self, frames: Tensors) -> Tensors:
        """As in pre-training; where the visual transformer is frozen, only ``seen`` (..., 3136) float32."""
        if not self._frozen:
            return super().features(frames)
        if "seen" in frames:
            return frames
        target = frames["target"]
        flat = {name: tensor.flatten(0, target.ndim - 1) for name, tensor in super().features(frames).items()}
        with torch.no_grad(), torch.autocast(self.device.type, enabled=False):
            return {"seen": self._transformed(flat, target.flatten()).unflatten(0, target.shape)}

    def seen(self, frames: Tensors, context: Tensors) -> Tensor:
        """As in pre-training; the output of a frozen visual transformer is part of the features."""
        return self.features(frames)["seen"] if self._frozen else super().seen(frames, context)

    def initial_state(self, batch: int) -> Tensors:
        """LSTM ``hidden`` and ``cell`` (B, 2, 512), and the last action's ``probabilities`` (B, 7); all 0."""
        return lstm_state(batch, self.lstm) | {"probabilities": torch.zeros(batch, N_ACTIONS, device=self.device)}

    def forward(self, frames: Tensors, context: Tensors, state: Tensors) -> PolicyOutputs:
        """Read T steps of B episodes, one by one: each step reads the action probabilities of the one before.

        Shapes as in :class:`ucon.learning.policies.action_policy.ActionPolicy`.
        """
        # The first layer reads all frames at once; the loop computes only what depends on the step before.
        seen = self.seen(frames, context)  # (T, B, 3136)
        w = dict(self.lstm.named_parameters())
        from_frames, from_action = w["weight_ih_l0"].split([VISUAL_WIDTH, _ACTION_WIDTH], 1)
        bias = w["bias_ih_l1"] + w["bias_hh_l1"]
        logits, hidden, probabilities = [], [], state["probabilities"]
        (h0, h1), (c0, c1) = (state[name].unbind(1) for name in ("hidden", "cell"))
        for gates in linear(seen, from_frames, w["bias_ih_l0"] + w["bias_hh_l0"]):
            acted = relu(self.action_embed(probabilities))
            h0, c0 = _lstm_cell(gates + linear(acted, from_action) + linear(h0, w["weight_hh_l0"]), c0)
            h1, c1 = _lstm_cell(linear(h0, w["weight_ih_l1"], bias) + linear(h1, w["weight_hh_l1"]), c1)
            logits.append(self.actor(h1).float())
            hidden.append(h1)
            probabilities = logits[-1].softmax(-1)
        after = {"hidden": torch.stack([h0, h1], 1), "cell": torch.stack([c0, c1], 1), "probabilities": probabilities}
        return PolicyOutputs(torch.stack(logits), self.critic(torch.stack(hidden))[..., 0].float(), after)

    def _load_pretrained(self, pretraining: VTNPretraining, path: str) -> None:
        """Load the pre-trained visual transformer; the tokens are shared."""
        load_network(path, pretraining, how="train it with `python train.py agent=vtn_pretraining learner=imitation`")
        self.visual.load_state_dict(pretraining.visual.state_dict())


class VTNPretraining(_Seeing):
    """Pre-training of the visual transformer: predicts the expert's action from one frame and the target.

    VTNet's supervised stage: no memory, no dropout, a linear head from 3136 to 7; AdamW at 1e-4, weight decay 1e-4,
    batches of 128 frames, the rate divided by ten every ten epochs, gradients clipped at 0.1.
    """

    architecture = "vtn_pretraining"

    def __init__(self, tokens: Tokens | None = None, backbone: FrozenBackbone | None = None, *, seed: int = 0) -> None:
        """Build the network with random weights; arguments as for :class:`VTN`."""
        super().__init__(tokens, backbone, dropout=0.0)
        self.head = nn.Linear(VISUAL_WIDTH, N_ACTIONS)
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(derived_seed(seed, self.architecture))
            _initialise(self)

    def forward(self, frames: Tensors, context: Tensors, state: Tensors) -> PolicyOutputs:
        """Logits (T, B, 7) of T steps of B episodes, each frame by itself; values are 0."""
        logits = self.head(self.seen(frames, context)).float()
        return PolicyOutputs(logits, torch.zeros_like(logits[..., 0]), {})


def _lstm_cell(gates: Tensor, cell: Tensor) -> tuple[Tensor, Tensor]:
    """Output and new cell (B, hidden) of a layer, float32, from its gates (B, 4 * hidden) in PyTorch's order."""
    taken, kept, new, shown = gates.float().chunk(4, -1)
    cell = torch.sigmoid(kept) * cell + torch.sigmoid(taken) * torch.tanh(new)
    return torch.sigmoid(shown) * torch.tanh(cell), cell


def _initialise(policy: _Seeing) -> None:
    """VTNet's initialisation: Glorot; rows of the actor with norm 0.01, of the critic 1; LSTM biases 0."""
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
        for layer, length in ((policy.actor, 0.01), (policy.critic[0], 1.0), (policy.critic[1], 1.0)):
            assert isinstance(layer, nn.Linear)
            nn.init.normal_(layer.weight)
            layer.weight.data.mul_(length / layer.weight.data.norm(dim=1, keepdim=True))
