"""Stand-alone program that runs YOLO-World for :mod:`ucon.perception.detectors.yolo_world`, in a Python of its own.

It imports nothing from UcON: ``ultralytics`` (AGPL-3.0, brings its own OpenCV) stays out of UcON's process and
environment. A message on stdin or stdout is a length (4 bytes, big-endian) followed by that many bytes:

    -> JSON {"weights": path, "names": [...], "device": "cpu", "threshold": 0.05, "image_px": 640, "most": 100}
    <- JSON {"ready": true}
    -> JSON {"shape": [H, W, 3]}, then raw RGB bytes as a second message
    <- JSON {"boxes": [[x0, y0, x1, y1, score, number of the name], ...]}

Any answer may be {"error": text} instead, after which the program ends. It also ends when stdin is closed.
"""

from __future__ import annotations

import json
import os
import struct
import sys
from pathlib import Path
from typing import Any, BinaryIO


def read(stream: BinaryIO) -> bytes | None:
    """Read the next message.

    Returns:
        Its body; None at the end of the stream or where it breaks off.
    """
    head = stream.read(4)
    if len(head) < 4:
        return None
    (size,) = struct.unpack(">I", head)
    body: bytes = stream.read(size)
    return body if len(body) == size else None


def write(stream: BinaryIO, answer: dict[str, Any]) -> None:
    """Send one answer: its JSON text with the length before it."""
    body = json.dumps(answer).encode()
    stream.write(struct.pack(">I", len(body)) + body)
    stream.flush()


def load(settings: dict[str, Any]) -> Any:
    """Load the model and set its vocabulary.

    Args:
        settings: the first message; ``weights`` and ``names`` are used.
    """
    # Python puts this file's folder on the path; UcON's modules there must not shadow packages.
    here = Path(__file__).resolve().parent
    sys.path[:] = [path for path in sys.path if Path(path).resolve() != here]
    # Nothing may be installed or fetched behind the user's back.
    os.environ["YOLO_AUTOINSTALL"] = "false"
    os.environ.setdefault("YOLO_OFFLINE", "true")
    from ultralytics import YOLOWorld

    model = YOLOWorld(settings["weights"])
    model.set_classes(settings["names"])
    return model


def detect(model: Any, settings: dict[str, Any], shape: list[int], pixels: bytes) -> list[list[float]]:
    """Find boxes in one image.

    Args:
        model: what :func:`load` returned.
        settings: the first message.
        shape: (H, W, 3).
        pixels: raw RGB bytes.

    Returns:
        Rows x0, y0, x1, y1, score, number of the name; coordinates in pixels.
    """
    import numpy as np

    rgb = np.frombuffer(pixels, np.uint8).reshape(shape)
    # The library takes arrays in OpenCV's channel order, BGR.
    found = model.predict(
        np.ascontiguousarray(rgb[:, :, ::-1]),
        conf=settings["threshold"],
        imgsz=settings["image_px"],
        device=settings["device"],
        max_det=settings["most"],
        verbose=False,
    )[0].boxes
    columns = found.xyxy.tolist(), found.conf.tolist(), found.cls.tolist()
    return [[*xyxy, score, int(name)] for xyxy, score, name in zip(*columns, strict=True)]


def main() -> int:
    """Answer requests until stdin is closed.

    Returns:
        Exit code: 0 at the end of stdin, 1 after an error.
    """
    source, sink = sys.stdin.buffer, os.fdopen(os.dup(1), "wb")
    # Whatever the library prints goes to stderr, not between the answers.
    os.dup2(2, 1)
    try:
        first = read(source)
        if first is None:
            return 0
        settings = json.loads(first)
        model = load(settings)
        write(sink, {"ready": True})
        while True:
            head, pixels = read(source), read(source)
            if head is None or pixels is None:
                return 0
            write(sink, {"boxes": detect(model, settings, json.loads(head)["shape"], pixels)})
    except ImportError as error:
        write(sink, {"error": f"{error}; install ultralytics into the environment of {sys.executable}"})
    except Exception as error:
        write(sink, {"error": f"{type(error).__name__}: {error}"})
    return 1


if __name__ == "__main__":
    sys.exit(main())
