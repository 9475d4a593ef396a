"""A run's folder cannot choose the cluster to connect to."""

from pathlib import Path

import pytest
from hydra import compose, initialize_config_dir

from ucon.configuration.kept_config import configuration_of
from ucon.configuration.stored import checked, has_to_be_said
from ucon.core.errors import ConfigError
from ucon.programs.composing import eval_config, train_config
from ucon.programs.evaluating import Evaluation
from ucon.programs.training import chosen_run

ROOT = Path(__file__).parents[2]


def test_a_finished_run_is_played_again_here(tmp_path):
    words = "agent=random", "habit_level=none", "limit=1", "pictures=0", "workers=0", "progress=false"
    Evaluation(eval_config(*words) | {"out": str(tmp_path)}, tmp_path).play()
    stored = tmp_path / "config.yaml"
    assert "runner" in stored.read_text()
    assert "runner" not in configuration_of(tmp_path, {}, {})


def test_the_address_of_a_collector_is_said_again():
    config = train_config("agent=vtn", "learner=ppo", "collector=ray", "collector.address=far.away:6379")
    assert has_to_be_said("collector.address")
    assert has_to_be_said("runner.address")
    with pytest.raises(ConfigError, match=r"give \+\+collector\.address="):
        checked(config, "config.yaml", ("learner",), {}, "++")
    said = checked(config, "config.yaml", ("learner",), {"collector.address": "auto"}, "++")
    assert said["learner"]["collector"]["address"] == "auto"


def test_a_run_that_goes_on_is_labelled_where_its_command_says(tmp_path):
    def chosen(*words):
        with initialize_config_dir(str(ROOT / "configs"), version_base="1.3"):
            return chosen_run(compose("train", overrides=list(words)), words, None)

    first = chosen("agent=habit_policy", "learner=foresight", f"out={tmp_path}", "runner=ray")
    assert first.config["runner"]["_target_"] == "ucon.cluster.runner.RayRunner"
    from omegaconf import OmegaConf

    (tmp_path / "config.yaml").write_text(OmegaConf.to_yaml(OmegaConf.create(first.config)))
    again = chosen(f"resume={tmp_path}")
    assert again.config["runner"]["_target_"] == "ucon.evaluation.playing.runner.LocalRunner"
    there = chosen(f"resume={tmp_path}", "runner=ray", "runner.address=auto")
    assert there.config["runner"]["address"] == "auto"
