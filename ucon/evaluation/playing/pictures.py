"""Films of episodes: a video (first person next to the map), and the final map as a picture."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image

if TYPE_CHECKING:
    from types import ModuleType

Frame = NDArray[np.uint8]

_FPS = 6
_STRIP_PX = 26
#: Number of times that the last frame is repeated.
_HOLD_FRAMES = 6
#: VP8, which every browser plays; ``realtime`` takes a fifth of the default's time.
_CODEC, _OPTIONS = "libvpx", {"deadline": "realtime", "cpu-used": "8", "crf": "10"}
_BITS_PER_S = 2_000_000


def worth_filming(found: Sequence[bool], n: int) -> list[int]:
    """Indices of the first ``n`` successes and of the first ``n`` failures, sorted.

    Args:
        found: success of each episode.
        n: how many of each.
    """
    return sorted(number for ending in (True, False) for number in [k for k, f in enumerate(found) if f == ending][:n])


def save_film(frames: Sequence[Frame], captions: Sequence[str], folder: Path, name: str, fps: int = _FPS) -> list[Path]:
    """Write ``name.png``, the final map, and ``name.webm``, the video.

    Args:
        frames: (H, W, 3) uint8 of ``env.render()``, W = 2 H: camera left, map right; and to the right of it the agent's
            picture of the same height, if it draws one. Sides are even.
        captions: one line of text above each frame.
        folder: is created if missing.
        name: file name without suffix.
        fps: frames per second.

    Returns:
        The files written; without PyAV only the map, with a warning.
    """
    folder.mkdir(parents=True, exist_ok=True)
    height = frames[0].shape[0]
    top_down, film = folder / f"{name}.png", folder / f"{name}.webm"
    Image.fromarray(_captioned(frames[-1][:, height : 2 * height], captions[-1])).save(top_down)
    if (av := _pyav()) is None:
        return [top_down]
    shown = [_captioned(*pair) for pair in zip(_as_wide_as_the_widest(frames), captions, strict=True)]
    _write_video(av, [*shown, *[shown[-1]] * _HOLD_FRAMES], film, fps)
    return [top_down, film]


@cache
def _pyav() -> ModuleType | None:
    try:
        import av
    except ImportError:
        print("warning: no films, since the package av is missing; run `make setup`", file=sys.stderr)  # noqa: T201
        return None
    return av


def _as_wide_as_the_widest(frames: Sequence[Frame]) -> list[Frame]:
    """Frames of equal width: after its last action the agent draws nothing, so its last picture is repeated."""
    width = max(frame.shape[1] for frame in frames)
    out: list[Frame] = []
    for frame in frames:
        kept = out[-1][:, frame.shape[1] :] if out else np.zeros((frame.shape[0], width, 3), np.uint8)
        out.append(np.concatenate([frame, kept[:, : width - frame.shape[1]]], axis=1))
    return out


def _captioned(frame: Frame, caption: str) -> Frame:
    """The frame with a line of text in a strip above it."""
    strip = np.full((_STRIP_PX, frame.shape[1], 3), 28, np.uint8)
    cv2.putText(strip, caption, (8, 18), cv2.FONT_HERSHEY_SIMPLEX, 0.45, (235, 235, 235), 1, cv2.LINE_AA)
    return np.concatenate([strip, frame])


def _write_video(av: ModuleType, frames: Iterable[Frame], path: Path, fps: int) -> None:
    with av.open(str(path), "w") as video:
        stream = video.add_stream(_CODEC, rate=fps, options=_OPTIONS)
        stream.bit_rate, stream.pix_fmt, stream.thread_count = _BITS_PER_S, "yuv420p", 1
        for number, frame in enumerate(frames):
            if number == 0:
                stream.height, stream.width = frame.shape[:2]
            video.mux(stream.encode(av.VideoFrame.from_ndarray(frame, format="rgb24")))
        video.mux(stream.encode())
