"""``python -m ucon report``: the file's content matches the runs' records."""

from __future__ import annotations

import base64
import gzip
import io
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from ucon.__main__ import main
from ucon.evaluation.figures.metrics import summarise
from ucon.evaluation.figures.paired import compare_records
from ucon.evaluation.kept.finished import FinishedRun
from ucon.evaluation.kept.record import read_records
from ucon.programs.two_searches import search_twice
from ucon.task.sets import load_episodes
from ucon.task.spoken import target_place

ROOT = Path(__file__).resolve().parents[3]


def packed_in(path: Path) -> dict[str, bytes]:
    """The packed data of a report, by name."""
    found = re.findall(r'<script type="application/x-packed" id="([^"]+)">([^<]*)</script>', path.read_text())
    return {name: base64.b64decode(text) for name, text in found}


def values_of(path: Path, name: str) -> Any:
    return json.loads(gzip.decompress(packed_in(path)[name]))


def test_figures_are_those_of_the_runs(report: Path, runs: tuple[Path, Path]) -> None:
    index = values_of(report, "index")
    for told, folder in zip(index["runs"], runs, strict=True):
        records = read_records(folder)
        figures = summarise(records)
        assert told["figures"]["sr"][0] == pytest.approx(figures["success_rate"], abs=1e-4)
        assert told["figures"]["spl"] == pytest.approx([figures["spl"], *figures["spl_ci95"]], abs=1e-4)
        assert [row["id"] for row in told["rows"]] == [record.episode for record in records]
        assert [row["found"] for row in told["rows"]] == [record.success for record in records]
    (pair,) = index["differences"]
    expected = compare_records(read_records(runs[1]), read_records(runs[0]))
    assert (pair["first"], pair["second"], pair["n"]) == (1, 0, 3)
    assert pair["spl"][0] == pytest.approx(expected.differences["spl"].mean, abs=1e-4)
    assert sum(group["runs"][0]["n"] for group in index["groups"]["home"]) == 3


def test_every_episode_is_told_as_it_was_recorded(report: Path, runs: tuple[Path, Path]) -> None:
    episodes = {episode.id: episode for episode in load_episodes("mini")}
    for number, folder in enumerate(runs):
        made = FinishedRun.read(folder).decisions()
        for k, record in enumerate(read_records(folder)):
            story, episode = values_of(report, f"episode-{number}-{k}"), episodes[record.episode]
            assert story["actions"] == record.actions
            assert len(story["poses"]) == len(story["frames"]) == record.steps + 1
            path = np.array(story["poses"])[:, :2]
            assert np.abs(np.diff(path, axis=0)).sum() == pytest.approx(record.path_length_m, abs=1e-3)
            assert len(story["blocked"]) == record.collisions
            assert len({step for step, _ in story["opened"]}) <= record.opens
            assert story["place"] == target_place(episode)
            assert [d["step"] for d in story["decisions"]] == [d.step for d in made[record.episode]]
            assert story["placed"]["objects"][story["target"]]["category"] == record.target


def test_beliefs_and_other_views_are_told(report: Path) -> None:
    story = values_of(report, "episode-0-0")
    steps = [step for step, _, _ in story["beliefs"]]
    assert len(steps) > 5
    assert steps == sorted(set(steps))
    shares = [share for _, things, _ in story["beliefs"] for _, _, share in things]
    assert 0 < max(shares) <= 1
    bounds = values_of(report, "home-0")["bounds"]
    for _, things, goal in story["beliefs"]:
        for _, (x0, y0, x1, y1), _ in things:
            assert bounds[0] - 0.5 <= x0 <= x1 <= bounds[2] + 0.5
            assert bounds[1] - 0.5 <= y0 <= y1 <= bounds[3] + 0.5
        assert goal is None or bounds[0] <= goal[0] <= bounds[2]
    others = [d["others"] for d in story["decisions"] if "others" in d]
    assert others
    assert all(why.startswith(("worth", "belief", "nothing")) for views in others for _, why in views)


def test_habits_are_those_of_the_agent(report: Path, runs: tuple[Path, Path]) -> None:
    texts, record = values_of(report, "texts"), read_records(runs[0])[0]
    story = values_of(report, "episode-0-0")
    habits = story["habits"]
    assert len(habits["given"]) == record.n_habits == len(story["relevance"])
    assert set(habits["given"]) <= set(habits["household"])
    assert set(habits["about"]) <= set(habits["household"])
    name = record.target.replace("_", " ")
    assert any(name.split()[-1] in texts[k].lower() for k in habits["about"])
    assert values_of(report, "episode-1-0")["habits"] is None  # frontier reads no habits


def test_pictures_are_small_and_of_each_step(report: Path) -> None:
    story, pictures = values_of(report, "episode-0-0"), packed_in(report)["pictures-0-0"]
    ends = story["ends"]
    assert ends[-1] == len(pictures)
    assert max(story["frames"]) == len(ends) - 1
    assert len(pictures) / len(ends) < 900
    image = Image.open(io.BytesIO(pictures[: ends[0]]))
    assert image.format == "WEBP"
    assert np.asarray(image).std() > 5


@pytest.mark.parametrize(("pictures", "least", "most"), [("none", 0, 0), ("key", 5, 60)])
def test_fewer_pictures_where_asked(
    pictures: str, least: int, most: int, runs: tuple[Path, Path], tmp_path: Path
) -> None:
    out = tmp_path / "report.html"
    assert main(["report", str(runs[0]), "--pictures", pictures, "--actions", "--out", str(out)]) == 0
    story = values_of(out, "episode-0-0")
    assert least <= len(story.get("ends", ())) <= most
    assert story["beliefs"] == []
    assert story["decisions"]


def test_a_report_is_beside_its_run_and_the_same_again(runs: tuple[Path, Path]) -> None:
    assert main(["report", str(runs[1])]) == 0
    first = (runs[1] / "report.html").read_bytes()
    assert main(["report", str(runs[1])]) == 0
    assert (runs[1] / "report.html").read_bytes() == first
    assert main(["verify", str(runs[1])]) == 0  # the run itself is untouched


def test_nothing_is_asked_of_elsewhere(report: Path) -> None:
    text = re.sub(r'id="[^"]+">[^<]*</script>', "", report.read_text())
    assert set(re.findall(r"https?://[^'\"\s]+", text)) <= {"http://www.w3.org/2000/svg"}
    assert "default-src 'none'" in text


def test_what_cannot_be_reported_is_said_in_one_line(
    runs: tuple[Path, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["report", str(tmp_path)]) == 2
    assert main(["report", str(runs[0]), "--out", "/proc/none/report.html"]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len([line for line in lines if line.startswith("error: ")]) == 2
    bare = next(path.parent for path in sorted((ROOT / "results").glob("*/summary.json"))
                if not list(path.parent.glob("episodes.jsonl*")))  # fmt: skip
    assert main(["report", str(bare)]) == 2
    assert "replay" in capsys.readouterr().err


def test_prompts_and_answers_of_a_language_agent_are_told(tmp_path: Path) -> None:
    words = ("agent=lgx", "episodes=mini", "limit=1")
    folder = search_twice(words, tmp_path, ["retrieval"], films=False)[0].folder
    assert main(["report", str(folder), "--pictures", "none"]) == 0
    story, record = values_of(folder / "report.html", "episode-0-0"), read_records(folder)[0]
    asked = [decision for decision in story["decisions"] if decision.get("asked")]
    assert sum(decision["asked"] for decision in asked) == record.language_calls > 0
    for decision in asked:
        ((system, situation, answer),) = decision["said"]
        assert record.target.replace("_", " ") in situation
        assert answer in [name for name, _ in decision["options"]]
        assert decision["options"][decision["chosen"]][0] == decision["words"]
        assert "habits" in system.lower()


def test_a_home_that_was_changed_since_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The ids of the episodes stay the same, but their content does not."""
    monkeypatch.setenv("UCON_CACHE", str(tmp_path / "cache"))
    monkeypatch.chdir(tmp_path)
    assert main(["home", "new", "my_home.yaml"]) == 0
    words = ("agent=frontier", "episodes=my_home.yaml")
    folder = search_twice(words, tmp_path / "runs", ["none"], films=False)[0].folder
    assert main(["report", str(folder), "--actions"]) == 0
    assert values_of(folder / "report.html", "index")["kinds"][0][0] == "own homes"
    home = Path("my_home.yaml").read_text()
    Path("my_home.yaml").write_text(home.replace("- mug", "- mug: on the desk"))
    assert Path("my_home.yaml").read_text() != home
    assert main(["report", str(folder), "--actions"]) == 2
    assert "names other episodes than those played" in capsys.readouterr().err
