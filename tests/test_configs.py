"""Every file under configs/ composes, and the parts it describes can be built."""

import inspect
import re
from pathlib import Path

import pytest
from hydra import compose, initialize_config_dir
from hydra.utils import get_class
from omegaconf import OmegaConf

from ucon.configuration.arguments import arguments_of
from ucon.configuration.wiring import Factory
from ucon.core.errors import ConfigError, UconError
from ucon.evaluation.figures.report import run_hashes
from ucon.language.choice import LanguageModel, sees_images
from ucon.lives.making.plans import LIFE_SETS
from ucon.programs.training import learner_name
from ucon.retrieval import Retriever
from ucon.retrieval.levels import check_level
from ucon.task.agent import Agent

CONFIGS = Path(__file__).parents[1] / "configs"
OPTIONS = sorted((p.parent.name, p.stem) for p in CONFIGS.glob("*/*.yaml"))
MANDATORY = {
    ("habits", "official"): "habits.path=somewhere",
    ("habits", "folder"): "habits.path=somewhere",
    ("part", "clip"): "agent.policy.clip.path=somewhere",
    ("part", "detr_tokens"): "agent.policy.tokens.path=somewhere",
    ("part", "clip_goal"): "agent.policy.goal.path=somewhere",
}


#: Groups that belong only to ``train.yaml``.
TRAINING = {"learner", "collector", "budget"}


def composed(*overrides: str, root: str = "eval") -> dict:
    with initialize_config_dir(str(CONFIGS), version_base="1.3"):
        config = compose(root, overrides=[*overrides, "out=runs/test"])
    return OmegaConf.to_container(config, resolve=True, throw_on_missing=True)


#: Learners of an agent's policy.
OF_POLICIES = [n for g, n in OPTIONS if g == "learner" and n not in ("belief", "retriever")]


@pytest.mark.parametrize(("group", "name"), [(g, n) for g, n in OPTIONS if g in TRAINING | {"habits"}])
def test_every_option_of_training_composes(group, name):
    extra = [MANDATORY.get((group, name)), "agent=vtn" if group == "learner" and name in OF_POLICIES else None]
    config = composed(f"{group}={name}", *(word for word in extra if word), root="train")
    assert config["training"]["steps"] >= 1
    assert config["learner"]["_target_"].startswith("ucon.learning.")
    assert callable(get_class(config["learner"]["_target_"]))


@pytest.mark.parametrize("name", [n for g, n in OPTIONS if g == "learner"])
def test_every_learner_begins_with_the_weights_of_another_run_by_one_word(name):
    learner = composed(f"learner={name}", *(["agent=vtn"] if name in OF_POLICIES else []), root="train")["learner"]
    assert learner["initial"] is None
    assert "initial" in arguments_of(learner["_target_"])


@pytest.mark.parametrize("name", [n for g, n in OPTIONS if g == "learner"])
def test_progress_calls_a_learner_as_its_option_does(name):
    learner = composed(f"learner={name}", *(["agent=vtn"] if name in OF_POLICIES else []), root="train")["learner"]
    assert learner_name(learner) == name


@pytest.mark.parametrize(("group", "name"), [(g, n) for g, n in OPTIONS if g not in TRAINING])
def test_every_option_composes(group, name):
    extra = MANDATORY.get((group, name))
    config = composed(f"{group}={name}", *([extra] if extra else []))
    assert config["env"]["_target_"].endswith((".UcONEnv", ".UcONResidentEnv"))
    assert config["env"]["habit_level"] == config["habit_level"]["name"]


@pytest.mark.parametrize("name", [name for group, name in OPTIONS if group == "agent"])
def test_every_agent_can_be_built(name):
    config = composed(f"agent={name}")["agent"]
    if config.get("inputs") == "images":  # refused with the default model, which takes no images
        config = composed(f"agent={name}", "language=vision_lm")["agent"]
    agent = Factory(config)()
    assert isinstance(agent.name, str)
    assert callable(agent.reset)
    assert callable(agent.act)
    assert Agent


@pytest.mark.parametrize(
    ("target", "message"),
    [
        ("models.agents.lgx.LGXAgnt", "models.agents.lgx has no LGXAgnt; see its file in configs/"),
        ("models.agents.lxg.LGXAgent", "there is no module models.agents.lxg; see its file in configs/"),
    ],
)
def test_a_target_that_does_not_exist_is_named(target, message):
    with pytest.raises(ConfigError) as caught:
        Factory({"_target_": target})()
    assert str(caught.value) == f"{target}: {message}"


@pytest.mark.parametrize("name", [name for group, name in OPTIONS if group == "habit_level"])
def test_every_habit_level_is_one(name):
    check_level(composed(f"habit_level={name}")["habit_level"]["name"])


ASKING = [name for group, name in OPTIONS if group == "agent" and "language" in composed(f"agent={name}")["agent"]]


@pytest.mark.parametrize("language", [name for group, name in OPTIONS if group == "language"])
@pytest.mark.parametrize("name", ASKING)
def test_agents_are_built_with_every_language_model(name, language):
    """Nothing is loaded; an agent refuses, in one line, a model without the scores or image input that it needs."""
    config = composed(f"agent={name}", f"language={language}")
    model = Factory(config["language"])()
    if name == "l3mvn" and not model.gives_scores:
        with pytest.raises(ConfigError, match="gives none; choose language="):
            Factory(config["agent"])()
        return
    if config["agent"].get("inputs") == "images" and not sees_images(model):
        with pytest.raises(ConfigError, match="sees none; choose language=vision_lm") as caught:
            Factory(config["agent"])()
        assert "\n" not in str(caught.value)
        return
    agent = Factory(config["agent"])()
    assert agent.language.name == model.name
    assert not [key for key in vars(agent.language) if key in ("_model", "_tokenizer", "_processor")]


def test_models_that_see_are_known():
    seeing = {
        n for g, n in OPTIONS if g == "language" and sees_images(Factory(composed(f"language={n}")["language"])())
    }
    assert {"vision_lm", "chat_api"} <= seeing
    assert not {"encoder", "masked_lm", "causal_lm"} & seeing


def test_agents_that_ask_are_known():
    assert {"lgx", "pixelnav", "pixelnav_images", "l3mvn"} <= set(ASKING)


def test_what_the_evaluation_lists_is_there():
    """All options named in the comments exist; new files need not be named there."""
    defaults = (CONFIGS / "eval.yaml").read_text().partition("defaults:")[2].partition("- override")[0]
    listed = set(re.findall(r"\b[a-z]+[\w]*_\w+\b", " ".join(re.findall(r"#(.*)", defaults))))
    assert listed <= {name for _, name in OPTIONS} | set(LIFE_SETS)
    assert {"pixelnav_images", "masked_lm", "yolo_world"} <= listed


@pytest.mark.parametrize(
    "text", [CONFIGS / "train.yaml", CONFIGS.parent / "docs" / "commands.md"], ids=lambda p: p.name
)
def test_every_learner_is_listed(text):
    listed = set(re.findall(r"\w+", text.read_text()))
    assert {name for group, name in OPTIONS if group == "learner"} <= listed


@pytest.mark.parametrize("name", [name for group, name in OPTIONS if group == "retriever"])
def test_every_retriever_can_be_built(name):
    retriever: Retriever = Factory(composed(f"retriever={name}")["retriever"])()
    assert callable(retriever.rank)


@pytest.mark.parametrize("name", [name for group, name in OPTIONS if group == "language"])
def test_every_language_model_can_be_built(name):
    model = Factory(composed(f"language={name}")["language"])()
    assert isinstance(model, LanguageModel)
    assert model.name
    assert isinstance(model.gives_scores, bool)
    assert not [key for key in vars(model) if key in ("_model", "_tokenizer", "_processor")]  # nothing is loaded yet


def test_the_encoders_figures_stand_in_one_place_as_in_the_other():
    from ucon.language.models.encoder import EncoderWeights
    from ucon.language.models.keeping import LocationWeights

    config = composed()["language"]
    for part, made in (("weights", EncoderWeights), ("keeping", LocationWeights)):
        assert made(**{key: value for key, value in config[part].items() if key != "_target_"}) == made()


@pytest.mark.parametrize("name", [name for group, name in OPTIONS if group == "detector"])
def test_every_detector_can_be_built_without_its_weights(name):
    config = composed(f"detector={name}")
    assert config["env"]["detector"] == config["detector"]
    env = Factory(config["env"])()
    detector = env._detector
    assert detector.name == name
    assert detector.needs_rgb == (name != "gt" and not name.startswith("noisy"))
    # Everything in the file is an argument of the detector.
    given = {key for key in config["detector"] if key != "_target_"}
    assert given <= set(inspect.signature(get_class(config["detector"]["_target_"])).parameters)
    env.close()


def test_the_detector_is_part_of_the_hash():
    hashes = {
        run_hashes(composed(*given), (), ())["config"]
        for given in ((), ("detector=noisy",), ("detector.min_pixels=5",))
    }
    assert len(hashes) == 3


def test_the_environment_can_be_built_and_reset():
    config = composed("habit_level=retrieval")
    env = Factory(config["env"])()
    _, info = env.reset(options={"episode": 0})
    assert 0 < len(info["habits"]) <= config["habit_level"]["top_p"]
    env.close()


def test_every_file_says_what_it_is():
    for path in CONFIGS.rglob("*.yaml"):
        assert path.read_text().lstrip().startswith("#"), f"{path}: starts with no comment"


TABLE_1 = [name for group, name in OPTIONS if group == "experiment" and name.startswith("table1_")]


def method_of(config: dict) -> str:
    """The module of the agent's network, or else of the agent."""
    target = config["agent"].get("policy", config["agent"])["_target_"]
    return target.split(".")[-2]


@pytest.mark.parametrize("name", TABLE_1)
def test_a_row_of_table_1_says_in_one_line_what_it_lacks(name, monkeypatch, tmp_path):
    """All rows play the test episodes; without weights or key they stop immediately."""
    monkeypatch.setattr("huggingface_hub.constants.HF_HUB_CACHE", str(tmp_path))
    monkeypatch.delenv("OPENAI_API_KEY", raising=False)
    config = composed(f"experiment={name}")
    assert config["episodes"] == "test"
    assert name.startswith(f"table1_{method_of(config)}")
    with pytest.raises(UconError) as error:
        Factory(config["agent"])().check()
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("name", TABLE_1)
def test_rows_of_large_models_load_one_copy(name):
    """One copy per worker would fill a GPU; this does not matter for RoBERTa and servers."""
    config = composed(f"experiment={name}")
    large = any(f".{kind}." in config["language"]["_target_"] for kind in ("causal_lm", "vision_lm"))
    large |= config["detector"]["_target_"].endswith("YoloWorldDetector")
    assert (config["workers"] == 1) == large
    text = (CONFIGS / "experiment" / f"{name}.yaml").read_text()
    if "policy" in config["agent"]:  # it reads no habits
        assert f"experiment={name} agent.checkpoint=" in text
        assert config["habit_level"]["name"] == "none"
        return
    assert f"experiment={name} habit_level=none," in text
    assert ("habit_level=none,full," in text) == (name != "table1_l3mvn_roberta_gt")  # the paper ran no full


def test_table_1_is_whole():
    """The rows of the paper, by method."""
    methods = [name.split("_")[1] for name in TABLE_1]
    assert {m: methods.count(m) for m in methods} == {"lgx": 3, "pixelnav": 2, "l3mvn": 1, "vtn": 1, "zson": 1}
