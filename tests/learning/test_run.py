"""A run that is stopped anywhere and continued ends in the same bytes."""

import hashlib
import json
import os
import shutil
import signal

import pytest

from tests.learning.tiny import Line
from ucon.core.errors import ConfigError, DataError
from ucon.core.files import write_atomic
from ucon.learning.run import checkpoints
from ucon.learning.run import training_run as run_module
from ucon.learning.run.checkpoints import BEST, LATEST, CheckpointError
from ucon.learning.run.training_run import CARD, METRICS, SECONDS, SUMMARY, Interrupted, Plan, TrainingRun

PLAN = Plan(steps=23, validate_every=5, save_every=3, keep=2)


def begun(folder, learner=None, plan=PLAN):
    run = TrainingRun(folder, learner or Line(), plan, {"config": "x"})
    run.start("a: 1\n")
    return run


def files(folder):
    """All files in a folder except the one with the seconds it took."""
    found = {p.relative_to(folder).as_posix(): p.read_bytes() for p in folder.rglob("*") if p.is_file()}
    assert "seconds" in json.loads(found.pop(SECONDS))
    return found


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs") / "whole"
    begun(folder).run()
    return folder


def test_leaves_what_is_needed(whole):
    lines = [json.loads(line) for line in (whole / METRICS).read_text().splitlines()]
    assert [line["step"] for line in lines if "loss" in line] == list(range(1, 24))
    assert [line["step"] for line in lines if "val/score" in line] == [0, 5, 10, 15, 20, 23]
    summary = json.loads((whole / SUMMARY).read_text())
    assert summary["best"]["score"] == max(line.get("val/score", -99) for line in lines)
    card = (whole / CARD).read_text()
    assert card.startswith("# A line\n")
    assert (whole / "model" / "MANIFEST.json").is_file()
    content = (whole / "model" / "line.bin").read_bytes()
    digest = hashlib.sha256(content).hexdigest()
    assert summary["files"] == {"line.bin": {"bytes": len(content), "sha256": digest}}
    assert f"- `model/line.bin`, 8 bytes, SHA-256 `{digest}`" in card


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("at", [1, 5, 7, 22])
def test_a_signal_saves_and_the_rest_is_the_same(whole, tmp_path, number, at, capsys):
    learner = Line()
    learner.on_step = lambda done: os.kill(os.getpid(), number) if done == at else None
    handler = signal.getsignal(number)
    with pytest.raises(Interrupted) as stop:
        begun(tmp_path / "run", learner).run()
    assert (stop.value.step, stop.value.number) == (at, number)
    assert signal.getsignal(number) is handler
    assert capsys.readouterr().err == "stopping after this step, within 3 s; Ctrl-C again aborts it at once\n"
    again = TrainingRun(tmp_path / "run", Line(), PLAN, {"config": "x"})
    again.resume()
    assert again.step == at
    again.run()
    assert files(tmp_path / "run") == files(whole)


def test_a_killed_process_loses_only_what_it_does_again(whole, tmp_path):
    class KilledError(Exception):
        pass

    def kill(done):
        if done == 14:
            raise KilledError

    learner = Line()
    learner.on_step = kill
    with pytest.raises(KilledError):
        begun(tmp_path / "run", learner).run()
    with (tmp_path / "run" / METRICS).open("a") as file:
        file.write('{"loss": 1.0, "st')  # cut off while being written
    again = TrainingRun(tmp_path / "run", Line(), PLAN, {"config": "x"})
    again.resume()
    assert again.step == 12
    again.run()
    assert files(tmp_path / "run") == files(whole)


@pytest.mark.parametrize("pointer", [LATEST, BEST])
def test_a_process_killed_before_a_pointer_to_the_best_is_moved_ends_in_the_same(whole, tmp_path, monkeypatch, pointer):
    at = int(json.loads((whole / SUMMARY).read_text())["best"]["step"])

    class KilledError(Exception):
        pass

    def write(path, content):
        if path.name == pointer and content.startswith(f"step_{at:08d}"):
            raise KilledError
        write_atomic(path, content)

    monkeypatch.setattr(checkpoints, "write_atomic", write)
    with pytest.raises(KilledError):
        begun(tmp_path / "run").run()
    monkeypatch.undo()
    again = TrainingRun(tmp_path / "run", Line(), PLAN, {"config": "x"})
    again.resume()
    again.run()
    assert files(tmp_path / "run") == files(whole)


def test_seconds_of_interrupted_calls_are_added_up(tmp_path, monkeypatch):
    now = 0.0
    monkeypatch.setattr(run_module.time, "perf_counter", lambda: now)

    def stepping(last):
        def on_step(done):
            nonlocal now
            now += 10.0
            if done == last:
                os.kill(os.getpid(), signal.SIGTERM)

        learner = Line()
        learner.on_step = on_step
        return learner

    with pytest.raises(Interrupted):
        begun(tmp_path, stepping(7)).run()
    for seconds in (230.0, 230.0):  # until the end, and when continued after the end
        again = TrainingRun(tmp_path, stepping(None), PLAN, {"config": "x"})
        again.resume()
        assert "seconds" not in again.run()
        assert again.seconds == json.loads((tmp_path / SECONDS).read_text())["seconds"] == seconds


@pytest.mark.parametrize("name", ["summary.json", "model", "episodes.jsonl.partial", "episodes.jsonl.xz"])
def test_results_of_others_are_not_overwritten(tmp_path, name):
    """The results of an evaluation, or of a finished run whose checkpoints are gone."""
    (tmp_path / name).write_text("mine")
    with pytest.raises(ConfigError, match=rf"{name} belongs to another run and would be overwritten; choose another"):
        begun(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == [name]


def test_an_earlier_checkpoint_may_be_chosen(whole, tmp_path):
    run = begun(tmp_path / "run", plan=Plan(steps=23, validate_every=5, save_every=3, keep=5))
    run.run()
    again = TrainingRun(tmp_path / "run", Line(), run.plan, {"config": "x"})
    again.resume("step_00000018")
    assert again.step == 18
    again.run()
    assert (tmp_path / "run" / METRICS).read_bytes() == (whole / METRICS).read_bytes()


def test_a_run_whose_best_is_gone_finds_another(whole, tmp_path):
    run = begun(tmp_path / "run")
    run.run()
    for path in run.checkpoints.all()[:-1]:  # as if deleted by hand
        shutil.rmtree(path)
    (run.checkpoints.folder / BEST).unlink()
    longer = Plan(steps=28, validate_every=5, save_every=3)
    again = TrainingRun(tmp_path / "run", Line(), longer, {"config": "x"})
    again.resume()
    assert again.run()["best"]["step"] >= run.step


def test_refusals(whole, tmp_path):
    with pytest.raises(ConfigError, match="holds a run already; continue with resume="):
        begun(whole)
    for learner, identity in ((Line("b"), {"config": "x"}), (Line(), {"config": "y"})):
        with pytest.raises(CheckpointError, match="another run"):
            TrainingRun(whole, learner, PLAN, identity).resume()
    with pytest.raises(CheckpointError, match="start a new run"):
        TrainingRun(tmp_path, Line(), PLAN, {}).resume()
    (tmp_path / "file").write_text("")
    with pytest.raises(ConfigError, match="cannot be written"):
        begun(tmp_path / "file" / "run")
    with pytest.raises(ConfigError, match=r"training\.steps=0"):
        Plan(steps=0)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"steps": "abc"}, r"training\.steps=abc: expected a whole number from 1 to"),
        ({"steps": True}, r"training\.steps=True: expected a whole number"),
        ({"steps": 3, "keep": 1.5}, r"training\.keep=1\.5"),
        ({"steps": 3, "foo": 1}, r"unknown option 'training\.foo'"),
        ({"steps": 3, "kep": 1}, r"did you mean training\.keep"),
        ({"keep": 3}, r"training\.steps has no value"),
        (7, r"training=7: expected the options steps, "),
    ],
)
def test_plans_of_configurations(options, message):
    assert Plan.of({"steps": 3, "keep": 1}) == Plan(3, keep=1)
    with pytest.raises(ConfigError, match=message):
        Plan.of(options)


def test_spoilt_metrics_are_named_by_line(tmp_path):
    run = begun(tmp_path / "run")
    run.run()
    path = tmp_path / "run" / METRICS
    lines = path.read_text().splitlines()
    path.write_text("\n".join([*lines[:3], "nonsense", *lines[3:]]) + "\n")
    with pytest.raises(DataError, match=r"metrics\.jsonl:4"):
        TrainingRun(tmp_path / "run", Line(), PLAN, {"config": "x"}).resume()
