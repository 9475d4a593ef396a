"""A walk through a home: frames of the project's own renderer, drawn on request."""

from __future__ import annotations

import threading
from collections import OrderedDict
from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np

from ucon.sim.house import House
from ucon.sim.render import RasterRenderer

#: Size of a frame in pixels, and its angle of view.
WIDTH, HEIGHT, FOV_DEG = 560, 400, 90.0
EYE_M: Final = 1.4
_QUALITY: Final = 88
#: Largest number of homes that are kept loaded.
_MOST: Final = 4


@dataclass(frozen=True)
class Camera:
    """Where somebody stands and looks: metres in the world frame, quarter turns, degrees (up positive)."""

    x: float
    y: float
    yaw: float
    pitch_deg: float


class _Walk:
    """One home in a renderer; one request at a time."""

    def __init__(self, house: House) -> None:
        self._renderer = RasterRenderer(WIDTH, HEIGHT, FOV_DEG)
        self._renderer.load(house)
        self._rgb = np.empty((HEIGHT, WIDTH, 3), np.uint8)
        self._instance = np.empty((HEIGHT, WIDTH), np.int16)
        self._open: frozenset[int] = frozenset()
        self._lock = threading.Lock()

    def frame(self, camera: Camera, opened: frozenset[int]) -> bytes:
        with self._lock:
            self._set_open(opened)
            self._renderer.render(camera.x, camera.y, EYE_M, camera.yaw, camera.pitch_deg, rgb=self._rgb)
            picture = cv2.cvtColor(self._rgb, cv2.COLOR_RGB2BGR)
        _, data = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])
        return data.tobytes()

    def pick(self, camera: Camera, opened: frozenset[int], u: float, v: float) -> int:
        with self._lock:
            self._set_open(opened)
            self._renderer.render(camera.x, camera.y, EYE_M, camera.yaw, camera.pitch_deg, instance=self._instance)
            return int(self._instance[min(HEIGHT - 1, int(v * HEIGHT)), min(WIDTH - 1, int(u * WIDTH))])

    def _set_open(self, opened: frozenset[int]) -> None:
        for thing in self._open ^ opened:
            self._renderer.set_open(thing, 1.0 if thing in opened else 0.0)
        self._open = opened


class Walks:
    """Walks through several homes; those not used for the longest time are dropped."""

    def __init__(self) -> None:
        self._walks: OrderedDict[str, _Walk] = OrderedDict()
        self._lock = threading.Lock()

    def frame(self, house: House, camera: Camera, opened: frozenset[int]) -> bytes:
        """What the camera sees, as JPEG.

        Args:
            house: the home.
            camera: the camera.
            opened: numbers of the things that are open.
        """
        return self._of(house).frame(camera, opened)

    def pick(self, house: House, camera: Camera, opened: frozenset[int], u: float, v: float) -> int | None:
        """Which thing is at a point of the picture.

        Args:
            house: the home.
            camera: the camera.
            opened: numbers of the things that are open.
            u: position from the left, 0 to 1.
            v: position from the top, 0 to 1.

        Returns:
            Number of the item; None for walls, floor, ceiling and sky.
        """
        found = self._of(house).pick(camera, opened, u, v)
        return found if 0 <= found < house.n_items else None

    def _of(self, house: House) -> _Walk:
        name = house.spec.name
        with self._lock:
            if name not in self._walks:
                self._walks[name] = _Walk(house)
            self._walks.move_to_end(name)
            while len(self._walks) > _MOST:
                self._walks.popitem(last=False)
            return self._walks[name]
