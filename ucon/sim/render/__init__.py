"""Renderers of a home: the software rasteriser, and PyBullet's renderer as its reference."""

from ucon.sim.render.base import SKY, SKY_DEPTH_M, VIEW_FOV_DEG, VIEW_PX, Renderer
from ucon.sim.render.raster_renderer import RasterRenderer, warm_up

__all__ = ["SKY", "SKY_DEPTH_M", "VIEW_FOV_DEG", "VIEW_PX", "RasterRenderer", "Renderer", "warm_up"]
