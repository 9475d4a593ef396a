"""The causal model on a tiny Llama: with cache and batches, it gives the scores of plain forward passes."""

import json
import shutil

import numpy as np
import pytest
import torch

from tests.language.plain import PlainPasses, normal
from tests.language.tiny_models import (
    HABITS,
    INJECTED,
    NAMES,
    NO_SYSTEM,
    SILENT_SYSTEM,
    question,
    save_causal,
)
from ucon.core.errors import ConfigError, DataError
from ucon.language.models.causal_lm import CausalModel
from ucon.language.prompt import habits_in


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return str(save_causal(tmp_path_factory.mktemp("tiny") / "tiny-llama"))


@pytest.fixture(scope="module")
def plain(folder):
    return PlainPasses(folder)


def test_it_says_what_plain_forward_passes_say(folder, plain):
    model = CausalModel(folder)
    for asked in (question(), question(names=NAMES[:1]), question(HABITS[:1], names=("90", "-90")), question(())):
        (answer,) = model.answer([asked])
        totals, _, tokens = plain(asked)
        assert answer.scores == pytest.approx(normal(totals), abs=2e-4)
        assert answer.choice == int(totals.argmax())
        assert (answer.prompt_tokens, answer.dropped, answer.failure) == (tokens, 0, "")


def test_the_mean_over_tokens(folder, plain):
    asked = question()
    totals, lengths, _ = plain(asked)
    (answer,) = CausalModel(folder, normalise=True).answer([asked])
    assert answer.scores == pytest.approx(normal(totals / lengths), abs=2e-4)


def test_prefixes_and_batches_change_nothing(folder):
    asked = [question(names=names, target=target) for target in ("wallet", "key") for names in (NAMES, NAMES[1:])]
    asked += [question(HABITS[:2]), question(()), question(INJECTED)]
    together = CausalModel(folder).answer(asked)
    for options in ({"prefixes": 0}, {"prefixes": 1}, {"batch_size": 1}):
        alone = [CausalModel(folder, **options).answer([one])[0] for one in asked]
        for a, b in zip(together, alone, strict=True):
            assert a.scores == pytest.approx(b.scores, abs=1e-4)
            assert a.choice == b.choice


def test_the_system_part_is_read_once_an_episode(folder):
    model = CausalModel(folder, prefixes=2)
    lengths = []
    model._model.register_forward_pre_hook(
        lambda _, args, told: lengths.extend([told["input_ids"].shape[1]] * len(told["input_ids"])), with_kwargs=True
    )
    model.answer([question(target=target) for target in ("wallet", "key", "cup")])
    whole = max(lengths)
    assert sum(n > whole / 2 for n in lengths) == 1
    assert len(model._prefixes) == 1
    model.answer([question(HABITS[:n]) for n in (1, 2, 3)])
    assert len(model._prefixes) == 2


@pytest.mark.parametrize("template", [NO_SYSTEM, SILENT_SYSTEM])
def test_without_a_system_role_the_users_message_holds_it(tmp_path, template, folder):
    model = CausalModel(str(save_causal(tmp_path / "m", template)))
    asked = question()
    assert model.answer([asked])[0].choice >= 0
    folded = model._template.render(asked.system, asked.situation)
    assert folded == f"<s><|user|>\n{asked.system}\n\n{asked.situation}<|end|>\n<|assistant|>\n"


def test_whole_habits_are_dropped_from_the_end(folder, plain):
    many = [f"{habit} ({i})" for i, habit in enumerate(HABITS * 20)]
    asked = question(many)
    model = CausalModel(folder)
    (answer,) = model.answer([asked])
    assert 0 < answer.dropped < len(many)
    kept = question(many[: len(many) - answer.dropped])
    assert answer.scores == pytest.approx(normal(plain(kept)[0]), abs=2e-4)
    room = 1024 - 1024 // 16 + len(model._ids(asked.situation))  # a sixteenth is reserved for the user's message
    assert answer.prompt_tokens <= room < plain(question(many[: len(many) - answer.dropped + 1]))[2] + 4
    assert habits_in(asked.system) == len(many)
    (shorter,) = CausalModel(folder, window=200).answer([asked])
    assert shorter.dropped > answer.dropped
    assert shorter.choice >= 0


def test_all_questions_of_an_episode_drop_the_same_habits_and_share_the_rest(folder):
    """If the window is too short, a longer message must not change the part read before it."""
    many = [f"{habit} ({i})" for i, habit in enumerate(HABITS * 20)]
    model = CausalModel(folder, prefixes=4)
    answers = model.answer([question(many, NAMES[:n]) for n in range(1, len(NAMES) + 1)])
    assert len({answer.dropped for answer in answers}) == len(model._prefixes) == 1
    assert answers[0].dropped > 0


def test_a_question_beyond_the_window_is_no_answer(folder):
    (answer,) = CausalModel(folder, window=20).answer([question()])
    assert (answer.choice, answer.failure) == (-1, "too long")


def test_half_precision_is_near(folder):
    whole, half = (CausalModel(folder, dtype=dtype).answer([question()])[0] for dtype in ("float32", "bfloat16"))
    assert half.choice == whole.choice
    assert np.exp(half.scores) == pytest.approx(np.exp(whole.scores), abs=0.1)


def test_errors_say_what_to_do(folder, tmp_path):
    with pytest.raises(DataError, match=r"no such folder.*nothing is downloaded.*language\.path") as caught:
        CausalModel(str(tmp_path / "nowhere")).check()
    assert "\n" not in str(caught.value)
    (tmp_path / "empty").mkdir()
    with pytest.raises(DataError, match=r"no config\.json, no weights"):
        CausalModel(str(tmp_path / "empty")).answer([question()])
    with pytest.raises(ConfigError, match=r"int8 needs.*bfloat16"):
        CausalModel(folder, dtype="int8").check()
    with pytest.raises(ConfigError, match="unknown dtype 'float3'"):
        CausalModel(folder, dtype="float3")
    with pytest.raises(ConfigError, match=r"language\.device=gpu: expected cpu"):
        CausalModel(folder, device="gpu").check()
    with pytest.raises(ConfigError, match=r"give language\.path"):
        CausalModel("")
    with pytest.raises(ConfigError, match="batch_size=0"):
        CausalModel(folder, batch_size=0)
    with pytest.raises(DataError, match="no chat template"):
        CausalModel(str(save_causal(tmp_path / "base", ""))).answer([question()])
    broken = save_causal(tmp_path / "broken")
    (broken / "model.safetensors").write_bytes(b"\x00" * 100)
    with pytest.raises(DataError, match="cannot be loaded"):
        CausalModel(str(broken)).answer([question()])
    assert CausalModel(folder).check() is None


def test_what_does_not_fit_into_memory_is_refused_before_it_is_read(folder, tmp_path):
    """The header of the file names 40 TB of weights."""
    huge = shutil.copytree(folder, tmp_path / "huge")
    header = json.dumps({"w": {"dtype": "F32", "shape": [10**7, 10**6], "data_offsets": [0, 4 * 10**13]}}).encode()
    (huge / "model.safetensors").write_bytes(len(header).to_bytes(8, "little") + header)
    with pytest.raises(
        ConfigError, match=r"its weights take 40000\.0 GB in float32, \d+\.\d GB of memory are free; give"
    ):
        CausalModel(str(huge)).check()
    with pytest.raises(ConfigError, match=r"20000\.0 GB in bfloat16") as caught:
        CausalModel(str(huge), dtype="bfloat16").answer([question()])
    assert "\n" not in str(caught.value)


def test_a_window_beyond_the_models_own_is_refused(folder):
    with pytest.raises(ConfigError, match=r"language\.window=4096: tiny-llama reads 1024 tokens; give that or less"):
        CausalModel(folder, window=4096).answer([question()])
    assert CausalModel(folder, window=1024).answer([question()])[0].choice >= 0


def test_no_such_gpu(folder):
    if torch.cuda.is_available():
        pytest.skip("there is one")
    with pytest.raises(ConfigError, match="no such GPU"):
        CausalModel(folder, device="cuda").check()


def test_its_name_is_that_of_the_weights(folder):
    assert CausalModel(folder).name == "causal (tiny-llama)"


def test_a_folders_own_code_is_not_run(folder, tmp_path):
    """Code that ``auto_map`` names is not run, and the user is not asked whether to trust it."""
    brought = shutil.copytree(folder, tmp_path / "brought")
    left = tmp_path / "canary"
    (brought / "mine.py").write_text(f"open({str(left)!r}, 'w')\nclass Model: ...\nclass Config: ...\n")
    described = json.loads((brought / "config.json").read_text())
    names = {"AutoConfig": "mine.Config", "AutoModelForCausalLM": "mine.Model"}
    described |= {"auto_map": names, "model_type": "mine", "architectures": ["Model"]}
    (brought / "config.json").write_text(json.dumps(described))
    with pytest.raises(DataError, match="cannot be loaded") as caught:
        CausalModel(str(brought)).answer([question()])
    assert "\n" not in str(caught.value)
    assert not left.exists()
