"""Kernels that assign the boxes of a frame to tracks, and count the pixels that tracks share with instances."""

from __future__ import annotations

import numpy as np

from ucon.core.jit import F64, I16, I32, jit, merged

#: Added to the cost of a track that was never called by the box's name, so that tracks that were come first.
OTHER_NAME = 100.0
#: Two boxes of different names may be one thing if they share this part of the shorter side along every axis.
COMMON = 0.6
#: Sides of boxes count as at least this many metres.
THIN_M = 0.06


@jit
def associate(
    extent: F64, count: I32, label: I32, most_m: F64, boxes: F64, labels: I32, gate_m: float, track: I16
) -> None:
    """Give the boxes of a frame to the tracks that they fit best, the best pair first; a track takes one box.

    Tracks that were called by a box's name before come first; of the others, only those that the box covers count.

    Args:
        extent: (n, 6) float64, 3-D boxes of the frame, metres.
        count: (n,) int32, pixels; boxes without any join no track.
        label: (n,) int32, number of each box's name.
        most_m: (n,) float64, longest plausible diagonal of a thing of that name.
        boxes: (T, 6) float64, 3-D boxes of the tracks, updated.
        labels: (T, L) int32, numbers of their names so far, -1 where there are fewer; updated.
        gate_m: largest gap, metres.
        track: (n,) int16, written: the track, -1 for none.
    """
    cost = np.full((boxes.shape[0], extent.shape[0]), np.inf)
    for old in range(boxes.shape[0]):
        for k in range(extent.shape[0]):
            if count[k] > 0 and labels[old, 0] >= 0:
                cost[old, k] = _cost(boxes[old], labels[old], extent[k], label[k], most_m[k], gate_m)
    _assign(cost, track)
    for k in range(extent.shape[0]):
        if track[k] >= 0:
            _remember(labels[track[k]], label[k])
            for axis in range(3):
                boxes[track[k], axis] = min(boxes[track[k], axis], extent[k, axis])
                boxes[track[k], 3 + axis] = max(boxes[track[k], 3 + axis], extent[k, 3 + axis])


@jit
def _cost(old: F64, names: I32, new: F64, label: int, most_m: float, gate_m: float) -> float:
    """Cost of a 3-D box (6,) of a name for a track (its box and names); infinite where they cannot be one thing."""
    if _called(names, label):
        return _misfit(old, new, most_m, gate_m)
    if _covers(old, new):
        return OTHER_NAME + _misfit(old, new, np.inf, gate_m)
    return np.inf


@jit
def _assign(cost: F64, track: I16) -> None:
    """Give each box (column) the track (row) of the least cost, the cheapest pair first; a track takes one box."""
    taken = np.zeros(cost.shape[0], np.bool_)
    track[:] = -1
    for _ in range(cost.shape[1]):
        best, lowest = (-1, -1), np.inf
        for old in range(cost.shape[0]):
            for k in range(cost.shape[1]):
                if cost[old, k] < lowest and track[k] < 0 and not taken[old]:
                    best, lowest = (old, k), cost[old, k]
        if best[0] < 0:
            break
        track[best[1]], taken[best[0]] = best[0], True


@merged
def _called(names: I32, label: int) -> bool:
    """Whether a track (its names, (L,)) was called by a name before."""
    found = False
    for n in range(names.shape[0]):
        found = found or names[n] == label
    return found


@merged
def _remember(names: I32, label: int) -> None:
    """Add a name to those of a track (L,), where there is room."""
    for n in range(names.shape[0]):
        if names[n] == label:
            break
        if names[n] < 0:
            names[n] = label
            break


@merged
def _covers(a: F64, b: F64) -> bool:
    """Whether two 3-D boxes (6,) may be of one thing: much of each side in common, and sizes within a factor of two."""
    one, two, covers = 0.0, 0.0, True
    for axis in range(3):
        side_a, side_b = max(a[3 + axis] - a[axis], THIN_M), max(b[3 + axis] - b[axis], THIN_M)
        middle = 0.5 * (a[axis] + a[3 + axis] - b[axis] - b[3 + axis])
        common = 0.5 * (side_a + side_b) - abs(middle)
        covers = covers and common >= COMMON * min(side_a, side_b)
        one, two = one + side_a * side_a, two + side_b * side_b
    return covers and 0.25 < one / two < 4.0


@jit
def _misfit(old: F64, new: F64, most_m: float, gate_m: float) -> float:
    """How badly a 3-D box (6,) fits a track's; infinite where together they are too large or too far apart."""
    gap, between, whole, a, b = 0.0, 0.0, 0.0, 0.0, 0.0
    for axis in range(3):
        apart = max(old[axis] - new[3 + axis], new[axis] - old[3 + axis], 0.0)
        middle = 0.5 * (old[axis] + old[3 + axis] - new[axis] - new[3 + axis])
        side = max(old[3 + axis], new[3 + axis]) - min(old[axis], new[axis])
        gap, between, whole = gap + apart * apart, between + middle * middle, whole + side * side
        a, b = a + (old[3 + axis] - old[axis]) ** 2, b + (new[3 + axis] - new[axis]) ** 2
    # A box that is too large already, by a poor detection or a wrong name, may still join its own track.
    if np.sqrt(gap) > gate_m or np.sqrt(whole) > max(most_m, np.sqrt(a), 1.15 * np.sqrt(b)):
        return np.inf
    return np.sqrt(gap) + 0.1 * np.sqrt(between)


@jit
def overlaps(image: I16, instance: I16, row: I32, pixels: I32) -> None:
    """Count the pixels that tracks and the simulator's instances share.

    Args:
        image: (H, W) int16, track of every pixel, -1 for none.
        instance: (H, W) int16, instance of every pixel, -1 for none.
        row: (most track + 2,) int32, row of each track in ``pixels``, -1 for tracks that are not counted.
        pixels: (m, n + 1) int32, updated; column 0 is for pixels of no instance.
    """
    for v in range(image.shape[0]):
        for u in range(image.shape[1]):
            track = image[v, u]
            if 0 <= track < row.shape[0] and row[track] >= 0:
                pixels[row[track], instance[v, u] + 1] += 1
