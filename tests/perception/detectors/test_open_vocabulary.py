"""Grounding DINO and OWLv2 with random models of their architectures: inputs and outputs, not their meaning."""

from __future__ import annotations

import importlib.util
import shutil
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("torch")
pytest.importorskip("transformers")
import torch

from ucon.core.errors import ConfigError, DetectorError
from ucon.envs.ucon_env import UcONEnv
from ucon.perception.detectors import Frame, vocabulary
from ucon.perception.detectors.grounding_dino import GroundingDinoDetector
from ucon.perception.detectors.open_vocabulary import DetectorWeights, load
from ucon.perception.detectors.owlv2 import TEMPLATE, Owlv2Detector
from ucon.perception.detectors.phrases import Names, chunks, plain

_spec = importlib.util.spec_from_file_location("tiny_models", Path(__file__).with_name("tiny_models.py"))
tiny = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(tiny)

NAMES = ("coffee_table", "coffee_mug", "bed", "t_shirt", "table_lamp", "sofa", "book")
WORDS = tuple({word for name in NAMES for word in plain(name).split()})


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("models")


@pytest.fixture(scope="module")
def dino(folder: Path) -> str:
    return str(tiny.grounding_dino(folder / "dino", WORDS))


@pytest.fixture(scope="module")
def owl(folder: Path) -> str:
    return str(tiny.owlv2(folder / "owl", WORDS))


def frame(height: int = 96, width: int = 128) -> Frame:
    rgb = np.random.default_rng(0).integers(0, 255, (height, width, 3), np.uint8)
    depth = np.full((height, width), 2.0, np.float32)
    none = np.full((height, width), -1, np.int16)
    return Frame(depth, rgb, np.zeros(4, np.float32), 1.25, 90.0, none, np.zeros(1, np.int32))


def check(detector, shown: Frame) -> None:
    boxes = detector.find(shown)
    assert len(boxes.label) > 0
    assert set(boxes.label) <= set(NAMES)
    assert (np.diff(boxes.score) <= 0).all()
    height, width = shown.depth.shape
    assert (boxes.xyxy >= 0).all()
    assert (boxes.xyxy[:, [0, 2]] <= width).all()
    assert (boxes.xyxy[:, [1, 3]] <= height).all()
    assert (boxes.xyxy[:, 2:] > boxes.xyxy[:, :2]).all()
    again = detector.find(shown)
    assert again.label == boxes.label
    assert (again.xyxy == boxes.xyxy).all()
    assert (again.score == boxes.score).all()


def test_owlv2_finds_names_of_the_vocabulary_in_the_frame(owl: str) -> None:
    check(Owlv2Detector(DetectorWeights(owl), threshold=0.0, nms_iou=1.0, names=NAMES), frame())


def test_owlv2_says_what_one_call_of_the_model_says(owl: str) -> None:
    """Even with names embedded beforehand, batches of any size, and boxes mapped back from the padded square."""
    shown = frame()
    loaded = load(DetectorWeights(owl))
    texts = [TEMPLATE.format(plain(name)) for name in NAMES]
    inputs = loaded.processor(text=[texts], images=shown.rgb, return_tensors="pt")
    with torch.inference_mode():
        outputs = loaded.model(**inputs)
    wanted = loaded.processor.post_process_grounded_object_detection(
        outputs, threshold=0.0, target_sizes=[(96, 128)], text_labels=[list(NAMES)]
    )[0]
    for batch in (2, 100):
        detector = Owlv2Detector(DetectorWeights(owl), threshold=0.0, nms_iou=1.0, names=NAMES, batch=batch)
        with torch.inference_mode():
            found = detector._raw(loaded, shown.rgb)
        assert found.label == wanted["text_labels"]
        np.testing.assert_allclose(found.score, wanted["scores"].numpy(), atol=1e-5)
        np.testing.assert_allclose(found.xyxy, wanted["boxes"].numpy(), atol=1e-3)
    assert found.xyxy.max() > 96, "boxes reach across the width of the frame"


def test_owlv2_embeds_the_names_once(owl: str) -> None:
    detector = Owlv2Detector(DetectorWeights(owl), threshold=0.0, names=NAMES)
    detector.find(frame())
    first = detector._queries
    detector.reset("next", ())
    detector.find(frame())
    assert detector._queries is first
    assert first.shape == (len(NAMES), 32)


def test_grounding_dino_finds_names_of_the_vocabulary_in_the_frame(dino: str) -> None:
    detector = GroundingDinoDetector(DetectorWeights(dino), threshold=0.0, text_threshold=0.0, nms_iou=1.0, names=NAMES)
    check(detector, frame())


def test_grounding_dino_in_one_prompt_says_what_one_call_says(dino: str) -> None:
    shown, loaded = frame(), load(DetectorWeights(dino))
    detector = GroundingDinoDetector(DetectorWeights(dino), threshold=0.0, text_threshold=0.5, names=NAMES)
    prompts = detector.prompts(loaded)
    assert prompts == ["coffee table. coffee mug. bed. t shirt. table lamp. sofa. book."]
    inputs = loaded.processor(images=shown.rgb, text=prompts[0], return_tensors="pt")
    with torch.inference_mode():
        wanted = loaded.processor.post_process_grounded_object_detection(
            loaded.model(**inputs), inputs["input_ids"], threshold=0.0, text_threshold=0.5, target_sizes=[(96, 128)]
        )[0]
        found = detector._raw(loaded, shown.rgb)
    names = Names(NAMES)
    meant = [names.of(phrase) for phrase in wanted["text_labels"]]
    rows = [k for k, name in enumerate(meant) if name]
    assert found.label == [meant[k] for k in rows]
    assert detector.unmatched == names.unmatched == len(meant) - len(rows)
    np.testing.assert_allclose(found.xyxy, wanted["boxes"].numpy()[rows], atol=1e-4)
    assert found.xyxy.max() > 1.5, "boxes are pixels"


def test_grounding_dino_splits_what_does_not_fit_its_window(folder: Path) -> None:
    small = str(tiny.grounding_dino(folder / "small", WORDS, window=10))
    detector = GroundingDinoDetector(
        DetectorWeights(small), threshold=0.0, text_threshold=0.0, nms_iou=1.0, names=NAMES
    )
    loaded = load(DetectorWeights(small))
    prompts = detector.prompts(loaded)
    assert prompts == ["coffee table. coffee mug. bed.", "t shirt. table lamp. sofa.", "book."]
    assert all(len(loaded.processor.tokenizer(prompt)["input_ids"]) <= 10 for prompt in prompts)
    with torch.inference_mode():
        found = detector._raw(loaded, frame().rgb)
        alone = []
        for part in (NAMES[:3], NAMES[3:6], NAMES[6:]):
            one = GroundingDinoDetector(DetectorWeights(small), threshold=0.0, text_threshold=0.0, names=part)
            alone.append(one._raw(loaded, frame().rgb))
    assert found.label == [name for part in alone for name in part.label]
    np.testing.assert_allclose(found.xyxy, np.concatenate([part.xyxy for part in alone]), atol=1e-5)


@pytest.mark.parametrize("make", [GroundingDinoDetector, Owlv2Detector])
def test_an_episode_with_a_model_in_it(make: type, dino: str, owl: str) -> None:
    """Colours are rendered for the detector, but an agent with symbolic observations does not get them."""
    detector = make(
        DetectorWeights(dino if make is GroundingDinoDetector else owl), threshold=0.0, most_boxes=5, names=NAMES
    )
    env = UcONEnv("mini", observe="symbolic", detector=detector, habit_level="none")
    looks = []
    for _ in range(2):
        obs, info = env.reset(options={"episode": 0})
        look = [info["detections"].image.tobytes()]
        for action in (1, 0, 5, 3):
            assert not {"rgb", "depth"} & obs.keys()
            assert info["tracks"].shape == info["depth"].shape == (128, 128)
            assert isinstance(info["opened"], tuple)
            obs, _, _, _, info = env.step(action)
            look.append(info["detections"].image.tobytes() + repr(info["detections"].category).encode())
        looks.append(look)
    assert looks[0] == looks[1]
    env.close()


def test_weights_that_are_not_there_are_one_line(tmp_path: Path) -> None:
    detector = Owlv2Detector(DetectorWeights(str(tmp_path / "none")))
    with pytest.raises(DetectorError, match="download=true") as caught:
        detector.find(frame())
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("kind", [Owlv2Detector, GroundingDinoDetector])
@pytest.mark.parametrize("lacks", ["", "config.json", "model.safetensors"])
def test_missing_files_are_told_before_anything_is_loaded(kind: type, lacks: str, owl: str, tmp_path: Path) -> None:
    shutil.copytree(owl, tmp_path / "m")
    before = load.cache_info().currsize
    detector = kind(DetectorWeights(str(tmp_path / "m")), threshold=0.2)
    detector.check()
    print_of_all = detector.fingerprint()
    assert print_of_all == kind(DetectorWeights(owl), threshold=0.2).fingerprint()
    if lacks:
        (tmp_path / "m" / lacks).unlink()
        with pytest.raises(DetectorError, match=r"no (config\.json|weights \(\*\.safetensors\)); give") as caught:
            detector.check()
        assert "\n" not in str(caught.value)
        assert detector.fingerprint() != print_of_all
    assert load.cache_info().currsize == before


def test_a_name_that_is_not_in_the_cache_is_told(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("huggingface_hub.constants.HF_HUB_CACHE", str(tmp_path))
    detector = Owlv2Detector(DetectorWeights("google/owlv2-base-patch16-ensemble"), threshold=0.2)
    with pytest.raises(DetectorError, match=r"detector owlv2: weights google/.* no folder or cached model"):
        detector.check()
    assert detector.fingerprint() is None


def test_options_that_cannot_be_are_refused(owl: str) -> None:
    with pytest.raises(ConfigError, match="dtype"):
        DetectorWeights(owl, dtype="int8")
    for wrong in ({"threshold": 1.0}, {"nms_iou": -1.0}, {"most_boxes": 0}):
        with pytest.raises(ConfigError, match="expected a threshold"):
            Owlv2Detector(DetectorWeights(owl), **wrong)
    colourless = frame()
    colourless = Frame(
        colourless.depth, None, *(getattr(colourless, f) for f in ("pose", "camera_m", "fov_deg", "instance", "counts"))
    )
    with pytest.raises(DetectorError, match="no colours"):
        Owlv2Detector(DetectorWeights(owl), names=NAMES).find(colourless)


@pytest.mark.parametrize(
    ("phrase", "name"),
    [
        ("coffee table", "coffee_table"),
        ("Coffee Table.", "coffee_table"),
        ("t - shirt", "t_shirt"),
        ("bed coffee mug", "coffee_mug"),
        ("the old book", "book"),
        ("table lamp bed", "table_lamp"),
        ("coffee", None),
        ("bedroom", None),
        ("", None),
    ],
)
def test_phrases_mean_the_longest_name_in_them(phrase: str, name: str | None) -> None:
    names = Names(NAMES)
    assert names.of(phrase) == name
    assert names.unmatched == (name is None)


def test_every_name_of_the_catalogue_means_itself() -> None:
    names = Names(vocabulary())
    assert [names.of(plain(name)) for name in vocabulary()] == list(vocabulary())


def test_chunks_hold_every_name_once_and_fit() -> None:
    parts = chunks(vocabulary(), lambda text: len(text.split()), 254)
    assert [name for part in parts for name in part] == list(vocabulary())
    assert len(parts) > 5
    assert all(sum(len(plain(name).split()) + 1 for name in part) <= 254 for part in parts)


def test_a_dot_after_each_name_takes_room() -> None:
    """Names of two tokens take three: two names fill a window of six, and a seventh token does not fit a third."""
    names, count = ("coffee cup", "toy car", "tea pot"), lambda text: len(text.split())
    assert chunks(names, count, 6) == chunks(names, count, 7) == [names[:2], names[2:]]
    assert chunks(names, count, 5) == [(name,) for name in names]
    assert chunks(names, count, 9) == [names]
