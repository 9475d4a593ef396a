"""Contact sheets for visual inspection: every object in a small studio, every home as a plan with views from inside."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from ucon.core.rng import stream
from ucon.objects import build_model
from ucon.objects.model import Material
from ucon.scenes.plan import draw_plan
from ucon.scenes.spec import HomeSpec, Item, Room
from ucon.sim.cache import load_house
from ucon.sim.house import House, NavGrid
from ucon.sim.render import RasterRenderer

Picture = NDArray[np.uint8]

THUMB_PX = 176
LABEL_PX = 16
VIEW_PX = 320
STUDIO_M = 40.0
_EYE_M = 1.25


def catalogue_sheet(names: Sequence[str], path: Path, columns: int = 12) -> None:
    """Draw labelled thumbnails of categories; openable ones a second time with their joints open.

    Args:
        names: of the categories.
        path: image file to write.
        columns: of the sheet.
    """
    tiles = [(name, object_picture(name)) for name in names]
    tiles += [(f"{name} (open)", object_picture(name, 1.0)) for name in names if build_model(name).joints]
    _save(_grid(tiles, columns), path)


def object_picture(category: str, fraction: float = 0.0, size_px: int = THUMB_PX) -> Picture:
    """Image of one object alone, seen from its front left and above.

    Args:
        category: of the catalogue.
        fraction: of the travel of its joints.
        size_px: side of the image.

    Returns:
        (size_px, size_px, 3) uint8.
    """
    model = build_model(category)
    item = Item(category, model.size, (STUDIO_M / 2, STUDIO_M / 2, 0.0), 0, 0)
    house = _studio(item)
    renderer = RasterRenderer(size_px, size_px, 40.0)
    renderer.load(house)
    if model.joints and fraction:
        renderer.set_open(0, fraction)
    reach = 0.5 * float(np.linalg.norm(model.size))
    distance = max(2.9 * reach * (1.35 if fraction else 1.0), 0.12)
    center = np.array([STUDIO_M / 2, STUDIO_M / 2, model.size[2] / 2])
    # The camera is in front (+x) and to the left; a heading of 2.33 quarter turns looks back at the object.
    heading, pitch = 2.33, -18.0
    yaw, tilt = heading * np.pi / 2, np.radians(pitch)
    ahead = np.array([np.cos(yaw) * np.cos(tilt), np.sin(yaw) * np.cos(tilt), np.sin(tilt)])
    x, y, z = center - distance * ahead
    image = np.empty((size_px, size_px, 3), np.uint8)
    renderer.render(float(x), float(y), float(max(z, 0.02)), heading, pitch, rgb=image)
    return image


def scene_sheet(names: Sequence[str], path: Path, views: int = 4) -> None:
    """Draw each home as a row: its plan, then first-person views of several rooms.

    Args:
        names: of the homes.
        path: image file to write.
        views: number of rooms.
    """
    _save(np.concatenate([_scene_row(name, views) for name in names]), path)


def _scene_row(name: str, views: int) -> Picture:
    house = load_house(name)
    plan = Image.fromarray(draw_plan(house.spec))
    plan.thumbnail((2 * VIEW_PX, VIEW_PX))
    left = Image.new("RGB", (2 * VIEW_PX, VIEW_PX), (250, 250, 248))
    left.paste(plan, ((2 * VIEW_PX - plan.width) // 2, (VIEW_PX - plan.height) // 2))
    return np.concatenate([np.asarray(left), *room_views(house, views)], axis=1)


def room_views(house: House, count: int, size_px: int = VIEW_PX) -> list[Picture]:
    """Views of the largest rooms, each from the node and heading, of 24 random free nodes, that show the most things.

    Args:
        house: the home.
        count: number of rooms.
        size_px: side of the images.

    Returns:
        (size_px, size_px, 3) uint8 each.
    """
    renderer = RasterRenderer(size_px, size_px, 90.0)
    renderer.load(house)
    area = [(r.rect[2] - r.rect[0]) * (r.rect[3] - r.rect[1]) for r in house.spec.rooms]
    pictures = []
    for room in np.argsort(area)[::-1][:count]:
        x, y, heading = _best_view(house, renderer, int(room))
        image = np.empty((size_px, size_px, 3), np.uint8)
        renderer.render(x, y, _EYE_M, heading, -10.0, rgb=image)
        pictures.append(image)
    blank = np.full((size_px, size_px, 3), 250, np.uint8)
    return pictures + [blank] * (count - len(pictures))


def _best_view(house: House, renderer: RasterRenderer, room: int) -> tuple[float, float, int]:
    nodes = np.argwhere(house.grid.free & (house.grid.room == room))
    rng = stream(0, "sheet", house.spec.name, room)
    best, found = -1.0, (0.0, 0.0, 0)
    for i, j in nodes[rng.permutation(len(nodes))[:24]]:
        x, y = (float(v) for v in house.grid.xy((int(i), int(j))))
        for heading in range(4):
            counts = renderer.visible(x, y, _EYE_M, heading, -10.0)[: house.n_items]
            share = np.minimum(counts / 400.0, 1.0).sum() - 4.0 * (counts.max(initial=0) > 5000)
            if share > best:
                best, found = float(share), (x, y, heading)
    return found


def _studio(item: Item) -> House:
    """A large empty room around one item; nothing is settled or checked in it."""
    room = Room("studio", "studio", (0.0, 0.0, STUDIO_M, STUDIO_M), (206, 206, 202), Material.PLAIN, (232, 236, 240))
    spec = HomeSpec("studio", "studio", 30.0, (room,), (), (item,))
    cells = round(STUDIO_M / 0.25)
    grid = NavGrid((0.0, 0.0), np.ones((cells, cells), bool), np.zeros((cells, cells), np.int16))
    return House(spec, grid, np.zeros((1 + 3, 6)))


def _grid(tiles: Sequence[tuple[str, Picture]], columns: int) -> Picture:
    rows = -(-len(tiles) // columns)
    height = THUMB_PX + LABEL_PX
    sheet = Image.new("RGB", (columns * THUMB_PX, rows * height), (255, 255, 255))
    draw, font = ImageDraw.Draw(sheet), ImageFont.load_default(11)
    for number, (label, picture) in enumerate(tiles):
        x, y = number % columns * THUMB_PX, number // columns * height
        sheet.paste(Image.fromarray(picture), (x, y))
        draw.text((x + 3, y + THUMB_PX + 1), label[:28], fill=(30, 30, 30), font=font)
    return np.asarray(sheet)


def _save(picture: Picture, path: Path) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(picture).save(path)
