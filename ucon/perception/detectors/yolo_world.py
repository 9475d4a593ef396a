"""YOLO-World through ``ultralytics``, in a process and a Python environment of its own.

That package is AGPL-3.0 and replaces the headless OpenCV, so it must not be installed alongside UcON. Set it up once:

    python -m venv yolo-world
    yolo-world/bin/pip install ultralytics git+https://github.com/ultralytics/CLIP.git
    yolo-world/bin/python -c "from ultralytics import YOLOWorld; YOLOWorld('yolov8l-worldv2.pt').set_classes(['cup'])"

The last line fetches the weights into the folder it is run in, and the text encoder into its cache. Then
``detector=yolo_world detector.python=yolo-world/bin/python detector.weights=yolov8l-worldv2.pt``.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ucon.core.errors import ConfigError, DetectorError, brief
from ucon.core.untrusted.weight_files import fingerprint
from ucon.perception.detectors.base import Frame, vocabulary
from ucon.perception.detectors.box_detector import BoxDetector
from ucon.perception.detectors.boxes import Boxes
from ucon.perception.detectors.phrases import plain
from ucon.perception.detectors.worker_link import WorkerLink
from ucon.perception.tracking.tracker import GATE_M

WORKER = Path(__file__).with_name("yolo_world_worker.py")


class YoloWorldDetector(BoxDetector):
    """Boxes by YOLO-World. Its process starts at the first frame and ends with :meth:`close`."""

    name = "yolo_world"
    from_command_line = ("python", "weights")
    """A program, and a file that it unpickles: only the command line may name them, never a stored configuration."""

    def __init__(
        self,
        python: str,
        weights: str,
        *,
        threshold: float = 0.05,
        nms_iou: float = 0.5,
        most_boxes: int = 100,
        image_px: int = 640,
        device: str = "cpu",
        load_timeout_s: float = 300.0,
        timeout_s: float = 30.0,
        names: Sequence[str] | None = None,
        gate_m: float = GATE_M,
        errors: str | None = None,
    ) -> None:
        """Set the options; nothing is started yet.

        Args:
            python: Python executable of the environment that has ``ultralytics``.
            weights: file of a YOLO-World model.
            threshold: least score of a box, from 0 to below 1.
            nms_iou: of boxes of one name that overlap by more, the best stays.
            most_boxes: most boxes that are kept in one frame.
            image_px: side in pixels to which frames are scaled.
            device: cpu, or a GPU as torch names it.
            load_timeout_s: seconds for loading the model and embedding all names.
            timeout_s: seconds for one frame.
            names: the vocabulary, by default all names of the catalogue.
            gate_m: boxes of one category farther apart than this, in metres, are two things.
            errors: file with its errors; None: those that come with the package, where there are any.

        Raises:
            ConfigError: a number is out of its range.
        """
        super().__init__(gate_m, errors)
        if not 0.0 <= threshold < 1.0 or min(load_timeout_s, timeout_s) <= 0.0 or most_boxes < 1 or image_px < 32:
            raise ConfigError(
                f"detector yolo_world: threshold={threshold}, load_timeout_s={load_timeout_s}, timeout_s={timeout_s}, "
                f"most_boxes={most_boxes}, image_px={image_px}: expected a threshold from 0 to below 1, times above "
                "0 s, at least one box and 32 pixels"
            )
        # Links are not resolved: Python finds its environment by the path of the link.
        self._python, self._weights = Path(python).expanduser(), Path(weights).expanduser()
        self._names = vocabulary() if names is None else tuple(names)
        self._settings = {"device": device, "threshold": threshold, "image_px": image_px, "most": most_boxes}
        self._nms_iou, self._most_boxes = nms_iou, most_boxes
        self._load_timeout_s, self._timeout_s = load_timeout_s, timeout_s
        self._link: WorkerLink | None = None

    def check(self) -> None:
        """Check that the other Python and the weights are files; nothing is started.

        Raises:
            DetectorError: one of them is missing.
        """
        for option, path in (("python", self._python), ("weights", self._weights)):
            if not path.is_file():
                raise DetectorError(f"detector.{option}={path}: no such file; see configs/detector/yolo_world.yaml")

    def fingerprint(self) -> str | None:
        """Checksum of the weights' file; None where there is none."""
        return fingerprint(self._weights) if self._weights.is_file() else None

    def find(self, frame: Frame) -> Boxes:
        """Boxes of the vocabulary's names in one frame, after non-maximum suppression.

        Returns:
            Boxes in the frame's pixels, clipped to it, by falling score.

        Raises:
            DetectorError: the frame has no colour image, or the process failed, which ends it.
        """
        if frame.rgb is None:
            raise DetectorError("detector yolo_world: the frame has no colours; render rgb for it")
        link = self._link or self._start()
        head = json.dumps({"shape": frame.rgb.shape}).encode()
        try:
            answer = link.ask([head, np.ascontiguousarray(frame.rgb).tobytes()], self._timeout_s)
            return self._boxes(answer.get("boxes"), frame.depth.shape)
        except DetectorError:
            self.close()
            raise

    def close(self) -> None:
        """End the process, if it runs."""
        if self._link is not None:
            self._link.close()
            self._link = None

    def _start(self) -> WorkerLink:
        """Start the process and load the model."""
        self.check()
        link = WorkerLink([str(self._python.absolute()), str(WORKER)], "detector yolo_world")
        names = [plain(name) for name in self._names]
        settings = {**self._settings, "weights": str(self._weights.absolute()), "names": names}
        link.ask([json.dumps(settings).encode()], self._load_timeout_s)
        self._link = link
        return link

    def _boxes(self, rows: object, shape: tuple[int, ...]) -> Boxes:
        """Check the answer's rows (x0, y0, x1, y1, score, name number) and turn them into boxes."""
        if not isinstance(rows, list) or not all(_is_row(row, len(self._names)) for row in rows):
            raise DetectorError(
                f"detector yolo_world: answered {brief(repr(rows))}, expected rows of x0, y0, x1, y1, score and the "
                "number of a name; is the worker of another version?"
            )
        if not rows:
            return Boxes.none()
        table = np.array(rows, np.float32)
        edge = np.array([shape[1], shape[0]] * 2, np.float32)
        label = [self._names[int(row[5])] for row in rows]
        found = Boxes(label, table[:, 4], np.clip(table[:, :4], 0, edge))
        inside = np.flatnonzero(((found.xyxy[:, 2:] - found.xyxy[:, :2]) > 0.5).all(1))
        return found.keep(inside).non_maximum_suppression(self._nms_iou, self._most_boxes)


def _is_row(row: object, n_names: int) -> bool:
    """Whether a value is a valid row: four coordinates, a score from 0 to 1, and the number of a name."""
    if not isinstance(row, list) or len(row) != 6:
        return False
    numbers = all(isinstance(x, int | float) and not isinstance(x, bool) and math.isfinite(x) for x in row)
    return numbers and 0.0 <= row[4] <= 1.0 and row[5] == int(row[5]) and 0 <= row[5] < n_names
