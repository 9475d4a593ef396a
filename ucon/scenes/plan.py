"""Draws the floor plan of a home from above."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from ucon.objects.catalogue import catalogue
from ucon.scenes.spec import WALL_THICKNESS_M, HomeSpec, Item

_TALL_M = 1.8


def draw_plan(spec: HomeSpec, pixels_per_m: int = 50, labels: bool = True) -> NDArray[np.uint8]:
    """Plan of a home; items are rectangles with a mark at their front.

    Args:
        spec: the home.
        pixels_per_m: scale.
        labels: write categories and room names.

    Returns:
        (H, W, 3) uint8, y up.
    """
    rects = np.array([room.rect for room in spec.rooms])
    low, high = rects[:, :2].min(0) - 0.4, rects[:, 2:].max(0) + 0.4
    width, height = (int(v) for v in np.ceil((high - low) * pixels_per_m))
    image = Image.new("RGB", (width, height + 18), (250, 250, 248))
    draw = ImageDraw.Draw(image)

    def box(x0: float, y0: float, x1: float, y1: float) -> list[float]:
        return [
            (x0 - low[0]) * pixels_per_m,
            (high[1] - y1) * pixels_per_m,
            (x1 - low[0]) * pixels_per_m,
            (high[1] - y0) * pixels_per_m,
        ]

    half = WALL_THICKNESS_M / 2
    for room in spec.rooms:
        x0, y0, x1, y1 = room.rect
        wall = room.wall_color if room.outdoor else (60, 60, 64)
        draw.rectangle(box(x0 - half, y0 - half, x1 + half, y1 + half), fill=wall)
    for room in spec.rooms:
        x0, y0, x1, y1 = room.rect
        tint = tuple((2 * f + w + 255) // 4 for f, w in zip(room.floor_color, room.wall_color, strict=True))
        draw.rectangle(box(x0 + half, y0 + half, x1 - half, y1 - half), fill=tint)
    for o in spec.openings:
        hole = (
            (o.coord - half, o.lo, o.coord + half, o.hi)
            if o.axis == 0
            else (o.lo, o.coord - half, o.hi, o.coord + half)
        )
        draw.rectangle(box(*hole), fill=(255, 246, 210))
    for item in sorted(spec.items, key=lambda i: (i.position[2] + i.size[2] / 1000, i.category)):
        _draw_item(draw, item, box, labels)
    for room in spec.rooms:
        x, y = box(room.rect[0] + 0.1, room.rect[1], room.rect[2], room.rect[3] - 0.1)[:2]
        if labels:
            draw.text((x, y), room.name, fill=(150, 20, 20), font=_font(11))
    draw.text((4, height + 2), f"{spec.name}  ({len(spec.items)} items)", fill=(20, 20, 120), font=_font(13))
    return np.asarray(image)


def _font(size: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    return ImageFont.load_default(size)


def _draw_item(draw: ImageDraw.ImageDraw, item: Item, box: object, labels: bool) -> None:
    sx, sy = item.size[:2] if item.quarter_turns % 2 == 0 else (item.size[1], item.size[0])
    x, y = item.position[:2]
    row = catalogue()[item.category]
    area = box(x - sx / 2, y - sy / 2, x + sx / 2, y + sy / 2)  # type: ignore[operator]
    high = item.position[2] >= _TALL_M
    if high:
        draw.rectangle(area, outline=(230, 170, 40))
        return
    fill = tuple(int(0.75 * c + 55) for c in row.color)
    wall = row.mount == "wall"
    draw.rectangle(area, fill=fill, outline=(40, 90, 200) if item.category == "window" else (60, 50, 40))
    if not wall and item.size[0] > 0.25 and item.size[2] > 0.02:  # a dark line at the front
        cx, cy = (1, 0, -1, 0)[item.quarter_turns], (0, 1, 0, -1)[item.quarter_turns]
        fx, fy = x + cx * (sx / 2 - 0.04), y + cy * (sy / 2 - 0.04)
        wide = (0.03, sy / 3) if item.quarter_turns % 2 == 0 else (sx / 3, 0.03)
        draw.rectangle(box(fx - wide[0], fy - wide[1], fx + wide[0], fy + wide[1]), fill=(30, 30, 30))  # type: ignore[operator]
    if labels and (min(sx, sy) > 0.3 or (wall and max(sx, sy) > 0.5)) and item.size[2] > 0.02:
        draw.text((area[0] + 1, area[1]), item.category.replace("_", " ")[:12], fill=(10, 10, 10), font=_font(8))
