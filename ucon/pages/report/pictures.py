"""Small pictures of the camera in an episode: each pose is drawn once, and stored as WebP."""

from __future__ import annotations

import io
from typing import Final, Literal

import numpy as np
from PIL import Image

from ucon.sim.render import RasterRenderer
from ucon.task.search import Search

Pictures = Literal["none", "key", "all"]
#: Side of a picture in pixels, and quality of its WebP: a picture takes half a kilobyte.
SIDE_PX: Final = 112
_QUALITY: Final = 25


def small_renderer(fov_deg: float) -> RasterRenderer:
    """The renderer of all pictures of a run, with the angle of view of its rules."""
    return RasterRenderer(SIDE_PX, SIDE_PX, fov_deg)


class Album:
    """Pictures of one episode.

    Attributes:
        pictures: WebP files.
    """

    def __init__(self, search: Search, renderer: RasterRenderer) -> None:
        """Start empty.

        Args:
            search: of the episode.
            renderer: of :func:`small_renderer`; it is loaded with the episode's home.
        """
        self._search, self._renderer = search, renderer
        self._opened: tuple[int, ...] = ()
        self._taken: dict[tuple[object, ...], int] = {}
        self.pictures: list[bytes] = []
        renderer.load(search.world.house, search.world.arrangement)

    def take(self) -> int:
        """Number of the picture of the current pose, which is drawn unless it was drawn before."""
        opened = tuple(np.flatnonzero(self._search.opened).tolist())
        for instance in opened:
            if instance not in self._opened:
                self._renderer.set_open(instance, 1.0)
        self._opened = opened
        key = (self._search.pose, opened)
        if key not in self._taken:
            self._taken[key] = len(self.pictures)
            rgb = np.empty((SIDE_PX, SIDE_PX, 3), np.uint8)
            self._renderer.render(*self._search.camera, rgb=rgb)
            file = io.BytesIO()
            Image.fromarray(rgb).save(file, "webp", quality=_QUALITY)
            self.pictures.append(file.getvalue())
        return self._taken[key]
