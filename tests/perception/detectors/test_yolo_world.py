"""YOLO-World's process, with a stand-in for ``ultralytics`` that finds bright pixels and misbehaves on request."""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np
import pytest

from ucon.core.errors import ConfigError, DetectorError
from ucon.envs.ucon_env import UcONEnv
from ucon.perception.detectors import Frame
from ucon.perception.detectors.worker_link import WorkerLink
from ucon.perception.detectors.yolo_world import WORKER, YoloWorldDetector

NAMES = ("coffee_table", "bed", "mug")
DOUBLE = """
import os, sys, time
import numpy as np

print("a banner on stdout, as libraries print")

class Rows:
    def __init__(self, rows): self.rows = np.array(rows, float).reshape(-1, 6)
    xyxy = property(lambda self: self.rows[:, :4])
    conf = property(lambda self: self.rows[:, 4])
    cls = property(lambda self: self.rows[:, 5])

class Result:
    def __init__(self, rows): self.boxes = Rows(rows)

class YOLOWorld:
    def __init__(self, weights):
        self.mode = open(weights).read().strip()
        self.calls = 0
        if self.mode == "bad weights": raise ValueError("not a model\\nsecond line")
    def set_classes(self, names):
        self.names = names
    def predict(self, image, conf, imgsz, device, max_det, verbose):
        assert self.names == ["coffee table", "bed", "mug"], self.names
        assert (conf, imgsz, device, max_det, verbose) == (0.05, 640, "cpu", 100, False)
        assert os.environ["YOLO_AUTOINSTALL"] == "false"
        self.calls += 1
        print("predicting", self.calls)
        if self.mode == "hang": time.sleep(60)
        if self.mode == "crash":
            print("out of memory", file=sys.stderr, flush=True)
            os._exit(7)
        if self.mode == "nonsense": return [Result([[0, 0, 9, 9, 0.5, 77]])]
        if self.mode == "nan": return [Result([[0, 0, 9, float("nan"), 0.5, 1]])]
        if self.mode == "nothing": return [Result([])]
        v, u = np.nonzero(image[:, :, 2] > 250)
        red = [u.min(), v.min(), u.max() + 1, v.max() + 1]
        return [Result([[*red, 0.9, 2], [*red, 0.4, 2], [-5, -5, 500, 500, 0.3, 1]])]
"""


@pytest.fixture
def make(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Makes detectors whose worker gets the stand-in in a given mode; they are closed afterwards."""
    (tmp_path / "ultralytics").mkdir()
    (tmp_path / "ultralytics" / "__init__.py").write_text(DOUBLE)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    made = []

    def build(mode: str = "", **options) -> YoloWorldDetector:
        (tmp_path / "weights.pt").write_text(mode)
        options = {"load_timeout_s": 60.0, "timeout_s": 20.0, "names": NAMES} | options
        made.append(YoloWorldDetector(sys.executable, str(tmp_path / "weights.pt"), **options))
        return made[-1]

    yield build
    for detector in made:
        detector.close()


def frame() -> Frame:
    rgb = np.zeros((96, 128, 3), np.uint8)
    rgb[20:40, 30:60, 0] = 255
    depth, none = np.full((96, 128), 2.0, np.float32), np.full((96, 128), -1, np.int16)
    return Frame(depth, rgb, np.zeros(4, np.float32), 1.25, 90.0, none, np.zeros(1, np.int32))


def test_boxes_come_back_with_names_within_the_frame_and_without_doubles(make) -> None:
    detector = make()
    for _ in range(3):
        boxes = detector.find(frame())
        assert boxes.label == ["mug", "bed"]
        assert boxes.score.tolist() == pytest.approx([0.9, 0.3])
        assert boxes.xyxy.tolist() == [[30, 20, 60, 40], [0, 0, 128, 96]], "red is where it was: BGR for the library"
    detector.reset("e", ("mug",))
    found = detector.detect(frame())
    assert found.category[-2:] == ("bed", "mug")
    assert found.image[30, 45] == found.track[-1]


def test_closing_ends_the_process_and_a_next_frame_starts_another(make) -> None:
    detector = make()
    detector.find(frame())
    process = detector._link._process
    started = time.monotonic()
    detector.close()
    assert process.poll() == 0, "it ended by itself when its input did"
    assert time.monotonic() - started < 2.0
    detector.close()
    assert detector.find(frame()).label == ["mug", "bed"]


@pytest.mark.parametrize("option", ["python", "weights"])
def test_what_is_missing_is_told_before_anything_starts(make, option: str, tmp_path: Path) -> None:
    detector = make()
    detector.check()
    assert detector._link is None
    paths = {"python": sys.executable, "weights": str(tmp_path / "weights.pt")} | {option: str(tmp_path / "none")}
    with pytest.raises(DetectorError, match=rf"detector\.{option}=.*none: no such file") as caught:
        YoloWorldDetector(**paths).check()
    assert "\n" not in str(caught.value)


def test_other_weights_under_one_name_have_another_fingerprint(make, tmp_path: Path) -> None:
    detector = make()
    first = detector.fingerprint()
    assert first == make().fingerprint()
    assert make("nothing").fingerprint() != first
    (tmp_path / "weights.pt").unlink()
    assert detector.fingerprint() is None


def test_no_box_is_no_error(make) -> None:
    assert make("nothing").find(frame()).label == ()


@pytest.mark.parametrize(
    ("mode", "message"),
    [
        ("bad weights", "ValueError: not a model$"),
        ("crash", "ended with exit code 7; it printed last: out of memory"),
        ("nonsense", "expected rows"),
        ("nan", "expected a JSON object"),
    ],
)
def test_what_goes_wrong_is_one_line_and_ends_the_process(make, mode: str, message: str) -> None:
    detector = make(mode)
    with pytest.raises(DetectorError, match=message) as caught:
        detector.find(frame())
    assert "\n" not in str(caught.value)
    assert detector._link is None


def test_one_that_hangs_is_ended_in_time(make) -> None:
    detector = make("hang", timeout_s=1.0)
    started = time.monotonic()
    with pytest.raises(DetectorError, match=r"no answer in 1 s"):
        detector.find(frame())
    assert time.monotonic() - started < 15.0


def test_without_the_package_it_says_what_to_install(make, tmp_path: Path) -> None:
    detector = make()
    (tmp_path / "ultralytics" / "__init__.py").write_text(
        "raise ModuleNotFoundError(\"No module named 'ultralytics'\")"
    )
    with pytest.raises(DetectorError, match="install ultralytics into the environment of"):
        detector.find(frame())


def test_a_program_that_is_no_worker_is_told_from_one(make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from ucon.perception.detectors import yolo_world

    for text, message in (
        ("hello, I am no worker", "answered .* bytes"),
        ("\x00\x00\x00\x02[]", "expected a JSON object"),
    ):
        fake = tmp_path / "fake.py"
        fake.write_text(f"import sys; sys.stdout.write({text!r}); sys.stdout.flush(); sys.stdin.read()")
        monkeypatch.setattr(yolo_world, "WORKER", fake)
        with pytest.raises(DetectorError, match=message):
            make().find(frame())


def test_missing_files_and_bad_options_are_told_beforehand(tmp_path: Path) -> None:
    detector = YoloWorldDetector(str(tmp_path / "python"), str(tmp_path / "w.pt"))
    with pytest.raises(DetectorError, match=r"detector\.python=.*no such file"):
        detector.find(frame())
    detector = YoloWorldDetector(sys.executable, str(tmp_path / "w.pt"))
    with pytest.raises(DetectorError, match=r"detector\.weights=.*no such file"):
        detector.find(frame())
    with pytest.raises(ConfigError, match="threshold=2"):
        YoloWorldDetector(sys.executable, "w.pt", threshold=2.0)
    (tmp_path / "x.txt").write_text("no program")
    detector = YoloWorldDetector(str(tmp_path / "x.txt"), str(tmp_path / "x.txt"))
    with pytest.raises(DetectorError, match="cannot be started"):
        detector.find(frame())


def test_the_environment_closes_it(make) -> None:
    detector = make("nothing")
    env = UcONEnv("mini", observe="symbolic", detector=detector, habit_level="none")
    _, info = env.reset(options={"episode": 0})
    assert set(info["detections"].category) <= {"floors", "walls", "ceilings", "obstacles"}
    process = detector._link._process
    env.close()
    assert process.poll() == 0


def test_the_worker_imports_nothing_of_ucon() -> None:
    assert "import ucon" not in WORKER.read_text()
    assert "from ucon" not in WORKER.read_text()


def test_a_program_that_reads_nothing_is_ended_in_time() -> None:
    """A message larger than its pipe does not block until the program reads."""
    link = WorkerLink([sys.executable, "-c", "import time; time.sleep(600)"], "detector x")
    with pytest.raises(DetectorError, match=r"detector x: no answer in 1 s"):
        link.ask([bytes(1 << 20)], 1.0)
    assert link._process.returncode is not None
