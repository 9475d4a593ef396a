"""Every configured agent plays episodes of a file in the official release's format, in both knowledge-base modes."""

from __future__ import annotations

import json
from functools import partial

import pytest

from tests.models.playing import AGENTS, config_of
from ucon.configuration.wiring import Factory, official_habits
from ucon.envs.knowledge import HabitSource
from ucon.envs.ucon_env import UcONEnv
from ucon.evaluation.playing.play import RunSpec
from ucon.evaluation.playing.runner import evaluate
from ucon.habits import HabitDataset
from ucon.habits.knowledge import MODES
from ucon.task.episode import Episode
from ucon.task.making.sampler import EpisodeSampler

HOME = "Rs_int"
PLACES = {
    "mug": ("ontop(breakfast_table)", "inside(bottom_cabinet)"),
    "wallet": ("ontop(coffee_table)", "ontop(bed)"),
    "bowl": ("ontop(countertop)", "inside(fridge)", "ontop(breakfast_table)"),
    "notebook": ("ontop(bed)", "ontop(sofa)"),
    "apple": ("inside(fridge)", "ontop(countertop)"),
    "candle": ("ontop(shelf)", "ontop(coffee_table)"),
}


@pytest.fixture(scope="module")
def played_from(tmp_path_factory: pytest.TempPathFactory) -> tuple[HabitDataset, list[Episode]]:
    tasks = [
        {
            "basic_object_name": target,
            "habits": [f"In the {number} week the {target} is left by the {place[:-1].partition('(')[2]}."],
            "location": [f"{target}.place_{place}" for place in places],
        }
        for target, places in PLACES.items()
        for number, place in zip(("first", "second"), places, strict=False)
    ]
    path = tmp_path_factory.mktemp("release") / "task.json"
    path.write_text(json.dumps({HOME: tasks}))
    dataset = official_habits(str(path))
    sampler = EpisodeSampler(dataset, k=len(PLACES))
    return dataset, [sampler.sample(HOME, seed) for seed in range(2)]


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("name", AGENTS)
def test_every_agent_plays_it(name: str, mode: str, played_from: tuple[HabitDataset, list[Episode]]) -> None:
    dataset, episodes = played_from
    source = HabitSource(dataset, mode=mode)
    for episode in episodes:  # each task of the file has one habit
        tasks = episode.entries if mode == "category" else episode.task_entries
        assert len(source.knowledge(episode, "full").rows) == len(tasks)
        assert len(tasks) == len(episode.arrangement.objects) * (2 if mode == "category" else 1)
    config = config_of(name)
    seen = {option: config["env"][option] for option in ("privileged", "observe", "width_px", "height_px")}
    env = partial(UcONEnv, episodes, habit_level="retrieval", source=source, detector=True, **seen)
    spec = RunSpec(Factory(config["agent"]), env, "retrieval")
    records = [played.record for played in evaluate(spec, episodes, workers=0)]
    assert [record.target for record in records] == [episode.target_category for episode in episodes]
    assert all(record.steps > 0 for record in records)
    if name == "oracle":
        assert all(record.success for record in records)
