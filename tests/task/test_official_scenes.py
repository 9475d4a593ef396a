"""Sets from a user's file in the release's format: a scene where nothing can be placed is reported and left out."""

import json
from pathlib import Path
from typing import Any

import pytest

from ucon.configuration.wiring import official_habits
from ucon.core.errors import ConfigError
from ucon.habits import book
from ucon.habits.splits import entry_parts
from ucon.task.making.set_plans import HELD_OUT, MIN_HELD_OUT, set_orders


def task(name: str, *places: str) -> dict[str, Any]:
    return {
        "user_instruction": "A retired teacher who reads at night",
        "basic_object_name": name,
        "habits": [f"She always leaves the {name} there after dinner.", "It is mostly put away for the night."],
        "location": [f"{name}.place_{place}" for place in places],
    }


def release(folder: Path, content: dict[str, Any]) -> str:
    path = folder / "task.json"
    path.write_text(json.dumps(content))
    return str(path)


GOOD = {name: [task(name, "ontop(shelf)", "ontop(bed)")] for name in ("mug", "wallet", "apple")}
NOTHING_FITS = {"mug": [task("mug", "inside(wallet)")]}


def test_scenes_where_nothing_can_be_placed_are_listed_and_left_out(tmp_path: Path) -> None:
    dataset = official_habits(release(tmp_path, {"Rs_int": GOOD, "Ihlen_0_int": NOTHING_FITS, "Nowhere_int": GOOD}))
    said: list[str] = []
    orders = list(set_orders("official", dataset, left_out=said.append))
    assert len(orders) == 2000
    assert {order.scene for order in orders} == {"Rs_int"}
    assert all(order.targets for order in orders)
    assert [line.split(": left out")[0] for line in said] == ["Ihlen_0_int", "Nowhere_int"]
    assert not any("\n" in line for line in said)


def test_a_scene_that_is_held_out_altogether_asks_for_nothing_else(tmp_path: Path) -> None:
    names = book().categories[::6]
    all_of_it = {name: [task(name, "ontop(shelf)", "ontop(bed)")] for name in names}
    dataset = official_habits(release(tmp_path, {"Rs_int": all_of_it, "Ihlen_1_int": all_of_it}))
    parts = entry_parts(dataset)
    held = {e.category: all_of_it[e.category] for e in dataset.entries if e.scene == "Rs_int" and parts[e.id] == "test"}
    assert len(held) >= MIN_HELD_OUT
    for count in (1, MIN_HELD_OUT):
        some = dict(list(held.items())[:count])
        dataset = official_habits(release(tmp_path, {"Rs_int": some, "Ihlen_1_int": all_of_it}))
        said: list[str] = []
        orders = list(set_orders("official", dataset, left_out=said.append))
        assert all(order.targets for order in orders)
        assert {order.split for order in orders if order.scene == "Rs_int"} <= {HELD_OUT}
        assert bool(said) == (count < MIN_HELD_OUT)


def test_a_file_of_such_scenes_alone_is_one_line(tmp_path: Path) -> None:
    dataset = official_habits(release(tmp_path, {"Ihlen_0_int": NOTHING_FITS}))
    with pytest.raises(ConfigError, match="too little of 'official:task' can be placed in any of its scenes"):
        next(set_orders("official", dataset))
