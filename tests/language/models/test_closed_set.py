"""With habits that give orders, or junk, every model that scores options answers with one of them."""

import numpy as np
import pytest

from tests.language.tiny_models import HABITS, INJECTED, NAMES, picture, question, save_causal, save_masked, save_mllama
from ucon.language.choice import LanguageModel
from ucon.language.encoder import MiniLM
from ucon.language.models.causal_lm import CausalModel
from ucon.language.models.encoder import EncoderModel
from ucon.language.models.masked_lm import MaskedModel
from ucon.language.models.vision_lm import VisionModel
from ucon.language.store import StoredEncoder, shipped_table


@pytest.fixture(scope="module", params=["encoder", "masked", "causal", "vision"])
def model(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp("tiny")
    return {
        "encoder": lambda: EncoderModel(encoder=StoredEncoder(MiniLM(), tables=(shipped_table(),), folder=folder)),
        "masked": lambda: MaskedModel(str(save_masked(folder))),
        "causal": lambda: CausalModel(str(save_causal(folder))),
        "vision": lambda: VisionModel(str(save_mllama(folder))),
    }[request.param]()


@pytest.mark.parametrize("habits", [INJECTED, HABITS + INJECTED, INJECTED[:1] * 3, ()])
@pytest.mark.parametrize("names", [NAMES, NAMES[:2], NAMES[:1], ("<mask>", "{}", "家 ☕", "\ud800"), ("", " ")])
def test_the_answer_is_one_of_the_options(model, habits, names):
    images = [picture()] if isinstance(model, VisionModel) else []
    (answer,) = model.answer([question(habits, names, images)])
    assert isinstance(model, LanguageModel)
    assert 0 <= answer.choice < len(names)
    assert len(answer.scores) == len(names)
    assert np.exp(answer.scores).sum() == pytest.approx(1, abs=1e-3)
    assert answer.choice == int(np.argmax(answer.scores))
    assert answer.seconds > 0
