"""``python -m ucon info``: the actions, and an episode's home, people and target."""

from __future__ import annotations

import json

import pytest

from ucon.__main__ import main
from ucon.habits import book
from ucon.task.actions import Action
from ucon.task.sets import load_episodes, save_episodes
from ucon.task.spoken import target_place


@pytest.mark.parametrize(("task", "differs"), [("paper", "at most 60"), ("released_code", "0.5, 1, 1.5 m")])
def test_the_seven_actions_by_the_rules(task: str, differs: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["info", "--task", task]) == 0
    first, *lines = capsys.readouterr().out.splitlines()
    assert first == f"task={task}: at most 300 steps, each one of seven actions"
    names = [action.name.lower().replace("_", " ") for action in Action]
    assert [line[:18].strip() for line in lines] == [f"{number}  {name}" for number, name in enumerate(names)]
    assert differs in lines[Action.LOOK_UP]


def test_whose_home_an_episode_plays_in(capsys: pytest.CaptureFixture[str]) -> None:
    episode = load_episodes("mini")[3]
    entry = book().entries[book().entry_number[episode.placed_by[episode.target][0]]]
    for word in ("3", episode.id):
        assert main(["info", word]) == 0
        told = capsys.readouterr().out
        target = episode.target_category.replace("_", " ")
        assert f"home: {episode.scene} (" in told
        assert f"\nwhose {target}: {entry.household}\n" in told
        assert f"\nkept {target_place(episode)} (" in told
        assert "\n  6  done " in told
    assert main(["info", "3", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["household"] == entry.household


def test_people_of_another_dataset_are_not_made_up(tmp_path, capsys) -> None:  # type: ignore[no-untyped-def]
    from dataclasses import replace

    file = tmp_path / "other.jsonl.xz"
    save_episodes([replace(load_episodes("mini")[3], habits="own", habits_hash="0" * 64)], file)
    assert main(["info", "0", "--episodes", str(file)]) == 0
    assert "people of the habit dataset 'own'; give it with --habits PATH" in capsys.readouterr().out


def test_no_such_episode_is_one_line_with_the_nearest(capsys: pytest.CaptureFixture[str]) -> None:
    name = load_episodes("mini")[3].id
    assert main(["info", name + "x"]) == 2
    assert f"expected a number from 0 to 49, or a name; did you mean {name}?" in capsys.readouterr().err
    assert main(["info", "0", "--episodes", "minni"]) == 2
    assert "did you mean mini?" in capsys.readouterr().err
