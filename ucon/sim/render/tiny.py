"""PyBullet's TinyRenderer on meshes of the same polygons: the reference of the tests, and a slow alternative.

TinyRenderer would tessellate round shapes in its own way, so each link of an instance becomes one body whose mesh has
exactly the polygons that the rasteriser draws. It samples pixels at their lower left corner.
"""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import SceneError
from ucon.sim.arrangement import Arrangement
from ucon.sim.house import House
from ucon.sim.render.arena import Arena, ModelBuilder, catalogue_model
from ucon.sim.render.base import (
    SKY,
    SKY_DEPTH_M,
    VIEW_FOV_DEG,
    VIEW_PX,
    check_buffer,
    check_view,
    heading_cos_sin,
    pitch_cos_sin,
    tan_half,
)
from ucon.sim.render.parts import NEAR_M
from ucon.sim.render.shapes import INDEX

TINY_SAMPLE = (0.0, 1.0)
"""Point of a pixel that TinyRenderer samples, as fractions from its top left."""

_FAR_M = 80.0


class TinyRenderer:
    """Renders by PyBullet, about 100 times slower; see :class:`~ucon.sim.render.base.Renderer`.

    Each link of an instance has one flat colour. ``close`` frees the PyBullet client.
    """

    def __init__(
        self,
        width: int = VIEW_PX,
        height: int = VIEW_PX,
        fov_deg: float = VIEW_FOV_DEG,
        *,
        builder: ModelBuilder = catalogue_model,
        oracle: bool = False,
        counting_fov_deg: float = VIEW_FOV_DEG,
    ) -> None:
        """Set the image; load a home before rendering.

        Args:
            width: of images, pixels.
            height: of images, pixels.
            fov_deg: horizontal angle of view.
            builder: where models come from.
            oracle: used on purpose as a reference; suppresses the warning about its speed.
            counting_fov_deg: angle of the canonical view, in which pixels are counted.

        Raises:
            ConfigError: size or angle out of range.
        """
        check_view(width, height, fov_deg)
        if not oracle:
            warnings.warn(
                "rendering with PyBullet's TinyRenderer, about 100 times slower than renderer 'raster' and without "
                "materials: its timings and pictures must not be reported as UcON's",
                RuntimeWarning,
                stacklevel=2,
            )
        import pybullet

        self.width, self.height, self.fov_deg = width, height, fov_deg
        self._counting_fov_deg = counting_fov_deg
        self._bullet: Any = pybullet
        self._client: int = pybullet.connect(pybullet.DIRECT)
        self._builder = builder
        self._bodies: dict[int, list[int]] = {}
        self._instance_of = np.empty(0, np.int16)
        self._arena: Arena | None = None

    def __reduce__(self) -> Any:
        """Refuse copies: it holds a PyBullet client."""
        raise SceneError("renderer=tiny: an environment with a PyBullet client can be neither copied nor pickled")

    def close(self) -> None:
        """Disconnect from PyBullet."""
        if self._client >= 0:
            self._bullet.disconnect(physicsClientId=self._client)
            self._client = -1

    @property
    def arena(self) -> Arena:
        """The geometry that is drawn.

        Raises:
            SceneError: no home is loaded.
        """
        if self._arena is None:
            raise SceneError("the renderer has no home yet: call load(house, arrangement) first")
        return self._arena

    @property
    def n_instances(self) -> int:
        """Number of instances of the home and objects of the episode."""
        return self.arena.n_instances

    def load(self, house: House, arrangement: Arrangement | None = None) -> None:
        """Load a home with an arrangement, everything closed."""
        self._arena = Arena(house, arrangement or Arrangement(), self._builder)
        if self._client < 0:  # it was closed
            self._client = self._bullet.connect(self._bullet.DIRECT)
        self._bullet.resetSimulation(physicsClientId=self._client)
        self._bodies = {}
        for instance in range(self.n_instances):
            self._build(instance)
        self._index_bodies()

    def set_open(self, instance: int, fraction: float) -> None:
        """Open all joints of an instance to a fraction (0 to 1) of their travel, with what its drawers hold."""
        for moved in self.arena.set_open(instance, fraction):
            for body in self._bodies.pop(moved, []):
                self._bullet.removeBody(body, physicsClientId=self._client)
            self._build(moved)
        self._index_bodies()

    def _build(self, instance: int) -> None:
        tables = self.arena.tables
        first, count = (int(v) for v in tables.groups[instance])
        links: dict[int, list[int]] = {}
        for part in range(first, first + count):
            links.setdefault(int(tables.parts[part, 4]), []).append(part)
        self._bodies[instance] = [self._body(parts) for parts in links.values()]

    def _body(self, parts: list[int]) -> int:
        """A body whose corners are given in the world, each face with its own corners and normal."""
        tables = self.arena.tables
        corners: list[list[float]] = []
        normals: list[list[float]] = []
        triangles: list[int] = []
        for part in parts:
            v0, _, f0, faces, _ = (int(v) for v in tables.parts[part])
            for face in range(f0, f0 + faces):
                start, sides = (int(v) for v in tables.face_topology[face])
                base = len(corners)
                corners += tables.vertices[v0 + INDEX[start : start + sides].astype(np.int64)].tolist()
                normals += [tables.face_planes[face, :3].tolist()] * sides
                for k in range(1, sides - 1):
                    triangles += [base, base + k, base + k + 1]
        color = tables.face_color[tables.parts[parts[0], 2], :3] / 255
        shape = self._bullet.createVisualShape(
            self._bullet.GEOM_MESH,
            vertices=corners,
            indices=triangles,
            normals=normals,
            rgbaColor=[*color.tolist(), 1.0],
            physicsClientId=self._client,
        )
        body: int = self._bullet.createMultiBody(0, -1, shape, physicsClientId=self._client)
        return body

    def _index_bodies(self) -> None:
        """Instance number by body number; the last entry, which -1 reads, is the sky."""
        most = max((body for bodies in self._bodies.values() for body in bodies), default=-1)
        self._instance_of = np.full(most + 2, SKY, np.int16)
        for instance, bodies in self._bodies.items():
            self._instance_of[bodies] = instance

    def render(
        self,
        x: float,
        y: float,
        z: float,
        heading: float,
        pitch_deg: float,
        rgb: NDArray[np.uint8] | None = None,
        depth: NDArray[np.float32] | None = None,
        instance: NDArray[np.int16] | None = None,
        counts: NDArray[np.int32] | None = None,
    ) -> None:
        """Render into the caller's buffers; see :meth:`Renderer.render <ucon.sim.render.base.Renderer.render>`.

        Raises:
            ConfigError: a buffer has the wrong shape, type or layout.
            SceneError: no home is loaded.
        """
        shape = (self.height, self.width)
        color, z_buffer, bodies = self._image(self.width, self.height, self.fov_deg, (x, y, z), heading, pitch_deg)
        if rgb is not None:
            check_buffer("rgb", rgb, (*shape, 3), np.uint8)
            rgb[:] = color[:, :, :3]
        if depth is not None:
            check_buffer("depth", depth, shape, np.float32)
            depth[:] = np.where(bodies < 0, SKY_DEPTH_M, _FAR_M * NEAR_M / (_FAR_M - (_FAR_M - NEAR_M) * z_buffer))
        if instance is not None:
            check_buffer("instance", instance, shape, np.int16)
            instance[:] = self._instance_of[bodies]
        if counts is not None:
            self.visible(x, y, z, heading, pitch_deg, counts)

    def visible(
        self,
        x: float,
        y: float,
        z: float,
        heading: float,
        pitch_deg: float,
        counts: NDArray[np.int32] | None = None,
    ) -> NDArray[np.int32]:
        """Pixels of every instance in the canonical view, (n_instances,) int32.

        See :meth:`Renderer.visible <ucon.sim.render.base.Renderer.visible>` for the arguments.
        """
        if counts is None:
            counts = np.empty(self.n_instances, np.int32)
        check_buffer("counts", counts, (self.n_instances,), np.int32)
        bodies = self._image(VIEW_PX, VIEW_PX, self._counting_fov_deg, (x, y, z), heading, pitch_deg)[2]
        seen = self._instance_of[bodies]
        counts[:] = np.bincount(seen[seen >= 0], minlength=self.n_instances)
        return counts

    def _image(
        self, width: int, height: int, fov_deg: float, eye: tuple[float, float, float], heading: float, pitch_deg: float
    ) -> tuple[NDArray[np.uint8], NDArray[np.float32], NDArray[np.int32]]:
        view, projection = camera_matrices(width, height, fov_deg, eye, heading, pitch_deg)
        image = self._bullet.getCameraImage(
            width,
            height,
            view,
            projection,
            shadow=0,
            renderer=self._bullet.ER_TINY_RENDERER,
            physicsClientId=self._client,
        )
        color, z_buffer, bodies = (np.asarray(part) for part in image[2:5])
        return color.reshape(height, width, 4), z_buffer.reshape(height, width), bodies.reshape(height, width)


def camera_matrices(
    width: int, height: int, fov_deg: float, eye: tuple[float, float, float], heading: float, pitch_deg: float
) -> tuple[list[float], list[float]]:
    """View and projection matrix of a camera, column by column as PyBullet takes them.

    Args:
        width: of the image, pixels.
        height: of the image, pixels.
        fov_deg: horizontal angle of view.
        eye: position, world metres.
        heading: quarter turns.
        pitch_deg: degrees, up positive.
    """
    (c, s), (cp, sp) = heading_cos_sin(heading), pitch_cos_sin(pitch_deg)
    right, up, ahead = (np.array(v) for v in ((s, -c, 0.0), (-c * sp, -s * sp, cp), (c * cp, s * cp, sp)))
    view = np.eye(4)
    view[:3, :3] = right, up, -ahead
    view[:3, 3] = -view[:3, :3] @ eye
    tan_x = tan_half(fov_deg)
    projection = np.zeros((4, 4))
    projection[0, 0], projection[1, 1] = 1 / tan_x, width / height / tan_x
    projection[2, 2] = (_FAR_M + NEAR_M) / (NEAR_M - _FAR_M)
    projection[2, 3] = 2 * _FAR_M * NEAR_M / (NEAR_M - _FAR_M)
    projection[3, 2] = -1.0
    return view.T.reshape(-1).tolist(), projection.T.reshape(-1).tolist()
