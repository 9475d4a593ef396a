"""The vision model on tiny Mllama and LLaVA: it gives the scores of plain forward passes, and images matter."""

import numpy as np
import pytest
import torch
import transformers
from PIL import Image

from tests.language.tiny_models import (
    HABITS,
    INJECTED,
    NAMES,
    NO_SYSTEM,
    picture,
    question,
    save_causal,
    save_llava,
    save_mllama,
)
from ucon.core.errors import DataError
from ucon.language.models.vision_lm import VisionModel


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return str(save_mllama(tmp_path_factory.mktemp("tiny") / "tiny-mllama"))


def plain(folder, asked):
    """Log-probabilities of the options, one forward pass per option."""
    processor = transformers.AutoProcessor.from_pretrained(folder)
    network = transformers.AutoModelForImageTextToText.from_pretrained(folder).eval()
    content = [*({"type": "image"} for _ in asked.images), {"type": "text", "text": asked.situation}]
    messages = [{"role": "system", "content": asked.system}, {"role": "user", "content": content}]
    prompt = processor.apply_chat_template(messages, tokenize=False, add_generation_prompt=True)
    images = [[Image.fromarray(image) for image in asked.images]] if asked.images else None
    out = []
    for option in asked.options:
        own = processor.tokenizer(option.name, add_special_tokens=False)["input_ids"]
        inputs = processor(text=[prompt + option.name], images=images, return_tensors="pt", add_special_tokens=False)
        with torch.no_grad():
            said = network(**inputs).logits[0].log_softmax(-1)
        assert inputs["input_ids"][0, -len(own) :].tolist() == own
        total = sum(float(said[-len(own) - 1 + i, token]) for i, token in enumerate(own))
        out.append(total + float(said[-1, 5]))
    return np.array(out) - np.logaddexp.reduce(out)


@pytest.mark.parametrize("seen", [0, 1, 2])
def test_it_says_what_plain_forward_passes_say(folder, seen):
    asked = question(images=[picture(i, 20 + 9 * i) for i in range(seen)])
    (answer,) = VisionModel(folder).answer([asked])
    assert answer.scores == pytest.approx(plain(folder, asked), abs=2e-4)


@pytest.mark.parametrize("seen", [0, 2])
def test_it_holds_for_images_among_the_tokens(tmp_path, seen):
    folder = str(save_llava(tmp_path / "tiny-llava"))
    asked = question(images=[picture(i) for i in range(seen)])
    (answer,) = VisionModel(folder).answer([asked])
    assert answer.scores == pytest.approx(plain(folder, asked), abs=2e-4)
    (words,) = VisionModel(folder).answer([question()])
    assert answer.prompt_tokens == words.prompt_tokens + 4 * seen


def test_images_count(folder):
    black, white = (np.full((24, 24, 3), value, np.uint8) for value in (0, 255))
    a, b = (VisionModel(folder).answer([question(images=[image])])[0].scores for image in (black, white))
    assert np.abs(np.subtract(a, b)).max() > 1e-3


def test_the_batch_changes_nothing(folder):
    asked = [
        question(images=[picture()]),
        question(),
        question(INJECTED, images=[picture(1)]),
        question(names=NAMES[:1]),
    ]
    together = VisionModel(folder).answer(asked)
    for one, answer in zip(asked, together, strict=True):
        alone = VisionModel(folder, batch_size=1).answer([one])[0]
        assert answer.scores == pytest.approx(alone.scores, abs=1e-4)


def test_a_template_without_a_system_beside_images(tmp_path):
    model = VisionModel(str(save_mllama(tmp_path / "m", NO_SYSTEM)))
    asked = question(images=[picture()])
    assert model.answer([asked])[0].choice >= 0
    text = model._template.render("SYSTEM", "USER", 1)
    assert text == "<s><|user|>\n<|image|>SYSTEM\n\nUSER<|end|>\n<|assistant|>\n"


def test_whole_habits_are_dropped_from_the_end(folder):
    many = HABITS * 10
    (answer,) = VisionModel(folder, window=300).answer([question(many, images=[picture()])])
    assert 0 < answer.dropped < len(many)
    kept = question(many[: len(many) - answer.dropped], images=[picture()])
    assert answer.scores == pytest.approx(VisionModel(folder).answer([kept])[0].scores, abs=1e-4)
    (none,) = VisionModel(folder, window=20).answer([question()])
    assert (none.choice, none.failure) == (-1, "too long")


def test_errors_say_what_to_do(folder, tmp_path):
    with pytest.raises(DataError, match=r"no such folder"):
        VisionModel(str(tmp_path / "nowhere")).check()
    with pytest.raises(DataError, match=r"no processor for images|cannot be loaded"):
        VisionModel(str(save_causal(tmp_path / "blind"))).answer([question()])
    assert VisionModel(folder).check() is None
    assert VisionModel(folder).name == "vision (tiny-mllama)"
