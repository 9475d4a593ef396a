"""A small real policy over the seven actions, and learners of it: a convolution over depth, an LSTM, two heads."""

import functools

import numpy as np
import torch
from torch import nn

from models.nets.policy_defaults import PolicyModule, lstm_state, run_lstm
from ucon.envs.ucon_env import UcONEnv
from ucon.learning.episodes.collecting import EpisodeRollouts
from ucon.learning.episodes.learner import EpisodePPOLearner
from ucon.learning.episodes.loss import EpisodeLoss
from ucon.learning.imitation.dagger import DaggerLearner, DaggerRollouts
from ucon.learning.imitation.learner import ImitationLearner
from ucon.learning.imitation.sequence_loss import SequenceLoss
from ucon.learning.policies.action_policy import PolicyOutputs
from ucon.learning.policies.validation import Validation
from ucon.task.actions import decoded_action
from ucon.task.sets import load_episodes, save_episodes

ENV = functools.partial(UcONEnv, "mini", observe="pixels")


class TinyPolicy(PolicyModule):
    """Sees depth at 16 x 16, its last action, and the number of habits."""

    architecture = "tiny"
    uses_habits = True

    def __init__(self, width=64, dropout=0.0, seed=0):
        super().__init__()
        torch.manual_seed(seed)
        self.see = nn.Sequential(nn.Conv2d(1, 8, 4, 4), nn.ReLU(), nn.Flatten(), nn.Linear(128, width), nn.ReLU())
        self.did = nn.Embedding(8, 8)
        self.drop = nn.Dropout(dropout)
        self.memory = nn.LSTM(width + 9, width)
        self.choose, self.worth = nn.Linear(width, 7), nn.Linear(width, 1)

    def context(self, info):
        return {"habits": np.array([len(info["habits"]) / 100], np.float32)}

    def frame(self, observation, info):
        near = observation["depth"].reshape(16, 8, 16, 8).min((1, 3))
        return {"depth": near.astype(np.float16), "did": np.array(decoded_action(observation["last_action"]))}

    def initial_state(self, batch):
        return lstm_state(batch, self.memory)

    def forward(self, frames, context, state):
        steps, batch = frames["did"].shape
        seen = self.see(frames["depth"].float().reshape(-1, 1, 16, 16) / 5).reshape(steps, batch, -1)
        told = context["habits"].expand(steps, batch, 1)
        hidden, after = run_lstm(self.memory, self.drop(torch.cat([seen, self.did(frames["did"]), told], -1)), state)
        return PolicyOutputs(self.choose(hidden), self.worth(hidden)[..., 0], after)


class Stays(TinyPolicy):
    """Notes the device that it is sent to, but stays, since there is no GPU here."""

    def to(self, device):
        self.sent = device
        return self


def on_a_gpu(monkeypatch):
    """Make torch report a GPU with bfloat16."""
    monkeypatch.setattr(torch.cuda, "is_available", lambda: True)
    monkeypatch.setattr(torch.cuda, "get_device_capability", lambda device=None: (9, 0))


class Counting(TinyPolicy):
    """Counts the frames given for statistics, none of which may be padding."""

    n_seen = 0

    def update_statistics(self, frames):
        assert (frames["depth"] > 0).flatten(1).any(1).all(), "padding"
        self.n_seen += len(frames["depth"])


@functools.cache
def training_file(folder, count=6):
    """Short episodes of the ``train`` part, as a file."""
    chosen = sorted(load_episodes("train")[::50], key=lambda e: len(e.solution))[:count]
    path = folder / "some.jsonl.xz"
    save_episodes(chosen, path)
    return str(path)


def tiny_imitation(folder, policy=None, kind=ImitationLearner, **options):
    validation = options.pop("validation", {})
    validation = {"episodes": "mini", "n_demonstrations": 2, "n_play": 2, "max_steps": 12, "slots": 2} | validation
    standard = {"steps": 20, "batch": 3, "chunk": 8, "lr": 5e-3, "warm_up": 0}
    standard |= {"episodes": options.pop("episodes", None) or training_file(folder)}
    standard |= {"levels": ("none", "retrieval")}
    standard |= {"env": ENV}
    loss = options.pop("loss", None) or SequenceLoss({"done": 3.0})
    return kind(policy=policy or TinyPolicy(), loss=loss, validation=Validation(**validation), **standard | options)


def tiny_ppo_episodes(folder, policy=None, rollouts=None, **options):
    standard = {"episodes": 4, "max_steps": 25, "slots": 3, "temperature": 0.8}
    chosen = EpisodeRollouts(**standard | (rollouts or {}))
    options = {"batch": 2, "loss": EpisodeLoss(chosen.temperature), "validation": {"choose": "spl"}} | options
    return tiny_imitation(folder, policy, functools.partial(EpisodePPOLearner, chosen), **options)


def tiny_dagger(folder, policy=None, rollouts=None, **options):
    standard = {"per_iteration": 3, "episodes": 4, "max_steps": 25, "slots": 3}
    chosen = DaggerRollouts(**standard | (rollouts or {}))
    return tiny_imitation(folder, policy, functools.partial(DaggerLearner, chosen), **options)
