"""Kernels of the noisy detector: which things of a frame are found, with which errors, and the spots that it shows.

The camera is that of :mod:`ucon.perception.mapping.map_kernels`. Random numbers are hashes of keys, so that an error
lasts: it depends on the thing (or spot), the side and the distance, never on the frame.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ucon.core.jit import F32, F64, I16, I32, jit, merged
from ucon.perception.mapping.map_kernels import FAR_M

#: False positives are drawn for cubes of this side, in metres.
SPOT_M = 0.5
#: Numbers drawn for one look: found, wrong, name, four edges, score.
FOUND, WRONG, NAME, EDGES, SCORE = 0, 1, 2, 3, 7
#: Most pixels of the canonical view that a thing is expected to have: nearer than that it never shows whole.
_WHOLE_PX = 4000.0
#: Standard deviations by which scores are higher at a recall of 1 than at 0, and by which all are lower; see ``score``.
_SIZE_SHIFT, _LEVEL = 0.8, 0.6


@jit
def outline(depth: F32, instance: I16, camera: F64, box: I32, middle: F64, count: I32) -> None:
    """Pixel box, mean point and pixel count of every instance.

    Args:
        depth: (H, W) float32, metres along the optical axis.
        instance: (H, W) int16, -1 where there is none.
        camera: (8,) float64.
        box: (n, 4) int32, written: left, top, right, bottom; right and bottom exclusive.
        middle: (n, 3) float64, written: mean of the visible points, metres in the start frame.
        count: (n,) int32, written: visible pixels.
    """
    rows, columns = depth.shape
    x, y, cam_z, c, s, cp, sp, focal_px = camera
    box[:, 0], box[:, 1], box[:, 2:] = columns, rows, 0
    middle[:] = 0.0
    count[:] = 0
    for v in range(rows):
        up, u = (0.5 * rows - v - 0.5) / focal_px, 0
        while u < columns:
            k, first, ahead, aside, n = instance[v, u], u, 0.0, 0.0, 0
            while u < columns and instance[v, u] == k:
                d = depth[v, u]
                if 0.0 < d < FAR_M:
                    ahead += d
                    aside += d * ((u + 0.5 - 0.5 * columns) / focal_px)
                    n += 1
                u += 1
            if k < 0 or n == 0:
                continue
            box[k, 0], box[k, 2] = min(box[k, 0], first), max(box[k, 2], u)
            box[k, 1], box[k, 3] = min(box[k, 1], v), max(box[k, 3], v + 1)
            middle[k, 0] += ahead
            middle[k, 1] += aside
            middle[k, 2] += ahead * up
            count[k] += n
    for k in range(len(count)):
        if count[k]:
            ahead, aside, rise = middle[k, 0] / count[k], middle[k, 1] / count[k], middle[k, 2] / count[k]
            f = cp * ahead - sp * rise
            middle[k, 0], middle[k, 1] = x + c * f + s * aside, y + s * f - c * aside
            middle[k, 2] = cam_z + sp * ahead + cp * rise


@jit
def hashed(key: Any, number: int) -> Any:
    """A hash (uint64) of a 64-bit key and a number: the finaliser of splitmix64 (Steele, Lea and Flood 2014)."""
    z = np.uint64(key) + np.uint64(0x9E3779B97F4A7C15) * (np.uint64(number) + np.uint64(1))
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return z ^ (z >> np.uint64(31))


@merged
def uniform(key: Any, number: int) -> float:
    """Number ``number`` of the uniform random numbers in [0, 1) of a key."""
    return (hashed(key, number) >> np.uint64(11)) * 2.0**-53


@jit
def normal(key: Any, number: int) -> float:
    """Number ``number`` of the standard normal random numbers of a key (Box and Muller)."""
    radius = np.sqrt(-2.0 * np.log(1.0 - uniform(key, 64 + 2 * number)))
    return radius * np.cos(2.0 * np.pi * uniform(key, 65 + 2 * number))


@jit
def score(key: Any, apart: float, right: bool, sure: float, least: float) -> float:
    """Score of a box, from ``least`` to 1.

    Args:
        key: of the look.
        apart: distance between the distributions of right and wrong boxes, in their standard deviations.
        right: whether a thing has its own name.
        sure: probability that a thing of this size is found; it moves both distributions by the same amount.
        least: boxes with a lower score are not reported.
    """
    z = normal(key, SCORE) + (0.5 if right else -0.5) * apart + _SIZE_SHIFT * (sure - 0.5) - _LEVEL
    return least + (1.0 - least) / (1.0 + np.exp(-z))


@jit
def _interpolated(x: float, curve: F64) -> float:
    """The curve (2, n) of positions and values at ``x``: linear, constant beyond the ends."""
    n = curve.shape[1]
    if x <= curve[0, 0]:
        return curve[1, 0]
    for k in range(1, n):
        if x < curve[0, k]:
            share = (x - curve[0, k - 1]) / (curve[0, k] - curve[0, k - 1])
            return curve[1, k - 1] + share * (curve[1, k] - curve[1, k - 1])
    return curve[1, n - 1]


@jit
def recall(pixels: float, surface_m2: float, away_m: float, focal_px: float, curves: Any) -> float:
    """Probability that a thing is found.

    Args:
        pixels: of the thing in the canonical view.
        surface_m2: of a box of its catalogue size; a quarter of it is what shows on average.
        away_m: distance of what shows of it, metres.
        focal_px: focal length of the canonical view, pixels.
        curves: see :meth:`ucon.perception.detectors.noise_rates.Rates.curves`.
    """
    sizes, shares, far = curves
    whole = min(0.25 * surface_m2 * (focal_px / max(away_m, 0.1)) ** 2, _WHOLE_PX)
    share = _interpolated(pixels / max(whole, 1e-9), shares)
    return _interpolated(np.log(max(pixels, 1e-9)), sizes) * share * _interpolated(away_m, far)


@jit
def things(
    key: int, camera: F64, counts: I32, surface_m2: F64, outlines: Any, curves: Any, rates: tuple[float, ...],
    found: Any,
) -> int:  # fmt: skip
    """The things of a frame that are found, with the errors of each look.

    Args:
        key: of the episode.
        camera: (8,) float64.
        counts: (n,) int32, pixels of the instances in the canonical view.
        surface_m2: (n,) float64, of a box of the catalogue's size; 0 for structure.
        outlines: box (n, 4), middle (n, 3) and count (n,) of :func:`outline`.
        curves: of the recall.
        rates: probability of a wrong name, distance of the score distributions, jitter, least score, least pixels, and
            the focal length of the canonical view.
        found: instance (n,) int32, name (n,) float64, score (n,) float64 and box (n, 4) float64, written. The name is
            -1 for the right one, else a uniform number that stands for a wrong one.

    Returns:
        How many things are found; as many rows are written, ordered by instance.
    """
    box, middle, count = outlines
    instance, name, scores, boxes = found
    false_labels, apart, jitter, least, min_pixels, focal_px = rates
    n = 0
    for k in range(counts.shape[0]):
        if counts[k] < min_pixels or count[k] == 0 or surface_m2[k] <= 0.0:
            continue
        dx, dy, dz = middle[k, 0] - camera[0], middle[k, 1] - camera[1], middle[k, 2] - camera[2]
        away_m = np.sqrt(dx * dx + dy * dy + dz * dz)
        side = int(np.floor(np.arctan2(dy, dx) / (np.pi / 4))) % 8
        octave = int(np.round(np.log2(max(away_m, 0.1))))
        look = hashed(hashed(hashed(key, k), side), octave + 8)
        sure = recall(counts[k], surface_m2[k], away_m, focal_px, curves)
        if uniform(look, FOUND) >= sure:
            continue
        wrong = uniform(look, WRONG) < false_labels
        instance[n], name[n] = k, uniform(look, NAME) if wrong else -1.0
        scores[n] = score(look, apart, not wrong, sure, least)
        for edge in range(4):
            length = box[k, 2 + edge % 2] - box[k, edge % 2]
            boxes[n, edge] = box[k, edge] + jitter * length * normal(look, EDGES + edge)
        n += 1
    return n


@jit
def _spots(depth: F32, camera: F64, grid: int, key: int, look: Any, pixel: I32) -> int:
    """The 0.5 m cubes that the pixels of a grid x grid raster of the frame show.

    Args:
        depth: (H, W) float32, metres along the optical axis.
        camera: (8,) float64.
        grid: raster pixels across and down.
        key: of the episode.
        look: (grid * grid,) uint64, written: key of the cube and of which of eight sides it is seen from.
        pixel: (grid * grid, 2) int32, written: column u and row v.

    Returns:
        How many raster pixels show a surface; as many rows are written.
    """
    rows, columns = depth.shape
    x, y, cam_z, c, s, cp, sp, focal_px = camera
    n = 0
    for a in range(grid):
        v = int((a + 0.5) * rows / grid)
        up = (0.5 * rows - v - 0.5) / focal_px
        for b in range(grid):
            u = int((b + 0.5) * columns / grid)
            d = depth[v, u]
            if not 0.0 < d < FAR_M:
                continue
            f, right = d * (cp - sp * up), d * ((u + 0.5 - 0.5 * columns) / focal_px)
            dx, dy = c * f + s * right, s * f - c * right
            i, j = int(np.floor((x + dx) / SPOT_M)), int(np.floor((y + dy) / SPOT_M))
            level = int(np.floor((cam_z + d * (sp + cp * up)) / SPOT_M))
            side = int(np.floor(np.arctan2(dy, dx) / (np.pi / 4))) % 8
            spot = ((i + 4096) * 8192 + j + 4096) * 128 + level + 64
            look[n] = hashed(hashed(hashed(key, -2), spot), side)
            pixel[n, 0], pixel[n, 1] = u, v
            n += 1
    return n


@jit
def false_boxes(
    key: int, depth: F32, camera: F64, grid: int, rates: tuple[float, ...], look: Any, pixel: I32, found: Any
) -> int:
    """False positives of a frame.

    Every raster pixel has the same chance. Pixels that show one spot from one side share one draw.

    Args:
        key: of the episode.
        depth: (H, W) float32, metres along the optical axis.
        camera: (8,) float64.
        grid: raster pixels across and down.
        rates: chance of a false box at one raster pixel, distance of the score distributions, least score.
        look: (grid * grid,) uint64, scratch.
        pixel: (grid * grid, 2) int32, scratch.
        found: pixel (g, 2) int32, name (g,) and score (g,) float64, written; the name is a uniform number.

    Returns:
        How many there are; as many rows are written, in the order of the raster.
    """
    chance, apart, least = rates
    at, name, scores = found
    shown, n = _spots(depth, camera, grid, key, look, pixel), 0
    for a in range(shown):
        alike, first = 0, True
        for b in range(shown):
            if look[b] == look[a]:
                first = first and b >= a
                alike += 1
        if not first or uniform(look[a], FOUND) >= alike * chance:
            continue
        at[n, 0], at[n, 1] = pixel[a, 0], pixel[a, 1]
        name[n], scores[n] = uniform(look[a], NAME), score(look[a], apart, False, 0.5, least)
        n += 1
    return n
