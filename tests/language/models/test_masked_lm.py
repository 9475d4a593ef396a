"""The masked model on a tiny RoBERTa: batches and caching give the scores of masked copies read one by one."""

import numpy as np
import pytest
import torch
import transformers

from tests.language.tiny_models import HABITS, INJECTED, NAMES, question, save_causal, save_masked
from ucon.core.errors import ConfigError, DataError
from ucon.language.models.masked_lm import MaskedModel, made_cloze


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return str(save_masked(tmp_path_factory.mktemp("tiny") / "tiny-roberta"))


@pytest.fixture(scope="module")
def plain(folder):
    """Mean log-probability of a name's tokens in a sentence, each masked in its own copy."""
    tokenizer = transformers.AutoTokenizer.from_pretrained(folder)
    network = transformers.AutoModelForMaskedLM.from_pretrained(folder).eval()

    def score(before, name, after):
        left = tokenizer(before, add_special_tokens=False)["input_ids"]
        own = tokenizer(f" {name}", add_special_tokens=False)["input_ids"]
        right = tokenizer(after, add_special_tokens=False)["input_ids"]
        ids = [tokenizer.bos_token_id, *left, *own, *right, tokenizer.eos_token_id]
        found = []
        for i in range(len(own)):
            place = 1 + len(left) + i
            masked = [*ids[:place], tokenizer.mask_token_id, *ids[place + 1 :]]
            with torch.no_grad():
                found.append(float(network(torch.tensor([masked])).logits[0, place].log_softmax(-1)[own[i]]))
        return np.mean(found)

    return score


def test_it_says_what_one_copy_after_the_other_says(folder, plain):
    for habits in (HABITS, HABITS[:1], ()):
        before = " ".join([*habits, "The wallet is near the"])
        scores = np.array([plain(before, name, ".") for name in NAMES])
        for batch in (1, 2, 16):
            (answer,) = MaskedModel(folder, batch_size=batch).answer([question(habits)])
            assert answer.scores == pytest.approx(scores - np.logaddexp.reduce(scores), abs=2e-4)
            assert answer.choice == int(scores.argmax())


def test_the_batch_changes_nothing(folder):
    asked = [question(), question(HABITS[:2]), question(INJECTED), question(()), question(names=NAMES[:1])]
    together = MaskedModel(folder).answer(asked)
    for one, answer in zip(asked, together, strict=True):
        alone = MaskedModel(folder).answer([one])[0]
        assert answer.scores == pytest.approx(alone.scores, abs=1e-4)
    assert together[-1].scores == (0.0,)


def test_the_same_text_is_computed_once(folder):
    model = MaskedModel(folder)
    first = model.answer([question()])[0]
    model._computed = None
    assert model.answer([question()])[0].scores == first.scores


def test_whole_habits_up_to_the_budget(folder):
    many = HABITS * 30
    (answer,) = MaskedModel(folder, budget_tokens=60).answer([question(many)])
    kept = len(many) - answer.dropped
    assert 1 <= kept <= 4
    assert answer.scores == MaskedModel(folder).answer([question(many[:kept])])[0].scores
    (wide,) = MaskedModel(folder, budget_tokens=10_000).answer([question(many)])
    assert wide.dropped > 0
    assert wide.prompt_tokens <= 512
    assert MaskedModel(folder, budget_tokens=0).answer([question(many)])[0].dropped == len(many)


def test_a_cloze_beyond_the_window_is_no_answer(tmp_path):
    model = MaskedModel(str(save_masked(tmp_path / "short", positions=12)))
    (answer,) = model.answer([question()])
    assert (answer.choice, answer.failure) == (-1, "too long")


def test_without_a_cloze_one_is_made(folder):
    asked = question(cloze=False)
    assert made_cloze(asked) == "Of sofa, sofa bed, desk and mug rack, the wallet is most likely at the {}."
    assert made_cloze(question(names=("a{}b",))) == "Of ab, the wallet is most likely at the {}."
    (answer,) = MaskedModel(folder).answer([asked])
    assert answer.choice >= 0
    assert np.exp(answer.scores).sum() == pytest.approx(1, abs=1e-3)


def test_errors_say_what_to_do(folder, tmp_path):
    with pytest.raises(DataError, match=r"no model of that name on this machine.*hf download"):
        MaskedModel("no-such/model").check()
    with pytest.raises(ConfigError, match="batch_size=0"):
        MaskedModel(folder, batch_size=0)
    with pytest.raises(DataError, match=r"cannot be loaded|mask token"):
        MaskedModel(str(save_causal(tmp_path / "llama"))).answer([question()])
    assert MaskedModel(folder).check() is None
    assert MaskedModel(folder).name == "masked (tiny-roberta)"
