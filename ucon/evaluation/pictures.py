"""The first episodes to look at: a video (first person beside the map) and the map at the end, as files."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image

Frame = NDArray[np.uint8]

_FPS = 6
#: VP8 plays in browsers, at a sixth of the time that VP9 takes; MPEG-4 part 2 is what every OpenCV has.
_CODECS = (("VP80", ".webm"), ("mp4v", ".mp4"))
#: Films have so much of the width and height of their frames: words stay readable, and encoding is most of the time.
_FILM_SCALE = 5 / 6
_STRIP_PX = 26
#: How long the last frame stays, so that one sees how it ended.
_HOLD_FRAMES = 6
#: A still picture for viewers without video; longer films are thinned out to this many frames.
_GIF_FRAMES = 120


def save_film(frames: Sequence[Frame], captions: Sequence[str], folder: Path, name: str, fps: int = _FPS) -> list[Path]:
    """Write ``name.png`` (map at the end) and ``name.webm``, ``.mp4`` or ``.gif``, the first that OpenCV can write.

    Args:
        frames: what ``env.render()`` returned, (H, 2H, 3) uint8 each: camera left, map right; beside it what the agent
            thought, of the same height, where it shows that.
        captions: one line of text above each frame.
        folder: made if missing.
        name: file name without suffix.
        fps: frames a second.

    Returns:
        The files written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    height = frames[0].shape[0]
    top_down = folder / f"{name}.png"
    Image.fromarray(_captioned(frames[-1][:, height : 2 * height], captions[-1])).save(top_down)
    frames = _as_wide_as_the_widest(frames)
    frames = [_smaller(_captioned(frame, caption)) for frame, caption in zip(frames, captions, strict=True)]
    for codec, suffix in _CODECS:
        film = folder / f"{name}{suffix}"
        if _write_video(frames, film, fps, codec):
            return [top_down, film]
        film.unlink(missing_ok=True)
    film = folder / f"{name}.gif"
    _write_gif(frames, film, fps)
    return [top_down, film]


def _as_wide_as_the_widest(frames: Sequence[Frame]) -> list[Frame]:
    """After its last action an agent thinks nothing more: its last thought stays."""
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


def _smaller(frame: Frame) -> Frame:
    """The frame as films have it; encoders want even sides."""
    height, width = (2 * round(side * _FILM_SCALE / 2) for side in frame.shape[:2])
    return np.asarray(cv2.resize(frame, (width, height), interpolation=cv2.INTER_AREA), np.uint8)


def _write_video(frames: Sequence[Frame], path: Path, fps: int, codec: str) -> bool:
    height, width = frames[0].shape[:2]
    with _no_errors_shown():
        writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*codec), fps, (width, height))
    if not writer.isOpened():
        return False
    for frame in [*frames, *[frames[-1]] * _HOLD_FRAMES]:
        writer.write(cv2.cvtColor(frame, cv2.COLOR_RGB2BGR))
    writer.release()
    return path.is_file() and path.stat().st_size > 0


@contextmanager
def _no_errors_shown() -> Iterator[None]:
    """FFmpeg prints, past Python, that it has no such tag, and goes on with its own."""
    sys.stderr.flush()
    kept, nowhere = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 2)
    try:
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(nowhere)


def _write_gif(frames: Sequence[Frame], path: Path, fps: int) -> None:
    step = -(-len(frames) // _GIF_FRAMES)  # rounded up
    images = [Image.fromarray(frame) for frame in frames[::step]]
    images[0].save(path, save_all=True, append_images=images[1:], duration=1000 // fps, loop=0)
