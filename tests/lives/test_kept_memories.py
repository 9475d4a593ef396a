"""Memories in folders: equal after a kill, given to lives, refused if they do not fit, and what they know."""

from __future__ import annotations

import json
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.lives.short import short_life
from tests.models.playing import config_of
from ucon.__main__ import main
from ucon.core.errors import ConfigError, DataError, UconError
from ucon.evaluation.kept.folder import RunFolder
from ucon.evaluation.kept.seal import PARTIAL, RECORDS
from ucon.evaluation.kept_memories import Known, Truth, until
from ucon.fitting.place_model import GRID, cases_of, fitted, likelihood
from ucon.fitting.place_model import main as fit
from ucon.lives.clock import time_of
from ucon.lives.life import Life
from ucon.lives.sets import load_lives, save_lives
from ucon.lives.timeline import Timeline
from ucon.memory.log_file import log_name, save_log
from ucon.memory.place_model import PlaceModel, PlaceWeights
from ucon.memory.sighting_log import SeenThing, SightingLog
from ucon.memory.sightings_memory import SightingsMemory
from ucon.programs.evaluating import Evaluation

EACH = 6


@pytest.fixture(scope="module")
def life() -> Life:
    return short_life(1, requests=EACH)


@pytest.fixture(scope="module")
def base(life: Life, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("lives")
    save_lives([life], folder / "one.lives.xz")
    return folder


def run_of(base: Path, *words: str, out: str = "run") -> Evaluation:
    options = ("task=resident", "memory=sightings", f"episodes={base / 'one.lives.xz'}", "habit_level=none")
    quiet = ("progress=false", "pictures=0", "workers=0", f"out={base / out}")
    return Evaluation(config_of("frontier", *options, *quiet, *words), base / out)


@pytest.fixture(scope="module")
def kept(base: Path, life: Life) -> Path:
    """The folder with the memory of a whole run; next to it, the run and its partial file."""
    patch, finish = pytest.MonkeyPatch(), RunFolder.finish

    def keep_partial(self: RunFolder, *arguments: Any) -> None:
        shutil.copy(self.path / PARTIAL, base / PARTIAL)
        finish(self, *arguments)

    with patch.context() as patched:
        patched.setattr(RunFolder, "finish", keep_partial)
        run_of(base, f"memory.keep={base / 'kept'}").play()
    assert [path.name for path in (base / "kept").iterdir()] == [log_name(life.id)]
    return base / "kept"


@pytest.mark.parametrize("done", [(0, 1), (0, 1, 2, 3, 4), (1, 4)])
def test_after_a_kill_records_and_memory_are_the_same(base: Path, kept: Path, life: Life, done: Sequence[int]) -> None:
    lines, memory = (base / PARTIAL).read_bytes().splitlines(keepends=True), (kept / log_name(life.id)).read_bytes()
    whole = base / "whole"
    if not whole.exists():
        (base / "run").rename(whole)
    shutil.rmtree(base / "run", ignore_errors=True)
    (base / "run").mkdir()
    (base / "run" / PARTIAL).write_bytes(lines[0] + b"".join(lines[1 + k] for k in done))
    run_of(base, f"memory.keep={kept}").play()
    assert (base / "run" / RECORDS).read_bytes() == (whole / RECORDS).read_bytes()
    assert (kept / log_name(life.id)).read_bytes() == memory


def test_a_replay_leaves_what_is_kept_as_it_is(
    base: Path, life: Life, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "kept"
    run_of(base, f"memory.keep={folder}", out="played").play()
    (folder / log_name(life.id)).write_text("mine")
    assert main(["replay", str(base / "played"), "--workers", "0", "--out", str(tmp_path / "out")]) == 0
    assert "the same to the byte" in capsys.readouterr().out
    assert (folder / log_name(life.id)).read_text() == "mine"


def test_a_memory_of_later_or_of_another_version_is_refused(base: Path, kept: Path, life: Life, tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"it is day 0, .* reaches to day 1; start with an earlier") as raised:
        run_of(base, f"memory.given={kept}", out="later").play()
    assert "\n" not in str(raised.value)
    text = (kept / log_name(life.id)).read_text()
    (tmp_path / log_name(life.id)).write_text(text.replace('"format": 2', '"format": 1'))
    with pytest.raises(DataError, match="memory format 1, expected 2") as raised:
        run_of(base, f"memory.given={tmp_path}", out="old").play()
    assert "\n" not in str(raised.value)
    with pytest.raises(DataError, match=r"cannot be read .*begin without it"):
        run_of(base, f"memory.given={tmp_path / 'nowhere'}", out="nowhere").play()


def test_folders_that_do_not_fit_are_refused_in_one_line(tmp_path: Path) -> None:
    file = tmp_path / "file"
    file.write_text("x")
    with pytest.raises(ConfigError, match=r"cannot be written \(Not a directory\)") as raised:
        SightingsMemory(keep=str(file))
    assert "\n" not in str(raised.value)
    with pytest.raises(ConfigError, match=r"keep and given are both .*; choose another folder for keep") as raised:
        SightingsMemory(keep=str(tmp_path), given=f"{tmp_path}/.")
    assert "\n" not in str(raised.value)


def perfect(life: Life) -> SightingLog:
    """The log of a robot that sees everything in every slot."""
    log, truth, timeline = SightingLog(), Truth.of(life), Timeline(life)
    for time in range(3 * life.days):
        for k, one in enumerate(life.possessions):
            at = int(timeline.at[time, k])
            log.saw(one.category, truth.xyz[k][at], time, (truth.spots[k][at],))
    return log


@pytest.fixture(scope="module")
def whole_life() -> Life:
    return load_lives("lives_mini")[1]


def test_who_sees_all_writes_habits_and_knows_tomorrow(whole_life: Life) -> None:
    known = Known()
    known.add(whole_life, perfect(whole_life))
    assert known.precision().mean > 0.8
    assert known.recall().mean > 0.3
    nats = {name: value.mean for name, value in known.likelihoods().items()}
    assert nats["sightings"] == max(nats.values())
    assert known.better("sightings", "last seen").mean == pytest.approx(nats["sightings"] - nats["last seen"])


def test_who_sees_things_elsewhere_writes_no_habit(whole_life: Life) -> None:
    log = SightingLog()
    for day in range(4):
        for one in whole_life.possessions:
            log.saw(one.category, np.array([50.0, 50.0, 1.0]), time_of(day, 0), (("ontop", "bonsai"),))
    known = Known()
    known.add(whole_life, log)
    assert known.precision().mean == known.recall().mean == 0.0


def test_until_a_time_later_sightings_and_their_places_are_gone() -> None:
    one = SeenThing("mug", np.eye(3), [(0, 0), (3, 1), (6, 2)], [(2, 0), (4, 0), (5, 1)], [(), (), ()])
    before = until(one, 4)
    assert (before.seen, before.absent, len(before.places)) == ([(0, 0), (3, 1)], [(2, 0)], 2)
    assert until(one, 0).seen == []
    assert len(until(one, 0).places) == 0


def test_cases_know_only_what_was_seen_before_and_fitting_never_makes_it_worse(whole_life: Life) -> None:
    cases = list(cases_of(whole_life, perfect(whole_life)))
    assert len(cases) > 40
    for case in cases:
        assert max(time for time, _ in case.thing.seen) < case.time
        assert all(day <= case.time // 3 for day in case.news)
    some = cases[::8]
    best = fitted(some, PlaceWeights(use=0.1, doubt=3.0))
    assert likelihood(PlaceModel(best), some)[0] > likelihood(PlaceModel(PlaceWeights(use=0.1, doubt=3.0)), some)[0]
    assert all(getattr(best, name) in values for name, values in GRID.items() if name in ("use", "doubt"))


def test_commands_read_a_kept_memory(base: Path, kept: Path, capsys: pytest.CaptureFixture[str]) -> None:
    lives = str(base / "one.lives.xz")
    assert main(["lives", "known", lives, str(kept), "--json"]) == 0
    figures = json.loads(capsys.readouterr().out)
    assert figures["lives"] == 1
    assert figures["tomorrow"]["sightings"]["n"] > 0
    fit([lives, str(kept)])
    assert "PlaceWeights(use=" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("lives_train",), "lives_train has no end; give --limit LIVES and --out FILE"),
        (("lives_train", "--limit", "0", "--out", "x.lives.xz"), "--limit 0: expected a whole number from 1 up"),
        (("lives_train", "--limit", "-2", "--out", "x.lives.xz"), "--limit -2: expected a whole number from 1 up"),
        (("lives_trian", "--limit", "1", "--out", "x.lives.xz"), "did you mean lives_train"),
        (("lives_train", "--limit", "1"), "--limit without --out"),
    ],
)
def test_sets_that_cannot_be_made_are_refused_in_one_line(
    words: tuple[str, ...],
    said: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["lives", "make", *words]) != 0
    (line,) = capsys.readouterr().err.strip().splitlines()
    assert said in line
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("things", [{}, {"coffee_table": ()}])
def test_a_memory_that_says_nothing_is_refused_in_one_line(
    base: Path, life: Life, tmp_path: Path, things: dict[str, Any], capsys: pytest.CaptureFixture[str]
) -> None:
    log = SightingLog()
    log.things = {name: SeenThing(name) for name in things}
    save_log(log, tmp_path / log_name(life.id), life.id)
    assert main(["lives", "known", str(base / "one.lives.xz"), str(tmp_path)]) != 0
    said = capsys.readouterr().err.strip().splitlines()[-1]
    assert said.endswith("too little was seen there for any habit; play longer lives")
    with pytest.raises(UconError, match="no request for a thing that was seen before") as raised:
        fit([str(base / "one.lives.xz"), str(tmp_path)])
    assert "\n" not in str(raised.value)
    with pytest.raises(UconError, match=r"no memory of a life of .*memory\.keep=") as raised:
        fit([str(base / "one.lives.xz"), str(tmp_path / "empty")])
