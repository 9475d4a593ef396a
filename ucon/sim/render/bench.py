"""Speed of the renderer, as a ratio to PyBullet's TinyRenderer measured in the same process.

CPU time of one thread. The two renderers take turns, frame block by frame block, so that a busy machine slows both
alike. TinyRenderer renders without shadows (with its default, shadows, it would be half as fast) and returns numpy
arrays.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from statistics import median

import numpy as np

from ucon.core.progress import ticked
from ucon.core.rng import stream
from ucon.sim.house import House
from ucon.sim.render.raster_renderer import RasterRenderer, warm_up
from ucon.sim.render.tiny import TinyRenderer

BENCH_SCENES = (
    "Rs_int",
    "grocery_store_cafe",
    "Beechwood_0_int",
    "Wainscott_0_int",
    "Merom_1_int",
    "house_single_floor",
    "office_large",
    "restaurant_brunch",
)
CAMERA_M = 1.25
POSES = 64

Pose = tuple[float, float, float, int, int]


def free_poses(house: House, count: int = POSES, seed: int = 0) -> list[Pose]:
    """Camera poses at free nodes, with random heading and pitch of -30, 0 or 30 degrees.

    Args:
        house: the home.
        count: number of poses.
        seed: of the choice.
    """
    random = stream(seed, "renderer bench", house.spec.name)
    nodes = np.argwhere(house.grid.free)
    chosen = nodes[random.integers(len(nodes), size=count)]
    headings, pitches = random.integers(4, size=count), random.integers(-1, 2, size=count) * 30
    places = house.grid.xy(chosen)
    return [
        (float(x), float(y), CAMERA_M, int(h), int(p)) for (x, y), h, p in zip(places, headings, pitches, strict=True)
    ]


def bench_renderer(houses: Sequence[House], poses: int = POSES, rounds: int = 4) -> dict[str, float]:
    """Ratios to TinyRenderer over several homes, and microseconds a frame.

    Keys: ``renderer_ratio_128``, ``renderer_ratio_128_flat`` and ``renderer_ratio_224`` (median over the homes), each
    also with ``_worst``; ``renderer_us_128``, ``renderer_us_128_flat``, ``renderer_us_224``, ``renderer_us_counts``.
    All render colour, depth and instance numbers, except ``counts``, which only counts pixels.

    Args:
        houses: the homes.
        poses: of the camera in each home.
        rounds: of the measurement.
    """
    warm_up()
    figures: dict[str, list[float]] = {}
    for house in ticked("frames", houses):
        for key, value in bench_house(house, poses, rounds).items():
            figures.setdefault(key, []).append(value)
    result = {key: round(median(values), 1) for key, values in figures.items()}
    for key in [key for key in figures if key.startswith("renderer_ratio")]:
        result[f"{key}_worst"] = round(min(figures[key]), 1)
    return result


def bench_house(house: House, poses: int = POSES, rounds: int = 4) -> dict[str, float]:
    """The measurements of one home; see :func:`bench_renderer`."""
    views = free_poses(house, poses)
    figures: dict[str, float] = {}
    for size in (128, 224):
        textured, flat = RasterRenderer(size, size), RasterRenderer(size, size, textured=False)
        tiny = TinyRenderer(size, size, oracle=True)
        for renderer in (textured, flat, tiny):
            renderer.load(house)
        drawers: dict[str, Callable[[Pose], None]] = {
            f"{size}": _draw_all(textured, size),
            f"{size}_flat": _draw_all(flat, size),
            "counts": _count(textured),
        }
        seconds = _interleaved(_draw_all(tiny, size), drawers, views, rounds)
        tiny.close()
        for name, (ours, reference) in seconds.items():
            if name == "224_flat" or (name == "counts" and size != 128):
                continue
            figures[f"renderer_us_{name}"] = ours * 1e6
            if name != "counts":
                figures[f"renderer_ratio_{name}"] = reference / ours
    return figures


def _draw_all(renderer: RasterRenderer | TinyRenderer, size: int) -> Callable[[Pose], None]:
    rgb, depth = np.empty((size, size, 3), np.uint8), np.empty((size, size), np.float32)
    instance = np.empty((size, size), np.int16)
    return lambda pose: renderer.render(*pose, rgb, depth, instance)


def _count(renderer: RasterRenderer) -> Callable[[Pose], None]:
    counts = np.empty(renderer.n_instances, np.int32)

    def count(pose: Pose) -> None:
        renderer.visible(*pose, counts)

    return count


def _interleaved(
    reference: Callable[[Pose], None], drawers: dict[str, Callable[[Pose], None]], views: list[Pose], rounds: int
) -> dict[str, tuple[float, float]]:
    """Median CPU seconds a frame over the rounds, of each drawer and of the reference in the same rounds."""
    times: dict[str, list[float]] = {name: [] for name in drawers}
    slow: list[float] = []
    share = max(1, len(views) // rounds)
    for turn in range(rounds):
        slow.append(_cpu_seconds(reference, views[turn * share : (turn + 1) * share]))
        for name, draw in drawers.items():
            times[name].append(_cpu_seconds(draw, views))
    return {name: (median(values), median(slow)) for name, values in times.items()}


def _cpu_seconds(draw: Callable[[Pose], None], views: list[Pose]) -> float:
    draw(views[0])
    start = time.process_time()
    for view in views:
        draw(view)
    return (time.process_time() - start) / len(views)
