"""Questions of a batch go through the network together, and each is answered as if it were asked alone."""

import random
import time
from contextlib import contextmanager

import numpy as np
import pytest

from tests.language.plain import PlainPasses, normal
from tests.language.tiny_models import HABITS, INJECTED, NAMES, picture, question, save_causal, save_llava, save_mllama
from ucon.language.models.causal_lm import CausalModel
from ucon.language.models.vision_lm import VisionModel

#: One unit of the fourth decimal, to which scores are rounded.
NEAR = 1.01e-4
SIX = (*NAMES, "90", "-90")
TOO_LONG = question(names=("sofa", "desk " * 1200))
#: Fills the whole window after habits are dropped.
FULL = question([f"{habit} ({i})" for i, habit in enumerate(HABITS * 20)], names=NAMES[:2])
MIXED = (
    question(),
    question(target="key"),
    question(HABITS[:2], names=SIX),
    TOO_LONG,
    question(()),
    question(names=NAMES[:1]),
    FULL,
    question(INJECTED, names=("the mug rack beside the sofa bed on which nobody sits", "desk")),
    question(names=SIX, target="cup"),
)
PADDED = {
    "llama": {},
    "qwen": {"kind": "Qwen2Config"},
    "learned positions": {"kind": "GPT2Config"},  # positions end with the window
    "yarn": {"rope_parameters": {"rope_type": "yarn", "rope_theta": 1e4, "factor": 4.0}},
    "experts": {"kind": "MixtralConfig", "num_local_experts": 4, "sliding_window": None},
}
ALONE = {
    "sliding window": {"kind": "MistralConfig", "sliding_window": 16},
    "some layers slide": {
        "kind": "Gemma3TextConfig",
        "sliding_window": 16,
        "layer_types": ["sliding_attention", "full_attention"],
        "head_dim": 8,
    },
    "recurrent": {"kind": "Lfm2Config", "layer_types": ["conv", "full_attention"]},
    "frequencies by length": {"rope_parameters": {"rope_type": "dynamic", "rope_theta": 1e4, "factor": 2.0}},
}


@pytest.fixture(scope="module")
def llama(tmp_path_factory):
    return str(save_causal(tmp_path_factory.mktemp("tiny") / "llama"))


@pytest.fixture(scope="module")
def wanted(llama):
    return alone(CausalModel(llama, batch_size=1))


@contextmanager
def forwards(model):
    """Context manager: the number of rows of each forward pass inside it."""
    rows = []
    hook = model._model.register_forward_pre_hook(
        lambda _, args, told: rows.append(len(told["input_ids"])), with_kwargs=True
    )
    yield rows
    hook.remove()


def same(a, b):
    """Assert that two lists of answers agree up to rounding."""
    for one, other in zip(a, b, strict=True):
        assert one.scores == pytest.approx(other.scores, abs=NEAR)
        told = [(x.choice, x.failure, x.prompt_tokens, x.dropped) for x in (one, other)]
        assert told[0] == told[1]
    return True


def alone(model, asked=MIXED):
    return [model.answer([one])[0] for one in asked]


@pytest.mark.parametrize("options", PADDED.values(), ids=PADDED)
def test_questions_read_together_are_answered_as_by_plain_passes(tmp_path, options):
    folder = str(save_causal(tmp_path / "m", **options))
    model, plain = CausalModel(folder, batch_size=5), PlainPasses(folder)
    answers = model.answer(MIXED)
    assert model._together
    for asked, answer in zip(MIXED, answers, strict=True):
        if asked not in (TOO_LONG, FULL):
            assert answer.scores == pytest.approx(normal(plain(asked)[0]), abs=2e-4)
    assert [answer.failure for answer in answers] == ["too long" if one is TOO_LONG else "" for one in MIXED]
    assert answers[MIXED.index(FULL)].dropped > 0
    assert same(answers, alone(CausalModel(folder, batch_size=1)))


@pytest.mark.parametrize("options", ALONE.values(), ids=ALONE)
def test_a_cache_that_cannot_be_padded_is_read_one_question_at_a_time(tmp_path, options):
    folder = str(save_causal(tmp_path / "m", **options))
    model, plain = CausalModel(folder), PlainPasses(folder)
    assert not model._together
    for asked, answer in zip(MIXED[:3], model.answer(MIXED[:3]), strict=True):
        assert answer.scores == pytest.approx(normal(plain(asked)[0]), abs=2e-4)
    assert [a.scores for a in model.answer(MIXED)] == [a.scores for a in alone(model)]


@pytest.mark.parametrize(("batch", "prefixes"), [(1, 0), (3, 1), (3, 20), (8, 0), (100, 1), (100, 20)])
def test_neither_batch_nor_prefixes_change_an_answer(llama, wanted, batch, prefixes):
    model = CausalModel(llama, batch_size=batch, prefixes=prefixes)
    assert same(model.answer(MIXED), wanted)
    assert same(model.answer(MIXED), wanted)  # now with cached system parts
    assert len(model._prefixes) <= prefixes


def test_what_is_asked_beside_changes_no_answer(llama, wanted):
    model = CausalModel(llama)
    for seed in range(5):
        draw = random.Random(seed)
        chosen = draw.choices(range(len(MIXED)), k=draw.randint(1, 12))
        assert same(model.answer([MIXED[i] for i in chosen]), [wanted[i] for i in chosen])


def test_the_mean_over_tokens(llama):
    wanted = alone(CausalModel(llama, batch_size=1, normalise=True))
    assert same(CausalModel(llama, normalise=True).answer(MIXED), wanted)


def test_alone_means_the_same_digits_whatever_else_is_asked(llama, wanted):
    answers = CausalModel(llama, batch_size=1).answer(MIXED)
    assert [answer.scores for answer in answers] == [answer.scores for answer in wanted]


@pytest.mark.parametrize(
    ("batch", "systems", "expected"),
    [
        (8, 1, [1, 8]),
        (8, 8, [8, 8]),
        (3, 1, [1, 3, 3, 2]),
        (1, 1, [1, *[1] * 8]),
    ],
)
def test_rows_of_all_questions_share_forward_passes(llama, batch, systems, expected):
    """First the system parts, then the rest of each prompt with all its options after it."""
    habits = [(f"Key {n % systems} is on the desk.", *HABITS[: n % systems]) for n in range(8)]
    asked = [question(told, SIX, target=f"wallet {n}") for n, told in enumerate(habits)]
    assert len({one.system for one in asked}) == systems
    model = CausalModel(llama, batch_size=batch)
    with forwards(model) as rows:
        answers = model.answer(asked)
    assert rows == expected
    assert all(answer.choice >= 0 for answer in answers)


def test_nothing_is_read_for_questions_that_are_too_long(llama):
    model = CausalModel(llama)
    with forwards(model) as rows:
        answers = model.answer([TOO_LONG, TOO_LONG])
        assert model.answer([]) == []
    assert rows == []
    assert all(answer.failure == "too long" and answer.seconds > 0 for answer in answers)


@pytest.mark.timed
def test_seconds_add_up_to_the_wall_time(llama):
    start = time.perf_counter()
    answers = CausalModel(llama).answer(MIXED)
    whole = time.perf_counter() - start
    assert all(answer.seconds > 0 for answer in answers)
    assert 0.8 * whole < sum(answer.seconds for answer in answers) <= whole


@pytest.mark.parametrize("save", [save_mllama, save_llava])
def test_questions_with_images_of_the_same_sizes_share_forward_passes(tmp_path, save):
    folder = str(save(tmp_path / "m"))
    one, two = [picture(1)], [picture(2), picture(3)]
    asked = [
        question(images=one),
        question(HABITS[:1], NAMES[:3], [picture(4)]),
        question(images=two),
        question(names=("sofa", "desk " * 2400), images=one),
        question(names=NAMES[:1], images=[picture(5)]),
        question((), NAMES[:2], [picture(6, 30, 30)]),
        question(INJECTED),
        question(HABITS[:2], NAMES[1:]),
    ]
    wanted = alone(VisionModel(folder, batch_size=1), asked)
    model = VisionModel(folder, batch_size=8)
    with forwards(model) as rows:
        answers = model.answer(asked)
    assert rows == [8, 4, 2, 7]  # one image: 4 + 3 + 1 options, two: 4, a larger one: 2, none: 4 + 3
    assert same(answers, wanted)
    assert [answer.failure for answer in answers] == ["", "", "", "too long", "", "", "", ""]
    for seed in range(3):
        order = np.random.default_rng(seed).permutation(len(asked))
        model = VisionModel(folder, batch_size=seed + 2)
        assert same(model.answer([asked[i] for i in order]), [wanted[i] for i in order])
