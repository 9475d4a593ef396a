"""Kernels that assign the boxes of a frame to tracks, and count the pixels that tracks share with instances."""

from __future__ import annotations

import numpy as np

from ucon.core.jit import F64, I16, I32, jit


@jit
def associate(
    extent: F64, count: I32, label: I32, most_m: F64, boxes: F64, labels: I32, gate_m: float, track: I16
) -> None:
    """Give the boxes of a frame to the tracks that they fit best, the best pair first; a track takes one box.

    Args:
        extent: (n, 6) float64, 3-D boxes of the frame, metres.
        count: (n,) int32, pixels; boxes without any join no track.
        label: (n,) int32, number of each box's name.
        most_m: (n,) float64, longest plausible diagonal of a thing of that name.
        boxes: (T, 6) float64, 3-D boxes of the tracks, updated.
        labels: (T,) int32, numbers of their names.
        gate_m: largest gap.
        track: (n,) int16, written: the track, -1 for none.
    """
    n, n_tracks = extent.shape[0], boxes.shape[0]
    cost, taken = np.full((n_tracks, n), np.inf), np.zeros(n_tracks, np.bool_)
    track[:] = -1
    for old in range(n_tracks):
        for k in range(n):
            if count[k] > 0 and labels[old] == label[k]:
                cost[old, k] = _misfit(boxes[old], extent[k], most_m[k], gate_m)
    for _ in range(n):
        best, lowest = (-1, -1), np.inf
        for old in range(n_tracks):
            for k in range(n):
                if cost[old, k] < lowest and track[k] < 0 and not taken[old]:
                    best, lowest = (old, k), cost[old, k]
        if best[0] < 0:
            break
        track[best[1]], taken[best[0]] = best[0], True
    for k in range(n):
        if track[k] >= 0:
            for axis in range(3):
                boxes[track[k], axis] = min(boxes[track[k], axis], extent[k, axis])
                boxes[track[k], 3 + axis] = max(boxes[track[k], 3 + axis], extent[k, 3 + axis])


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
