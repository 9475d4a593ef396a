"""Every policy with every policy learner, as configured in configs/: it is trained, or refused in one line."""

from pathlib import Path

import pytest
from hydra import compose, initialize_config_dir
from omegaconf import OmegaConf

from ucon.configuration.wiring import Factory
from ucon.core.errors import ConfigError

CONFIGS = Path(__file__).parents[2] / "configs"
OPTIONS = sorted((p.parent.name, p.stem) for p in CONFIGS.glob("*/*.yaml"))
#: Learners that do not play: they learn from stored data.
FROM_DATA = ("belief", "counterfactual", "foresight", "judge", "retriever")
#: Learners of an agent's policy.
OF_POLICIES = [n for g, n in OPTIONS if g == "learner" and n not in FROM_DATA]


def composed(*overrides: str, root: str = "eval") -> dict:
    with initialize_config_dir(str(CONFIGS), version_base="1.3"):
        config = compose(root, overrides=[*overrides, "out=runs/test"])
    return OmegaConf.to_container(config, resolve=True, throw_on_missing=True)


def with_a_policy():
    """Agents that have a policy, which can be trained."""
    return [n for g, n in OPTIONS if g == "agent" and "policy" in composed(f"agent={n}")["agent"]]


#: Why a learner does not take every policy.
UNFIT = {
    **dict.fromkeys(
        ("imitation", "searches", "dagger", "dagger_searches", "ppo_episodes"),
        "scores views, and stored solutions name actions",
    ),
    "image_goal": "reads names, not images of goals",
}


def fits(policy: str, learner: str) -> bool:
    """Whether a learner fits a policy: habit_policy scores views, the others choose actions, zson by goal images."""
    if learner == "image_goal":
        return policy == "zson"
    return learner == "ppo" or policy != "habit_policy"


@pytest.mark.parametrize("name", with_a_policy())
@pytest.mark.parametrize("learner", OF_POLICIES)
def test_every_policy_can_be_given_to_every_learner_of_policies(name, learner):
    config = composed(f"agent={name}", f"learner={learner}", root="train")
    assert config["learner"]["policy"] == config["agent"]["policy"]
    assert config["learner"]["env"]["config"]["observe"] == "pixels"
    assert config["learner"]["episodes"] == "train"
    env = Factory(config["learner"]["env"]["config"])
    assert env().observation_space["rgb"].shape == (128, 128, 3)
    if not fits(name, learner):
        with pytest.raises(ConfigError, match=UNFIT[learner]):
            Factory(config["learner"])()
        return
    built = Factory(config["learner"])()  # refuses what cannot be trained as configured
    assert built.resolved_options["precision"] in ("float32", "bfloat16")
    built.close()
