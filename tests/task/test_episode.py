"""Episodes as data: they survive storage in a file, and damage to the file gives one clear error."""

from __future__ import annotations

import json
import lzma
from dataclasses import replace
from pathlib import Path

import pytest

from ucon.core.errors import DataError, EpisodeError
from ucon.sim.arrangement import Arrangement, PlacedObject
from ucon.task.episode import Episode, Start
from ucon.task.sets import load_episodes, save_episodes


@pytest.fixture
def episode() -> Episode:
    cup = PlacedObject("coffee_cup", (1.25, 2.5, 0.75), (0.0, 0.0, 0.0, 1.0), 1, "ontop", 3)
    return Episode(
        id="a/1",
        scene="Rs_int",
        home_hash="0" * 64,
        habits="book",
        habits_hash="1" * 64,
        task="paper",
        seed=5,
        split="s",
        arrangement=Arrangement(removed=(4,), objects=(cup,), blocked=((2, 3),)),
        target=0,
        placed_by=(("coffee_cup/1", 2),),
        entries=("coffee_cup/1",),
        task_entries=("coffee_cup/1",),
        start=Start(4, 5, 2),
        shortest_path_m=2.25,
        solution="0006",
    )


def test_json_round_trip(episode: Episode) -> None:
    again = Episode.from_json(json.loads(json.dumps(episode.to_json())))
    assert again == episode
    assert again.hash == episode.hash
    assert replace(episode, seed=6).hash != episode.hash


def test_file_round_trip_and_same_bytes(episode: Episode, tmp_path: Path) -> None:
    path, other = tmp_path / "a.jsonl.xz", tmp_path / "b" / "a.jsonl.xz"
    save_episodes([episode, replace(episode, id="a/2")], path)
    save_episodes([episode, replace(episode, id="a/2")], other)
    assert [e.id for e in load_episodes(path)] == ["a/1", "a/2"]
    assert path.read_bytes() == other.read_bytes()


@pytest.mark.parametrize("position", [0.1, 0.5, 0.9])
@pytest.mark.parametrize("with_manifest", [True, False])
def test_a_flipped_bit_is_an_error(episode: Episode, tmp_path: Path, position: float, with_manifest: bool) -> None:
    path = tmp_path / "a.jsonl.xz"
    save_episodes([episode] * 5, path)
    if not with_manifest:
        (tmp_path / "MANIFEST.json").unlink()
    data = bytearray(path.read_bytes())
    data[int(len(data) * position)] ^= 4
    path.write_bytes(bytes(data))
    with pytest.raises(DataError, match="jsonl"):
        load_episodes(path)


def test_a_truncated_file_is_an_error(episode: Episode, tmp_path: Path) -> None:
    path = tmp_path / "a.jsonl.xz"
    save_episodes([episode] * 5, path)
    path.write_bytes(path.read_bytes()[:-20])
    with pytest.raises(DataError, match="truncated or altered"):
        load_episodes(path)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"target": 7}, "target 7"),
        ({"format": 99}, "format 99"),
        ({"start": [1, 2]}, "not a usable episode"),
        ({"solution": "0x"}, "digits 0 to 6"),
        ({"arrangement": {"removed": []}}, "not a usable episode"),
        ({"surprise": 1}, "surprise"),
    ],
)
def test_a_bad_line_names_file_and_line(episode: Episode, tmp_path: Path, change: dict, message: str) -> None:
    path = tmp_path / "bad.jsonl.xz"
    lines = [json.dumps(episode.to_json()), json.dumps(episode.to_json() | change)]
    path.write_bytes(lzma.compress("\n".join(lines).encode()))
    with pytest.raises(EpisodeError, match=message) as caught:
        load_episodes(path)
    assert "bad.jsonl.xz:2" in str(caught.value)


def test_unknown_set_suggests_the_known(tmp_path: Path) -> None:
    with pytest.raises(EpisodeError, match="unknown episode set or file 'no_such'"):
        load_episodes("no_such")
