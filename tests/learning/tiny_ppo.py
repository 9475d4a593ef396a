"""Small real PPO learners: with the tiny policy over the seven actions, and with a narrow habit policy."""

import functools

from models.habit_policy import HabitPolicy
from tests.learning.tiny_policy import ENV, TinyPolicy, training_file
from ucon.envs.search.env import UcONSearchEnv
from ucon.learning.policies.validation import Validation
from ucon.learning.ppo.clipped_loss import PPOLoss
from ucon.learning.ppo.collecting import InProcess
from ucon.learning.ppo.learner import PPOLearner

SEARCH = functools.partial(UcONSearchEnv, "mini")
LEVELS = ("none", "retrieval")


def narrow_habit_policy(seed=0, **options):
    return HabitPolicy(width=16, layers=1, heads=2, seed=seed, **options)


def tiny_ppo(folder, policy=None, **options):
    """A PPO learner that learns from sixty steps of the environment at a time."""
    validation = {"episodes": "mini", "n_play": 2, "max_steps": 8, "slots": 2} | options.pop("validation", {})
    standard = {"steps": 20, "frames": 60, "minibatch": 24, "chunk": 8, "lr": 5e-3, "discount": 0.95}
    standard |= {"episodes": options.pop("episodes", None) or training_file(folder), "levels": LEVELS}
    standard |= {"env": ENV, "search": SEARCH, "collector": InProcess(), "loss": PPOLoss()}
    return PPOLearner(policy=policy or TinyPolicy(), validation=Validation(**validation), **standard | options)
