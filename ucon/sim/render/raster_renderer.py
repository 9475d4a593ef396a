"""The default renderer: a software rasteriser that needs neither a GPU nor a display."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import SceneError
from ucon.core.sharing import PartlyShared
from ucon.objects.model import Material, ObjectModel, Part
from ucon.scenes.spec import HomeSpec, Item, Room
from ucon.sim.arrangement import Arrangement, PlacedObject
from ucon.sim.house import House, NavGrid
from ucon.sim.render.arena import Arena, ModelBuilder, catalogue_model
from ucon.sim.render.base import (
    VIEW_FOV_DEG,
    VIEW_PX,
    check_buffer,
    check_view,
    heading_cos_sin,
    pitch_cos_sin,
    tan_half,
)
from ucon.sim.render.raster import rasterise
from ucon.sim.render.shading import resolve
from ucon.sim.render.spans import BLOCK_PX

_NO_RGB = np.empty((0, 0, 3), np.uint8)
_NO_DEPTH = np.empty((0, 0), np.float32)
_NO_INSTANCE = np.empty((0, 0), np.int16)
_NO_COUNTS = np.empty(0, np.int32)


class RasterRenderer(PartlyShared):
    """A numba visibility-buffer rasteriser with portal culling; see :class:`~ucon.sim.render.base.Renderer`."""

    def __init__(
        self,
        width: int = VIEW_PX,
        height: int = VIEW_PX,
        fov_deg: float = VIEW_FOV_DEG,
        *,
        textured: bool = True,
        builder: ModelBuilder = catalogue_model,
        sample: tuple[float, float] = (0.5, 0.5),
        cull: bool = True,
        counting_fov_deg: float = VIEW_FOV_DEG,
    ) -> None:
        """Set the image; load a home before rendering.

        Args:
            width: of images, pixels.
            height: of images, pixels.
            fov_deg: horizontal angle of view.
            textured: procedural textures and shading by distance; otherwise one flat colour per face.
            builder: where models come from.
            sample: point of a pixel that is sampled, as fractions from its top left.
            cull: skip what is not visible; images are the same without.
            counting_fov_deg: angle of the canonical view, in which pixels are counted, as the rules set it.

        Raises:
            ConfigError: size or angle out of range.
        """
        check_view(width, height, fov_deg)
        self.width, self.height, self.fov_deg = width, height, fov_deg
        self.textured = textured
        self._builder = builder
        self._cull = cull
        self._camera = np.array([0, 0, 0, 1, 0, 1, 0, tan_half(fov_deg), *sample], np.float64)
        self._make_buffers()
        canonical = width == height == VIEW_PX and fov_deg == counting_fov_deg and sample == (0.5, 0.5)
        self._view: RasterRenderer | None = None if canonical else self._counting_view(counting_fov_deg)
        self._arena: Arena | None = None

    def _make_buffers(self) -> None:
        self._depth = np.empty(self.height * self.width + int(BLOCK_PX), np.float32)
        self._faces = np.empty(self.height * self.width + int(BLOCK_PX), np.int32)

    def __getstate__(self) -> dict[str, Any]:
        """State for pickles, without the buffers."""
        return {name: value for name, value in self.__dict__.items() if name not in ("_depth", "_faces")}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._make_buffers()

    def _counting_view(self, fov_deg: float) -> RasterRenderer:
        return RasterRenderer(
            fov_deg=fov_deg, textured=False, builder=self._builder, cull=self._cull, counting_fov_deg=fov_deg
        )

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
        self._show(Arena(house, arrangement or Arrangement(), self._builder))

    def _show(self, arena: Arena) -> None:
        self._arena = arena
        if self._view is not None:
            self._view._show(arena)

    def set_open(self, instance: int, fraction: float) -> None:
        """Open all joints of an instance to a fraction (0 to 1) of their travel, with what its drawers hold."""
        self.arena.set_open(instance, fraction)

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
        if rgb is not None:
            check_buffer("rgb", rgb, (*shape, 3), np.uint8)
        if depth is not None:
            check_buffer("depth", depth, shape, np.float32)
        if instance is not None:
            check_buffer("instance", instance, shape, np.int16)
        if counts is not None:
            check_buffer("counts", counts, (self.n_instances,), np.int32)
        if counts is not None and self._view is not None:
            self._view.visible(x, y, z, heading, pitch_deg, counts)
            counts = None
        self._rasterise(x, y, z, heading, pitch_deg)
        resolve(
            (self.width, self.height),
            self._faces,
            self._depth,
            self.arena.tables,
            self._camera,
            self.arena.rooms,
            self.arena.house.spec.wall_height_m,
            self.textured,
            _NO_RGB if rgb is None else rgb,
            _NO_DEPTH if depth is None else depth,
            _NO_INSTANCE if instance is None else instance,
            _NO_COUNTS if counts is None else counts,
        )

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
        if self._view is not None:
            return self._view.visible(x, y, z, heading, pitch_deg, counts)
        self.render(x, y, z, heading, pitch_deg, counts=counts)
        return counts

    def close(self) -> None:
        """Nothing to release."""

    def _rasterise(self, x: float, y: float, z: float, heading: float, pitch_deg: float) -> None:
        arena, camera = self.arena, self._camera
        camera[:7] = (x, y, z, *heading_cos_sin(heading), *pitch_cos_sin(pitch_deg))
        rasterise(
            camera,
            arena.tables,
            arena.rooms,
            arena.portals,
            arena.house.spec.wall_height_m,
            arena.room_start,
            arena.room_groups,
            self._cull,
            (self.width, self.height),
            self._depth,
            self._faces,
        )


def warm_up() -> None:
    """Compile every kernel, or load it from the disk.

    Call it once at set-up, and in a parent process before it starts workers.
    """
    part = Part("box", (0.2, 0.2, 0.2), (0.0, 0.0, 0.1), (128, 128, 128))
    room = Room("room", "room", (0.0, 0.0, 2.0, 2.0), (128, 128, 128), Material.TILE, (128, 128, 128))
    spec = HomeSpec("warm_up", "house", 2.5, (room,), (), (Item("thing", part.size, (1.0, 1.5, 0.0), 0, 0),))
    grid = NavGrid((0.0, 0.0), np.ones((8, 8), bool), np.zeros((8, 8), np.int16))
    house = House(spec, grid, np.zeros((4, 6)))
    placed = PlacedObject("thing", (1.5, 1.5, 0.0), (0.0, 0.0, 0.0, 1.0), 0, "ontop", 1)
    renderer = RasterRenderer(8, 8, builder=lambda category, size, tint: ObjectModel(category, part.size, (part,)))
    renderer.load(house, Arrangement(objects=(placed,)))
    rgb, depth = np.empty((8, 8, 3), np.uint8), np.empty((8, 8), np.float32)
    instance, counts = np.empty((8, 8), np.int16), np.empty(renderer.n_instances, np.int32)
    renderer.render(1.0, 0.5, 1.25, 1, 0, rgb, depth, instance, counts)
