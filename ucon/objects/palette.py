"""Colours of shapes, and their lighter and darker variants."""

from __future__ import annotations

RGB = tuple[int, int, int]

BLACK: RGB = (28, 28, 30)
DARK: RGB = (60, 60, 64)
GREY: RGB = (140, 140, 142)
SILVER: RGB = (190, 192, 196)
WHITE: RGB = (240, 240, 238)
CREAM: RGB = (238, 228, 200)
PAPER: RGB = (246, 243, 232)
RED: RGB = (196, 40, 36)
ORANGE: RGB = (232, 130, 36)
YELLOW: RGB = (236, 200, 50)
GREEN: RGB = (62, 132, 56)
DARKGREEN: RGB = (36, 86, 42)
BLUE: RGB = (46, 92, 176)
NAVY: RGB = (36, 44, 88)
BROWN: RGB = (112, 74, 44)
DARKBROWN: RGB = (66, 42, 28)
WOOD: RGB = (168, 122, 76)
TAN: RGB = (206, 176, 128)
PINK: RGB = (228, 150, 172)
GOLD: RGB = (208, 168, 62)
COPPER: RGB = (184, 112, 68)
TERRACOTTA: RGB = (190, 104, 70)
GLASSY: RGB = (196, 220, 228)


def shade(color: RGB, factor: float) -> RGB:
    """A darker or lighter colour.

    Args:
        color: RGB, 0 to 255.
        factor: below 1 darker, above 1 lighter, up to white at 2.
    """
    if factor <= 1.0:
        return (int(color[0] * factor), int(color[1] * factor), int(color[2] * factor))
    gain = min(factor - 1.0, 1.0)
    r, g, b = (int(v + (255 - v) * gain) for v in color)
    return r, g, b
