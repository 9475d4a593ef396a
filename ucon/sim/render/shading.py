"""From the visibility buffer to colours, depth, instance numbers and pixel counts."""

from __future__ import annotations

from typing import Any

import numpy as np

from ucon.sim.render.kernels import F32, F64, I16, I32, U8, jit


@jit
def resolve(
    faces: I32,
    inverse_depth: F32,
    tables: Any,
    camera: F64,
    rooms: F32,
    textured: bool,
    rgb: U8,
    depth: F32,
    instance: I16,
    counts: I32,
) -> None:
    """Fill the outputs that are not empty."""
    height, width = faces.shape
    want_rgb, want_instance, want_counts = rgb.size > 0, instance.size > 0, counts.size > 0
    counts[:] = 0
    for y in range(height):
        if depth.size > 0:
            for x in range(width):
                depth[y, x] = np.float32(1.0) / max(inverse_depth[y, x], np.float32(0.01))
        x0 = 0
        while x0 < width:
            f = faces[y, x0]
            x1 = x0 + 1
            while x1 < width and faces[y, x1] == f:
                x1 += 1
            if want_instance or want_counts:
                number = np.int16(tables.face_instance[f] if f >= 0 else -1)
                if want_instance:
                    for x in range(x0, x1):
                        instance[y, x] = number
                if want_counts and f >= 0:
                    counts[number] += x1 - x0
            if want_rgb:
                for x in range(x0, x1):
                    for k in range(3):
                        rgb[y, x, k] = tables.face_color[f, k] if f >= 0 else 200
            x0 = x1
