"""Optional frozen features of the end-to-end habit policy: real loading code, on a tiny random model."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
import torch
import transformers
from hydra import compose, initialize_config_dir
from omegaconf import OmegaConf

from models.habit_policy_e2e import HabitPolicyE2E
from models.nets.end_to_end.advice import Advisor
from models.nets.vision.clip_eye import ClipEye
from tests.language.tiny_models import save_causal
from ucon.configuration.wiring import Factory
from ucon.core.errors import DataError
from ucon.envs.ucon_env import UcONEnv
from ucon.language.choice import Answer
from ucon.language.models.causal_lm import CausalModel
from ucon.language.models.encoder import EncoderModel

CONFIGS = Path(__file__).resolve().parents[3] / "configs"
AGENT = "habit_policy_e2e"
#: Optional parts of the agent, by name, with the options given in the comments of their files.
SPELT_OUT = {
    file.stem: found[1].split()
    for file in sorted((CONFIGS / "part").glob("*.yaml"))
    if (found := re.search(rf"^#\s+agent={AGENT} (part=.*)$", file.read_text(), re.MULTILINE))
}


def clip_folder(folder: Path) -> Path:
    torch.manual_seed(0)
    config = transformers.CLIPVisionConfig(
        hidden_size=32, intermediate_size=32, num_hidden_layers=1, num_attention_heads=2, image_size=32, patch_size=8,
        projection_dim=24,
    )  # fmt: skip
    transformers.CLIPVisionModelWithProjection(config).save_pretrained(folder)
    return folder


@pytest.fixture(scope="module")
def first() -> tuple[dict, dict]:
    env = UcONEnv("mini", habit_level="gt", detector=True)
    obs, info = env.reset(options={"episode": 1})
    env.close()
    return obs, info


def played(policy: HabitPolicyE2E, first: tuple[dict, dict], stored: bool = False) -> torch.Tensor:
    frames = {name: torch.as_tensor(np.array(a))[None, None] for name, a in policy.frame(*first).items()}
    context = {name: torch.as_tensor(np.array(a))[None] for name, a in policy.context(first[1]).items()}
    with torch.no_grad():
        torch.nn.init.normal_(policy.choose[-1].weight, std=0.1, generator=torch.Generator().manual_seed(0))
        return policy(policy.features(frames) if stored else frames, context, policy.initial_state(1)).logits


def test_clip_is_read_and_may_be_computed_beforehand(tmp_path, first):
    policy = HabitPolicyE2E(clip=ClipEye(str(clip_folder(tmp_path / "clip"))))
    policy.check()
    logits = played(policy, first)
    assert torch.isfinite(logits).all()
    assert torch.allclose(logits, played(policy, first, stored=True), atol=1e-4)
    assert not [name for name, _ in policy.named_parameters() if "clip" in name]
    assert policy.arguments["clip"].startswith("clip ")
    assert policy.fingerprint()
    dark = ({**first[0], "rgb": np.zeros_like(first[0]["rgb"])}, first[1])
    vectors = [policy.features({"rgb": torch.as_tensor(o["rgb"])[None]})["clip"] for o, _ in (first, dark)]
    assert vectors[0].shape == (1, 24)
    assert vectors[0].dtype == torch.float16
    assert not torch.allclose(vectors[0], vectors[1], atol=1e-2)


def test_missing_clip_is_one_line(tmp_path):
    with pytest.raises(DataError, match=r"agent\.policy\.clip\.path") as error:
        ClipEye(str(tmp_path / "none")).check()
    assert "\n" not in str(error.value)


def test_a_language_models_choice_is_a_belief(first):
    advisor = Advisor(EncoderModel())
    policy = HabitPolicyE2E(advisor=advisor)
    known = ("bed", "sink", "stove")
    p = advisor.advice(first[1], known)
    assert p.shape == (3,)
    assert abs(p.sum() - 1) < 1e-3
    assert not np.allclose(p, 1 / 3, atol=1e-3)
    advised = policy.context(first[1])["advice"]
    assert advised.max() == 1.0
    assert (advised > 0).sum() > 50
    assert torch.isfinite(played(policy, first)).all()


def test_a_chat_model_on_this_machine_advises(first, tmp_path):
    """It is asked in two orders of all anchors that the reader knows; its advice is repeatable, its weights frozen."""
    model = CausalModel(str(save_causal(tmp_path / "llama", positions=8192)), orders=2)
    policy = HabitPolicyE2E(advisor=Advisor(model))
    policy.check()
    advised = policy.context(first[1])["advice"]
    assert advised.max() == 1.0
    assert (policy.context(first[1])["advice"] == advised).all()
    p = Advisor(model).advice(first[1], ("bed", "sink", "stove"))
    assert p.sum() == pytest.approx(1.0, abs=1e-3)
    assert len(set(p.tolist())) == 3
    assert policy.arguments["advisor"] == "causal (llama, two orders)"
    assert policy.fingerprint() != HabitPolicyE2E().fingerprint()
    assert not [name for name, _ in policy.named_parameters() if "advis" in name]
    assert torch.isfinite(played(policy, first)).all()


class Silent:
    name, gives_scores = "silent", False

    def answer(self, questions):
        return [Answer(-1, failure="server") for _ in questions]


def test_no_answer_is_no_advice(first):
    p = Advisor(Silent()).advice(first[1], ("bed", "sink"))
    assert p.tolist() == [0.5, 0.5]


def test_retrieval_scores_are_given_only_when_asked_for(first):
    with_, without = (HabitPolicyE2E(scores=s).context(first[1])["habit_features"][:, 3] for s in (True, False))
    assert float(np.abs(with_).max()) > 0.05
    assert not without.any()


@pytest.mark.parametrize("program", ["train", "eval"])
@pytest.mark.parametrize("part", SPELT_OUT)
def test_parts_work_as_they_are_spelt_out(program: str, part: str, tmp_path: Path) -> None:
    words = [word for word in SPELT_OUT[part] if not word.startswith("language")]  # the encoder needs no folder
    folder = str(clip_folder(tmp_path / "clip"))
    overrides = [f"agent={AGENT}", *(word.replace("FOLDER", folder) for word in words)]
    with initialize_config_dir(str(CONFIGS), version_base="1.3"):
        config = OmegaConf.to_container(compose(program, overrides).agent.policy, resolve=True)
    policy = Factory(config)()
    policy.check()
    assert policy.arguments[part]


def test_there_are_parts_spelt_out() -> None:
    assert len(SPELT_OUT) >= 2
