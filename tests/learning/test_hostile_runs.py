"""Run folders from others: errors are one line, and nothing outside the folders is read, written or deleted."""

import json
import os
import shutil

import pytest
import torch
from safetensors.torch import load, save

from tests.learning.test_run import PLAN, begun
from tests.learning.tiny import Line
from ucon.core.errors import DataError
from ucon.core.files import write_manifest
from ucon.learning.run.checkpoints import TENSORS, VALUES
from ucon.learning.run.protocol import State
from ucon.learning.run.training_run import TrainingRun

LAST = "step_00000023"


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs") / "whole"
    begun(folder).run()
    return folder


@pytest.fixture
def run(whole, tmp_path):
    return shutil.copytree(whole, tmp_path / "run")


@pytest.fixture
def elsewhere(whole, tmp_path):
    """The user's own run, which must not be touched."""
    return shutil.copytree(whole, tmp_path / "elsewhere")


def content(folder):
    return {str(p.relative_to(folder)): p.read_bytes() if p.is_file() else None for p in folder.rglob("*")}


def refused(folder, message=".", checkpoint="latest"):
    again = TrainingRun(folder, Line(), PLAN, {"config": "x"})
    with pytest.raises(DataError, match=message) as caught:
        again.resume(checkpoint)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 600 + 3 * len(str(folder))


ENTRIES = (
    "checkpoints", f"checkpoints/{LAST}", f"checkpoints/{LAST}/{TENSORS}", f"checkpoints/{LAST}/{VALUES}",
    f"checkpoints/{LAST}/MANIFEST.json", "checkpoints/latest", "checkpoints/best", "checkpoints/step_00000021",
    "checkpoints/.step_00000007.x", "config.yaml", "metrics.jsonl", "model", "model/line.bin", "summary.json",
    "MODEL_CARD.md", "seconds.json", "tensorboard", "wandb",
)  # fmt: skip


@pytest.mark.parametrize("name", ENTRIES)
def test_links_lead_nowhere(run, elsewhere, name):
    """Even if a link's target would fit, it is neither read nor replaced nor deleted."""
    (elsewhere / "tensorboard").mkdir()
    (elsewhere / "wandb").mkdir()
    (elsewhere / "checkpoints" / ".step_00000007.x").mkdir()
    before, path = content(elsewhere), run / name
    if path.is_dir():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)
    path.symlink_to(elsewhere / name)
    refused(run, "is a link, which a run's folder must not hold")
    refused(run, "is a link", "step_00000021")
    assert content(elsewhere) == before


@pytest.mark.parametrize("name", [n for n in ENTRIES if (n not in ("tensorboard", "wandb")) and ".step" not in n])
def test_a_folder_where_a_file_should_be_and_a_pipe_where_either_should(run, name):
    path = run / name
    a_folder = path.is_dir()
    if a_folder:
        shutil.rmtree(path)
        path.write_text("x")
    else:
        path.unlink()
        (path / "deeper").mkdir(parents=True)
    refused(run, f"expected a {'folder' if a_folder else 'file'}")
    shutil.rmtree(path, ignore_errors=True)
    path.unlink(missing_ok=True)
    os.mkfifo(path)  # reading it would block forever
    refused(run, "expected a")


@pytest.mark.parametrize(
    "name", ["../../elsewhere", "../../elsewhere/checkpoints/" + LAST, "/etc", ".", "..", "", "step_1", LAST + "/..",
             "step_00000099", "\x00", "x" * 5000, "step_٠٠٠٠٠٠٢٣"],
)  # fmt: skip
@pytest.mark.parametrize("how", ["pointer", "option"])
def test_names_that_lead_elsewhere(run, elsewhere, name, how):
    before = content(elsewhere)
    if how == "pointer":
        (run / "checkpoints" / "latest").write_text(name + "\n")
        refused(run)
    else:
        refused(run, checkpoint=name)
    assert content(elsewhere) == before


def test_a_wrong_pointer_to_the_best_changes_no_figure(run, whole):
    """The pointer ``best`` names a whole checkpoint, but not the one with the best validation."""
    best, others = (run / "checkpoints" / "best"), sorted((run / "checkpoints").glob("step_*"))
    best.write_text(next(p.name for p in others if p.name != best.read_text().strip()) + "\n")
    again = TrainingRun(run, Line(), PLAN, {"config": "x"})
    again.resume()
    again.run()
    assert (run / "summary.json").read_bytes() == (whole / "summary.json").read_bytes()
    assert best.read_text() == (whole / "checkpoints" / "best").read_text()


def rewritten(run, change):
    """Change ``state.json`` of the last checkpoint and update the manifest."""
    folder = run / "checkpoints" / LAST
    value = change(json.loads((folder / VALUES).read_text()))
    (folder / VALUES).write_text(value if isinstance(value, str) else json.dumps(value))
    write_manifest(folder, [TENSORS, VALUES])


def with_trainer(**values):
    return lambda state: state | {"values": state["values"] | {"trainer": state["values"]["trainer"] | values}}


BEST = {"score": 0.5, "step": 20}
STATES = {
    "no object": lambda state: [],
    "empty": lambda state: "",
    "deep": lambda state: "[" * 100_000,
    "deep objects": lambda state: '{"a":' * 100_000,
    "a huge number": lambda state: state | {"step": 10**30},
    "a number of 10,000 digits": lambda state: '{"format": 1, "step": ' + "1" * 10_000 + "}",
    "NaN": lambda state: json.dumps(state).replace('"step": 23', '"step": NaN'),
    "a negative step": lambda state: state | {"step": -1},
    "a step of text": lambda state: state | {"step": "23"},
    "a true step": lambda state: state | {"step": True},
    "a broken step": lambda state: state | {"step": 23.0},
    "another step": lambda state: state | {"step": 22},
    "twice": lambda state: json.dumps(state)[:-1] + ', "step": 23}',
    "no step": lambda state: {k: v for k, v in state.items() if k != "step"},
    "identity of numbers": lambda state: state | {"identity": {"config": 1, "data": 2}},
    "no identity": lambda state: state | {"identity": None},
    "best of text": lambda state: state | {"best": "../../elsewhere"},
    "best below 0": lambda state: state | {"best": -5},
    "format": lambda state: state | {"format": [1]},
    "values of a list": lambda state: state | {"values": []},
    "no trainer": lambda state: state | {"values": {"learner": {"done": 23}}},
    "a trainer of text": lambda state: state | {"values": state["values"] | {"trainer": "x"}},
    "best figures of text": with_trainer(best={**BEST, "score": "high"}),
    "best figures without a score": with_trainer(best={"step": 20}),
    "best of later": with_trainer(best={**BEST, "step": 24}),
    "best at half a step": with_trainer(best={**BEST, "step": 20.5}),
    "a figure with lines in its name": with_trainer(best={**BEST, "a\n# b": 1.0}),
    "extended by nothing": with_trainer(extended="x"),
    "extended by another": with_trainer(extended=[{"at": 20, "steps": 23}]),
}


@pytest.mark.parametrize("name", STATES)
def test_states_that_no_run_wrote(run, name):
    rewritten(run, STATES[name])
    before = content(run)
    refused(run, r"checkpoint .*; continue from an earlier one with resume=.*step_00000021")
    assert content(run) == before


def file_of(header, data=b""):
    raw = header if isinstance(header, bytes) else json.dumps(header).encode()
    return len(raw).to_bytes(8, "little") + raw + data


def entry(kind="F32", shape=(2,), offsets=(0, 8)):
    return {"weight": {"dtype": kind, "shape": list(shape), "data_offsets": list(offsets)}}


FILES = {
    "a shape beyond all memory": file_of(entry(shape=(1 << 40, 1 << 40))),
    "a shape beyond its data": file_of(entry(shape=(1 << 30,)), bytes(8)),
    "a negative shape": file_of(entry(shape=(-2,)), bytes(8)),
    "offsets elsewhere": file_of(entry(offsets=(1 << 50, (1 << 50) + 8)), bytes(8)),
    "offsets backwards": file_of(entry(offsets=(8, 0)), bytes(8)),
    "an unknown kind": file_of(entry("F8_E8M0", (8,)), bytes(8)),
    "no kind": file_of(entry("X"), bytes(8)),
    "a header beyond the file": (1 << 60).to_bytes(8, "little") + b"{}",
    "a deep header": file_of(b"[" * 100_000),
    "no header": b"\0",
    "nothing": b"",
}


@pytest.mark.parametrize("name", FILES)
def test_tensors_that_no_run_wrote(run, name):
    folder = run / "checkpoints" / LAST
    (folder / TENSORS).write_bytes(FILES[name])
    write_manifest(folder, [TENSORS, VALUES])
    refused(run, "continue from an earlier one")


def test_a_file_larger_than_any_state_is_not_read(run):
    """A sparse file takes no room on the disk, but would take all memory."""
    folder = run / "checkpoints" / LAST
    with (folder / TENSORS).open("r+b") as file:
        file.truncate(1 << 42)
    manifest = json.loads((folder / "MANIFEST.json").read_text())
    manifest["files"][TENSORS]["bytes"] = 1 << 42
    (folder / "MANIFEST.json").write_text(json.dumps(manifest))
    refused(run, "expected at most")


@pytest.mark.parametrize("line", ["nonsense", "[]", "3", '{"step": "5"}', '{"step": -1}', '{"step": 1e400}', "[" * 9999,
                                  '{"step": ' + "1" * 9999 + "}", ""])  # fmt: skip
def test_metrics_of_something_else(run, line):
    path = run / "metrics.jsonl"
    path.write_text(f"{line}\n{path.read_text()}")
    refused(run, r"metrics\.jsonl:1: not a line of metrics")


@pytest.mark.parametrize("text", ["", "[]", '{"seconds": "9"}', '{"seconds": -1}', '{"seconds": 1e999}', "[" * 9999])
def test_seconds_that_are_none_count_as_none(run, text):
    (run / "seconds.json").write_text(text)
    again = TrainingRun(run, Line(), PLAN, {"config": "x"})
    again.resume()
    again.run()
    assert 0 <= json.loads((run / "seconds.json").read_text())["seconds"] < 60


@pytest.mark.parametrize("value", [None, "3", True, 2.0, -1, 1 << 53])
def test_counts_are_whole_numbers(value):
    with pytest.raises(DataError, match=r"done is .*, expected a whole number"):
        State({}, {"done": value}).count("done")
    assert State({}, {"done": 3}).count("done") == 3


def test_a_checkpoint_of_other_kinds_of_number_is_refused(run):
    """Names and shapes are right, but dtypes or values are not."""
    from ucon.learning.run.updates import Updates

    weight = torch.nn.Parameter(torch.zeros(2))
    updates = Updates({"weight": weight}, lr=0.1)
    weight.sum().backward()
    updates.take(0)
    right = {name: value.clone() for name, value in updates.tensors().items()}
    updates.load(load(save(right)), 1)
    for name, value in {
        "learned/weight": torch.zeros(2, dtype=torch.int64),
        "average/weight": torch.zeros(2, dtype=torch.complex64),
        "exp_avg/weight": torch.tensor([0.0, torch.nan]),
        "exp_avg_sq/weight": torch.tensor([-1.0, 0.0]),
        "step/weight": torch.tensor(torch.inf),
    }.items():
        with pytest.raises(DataError, match=r"state (of another learner|with invalid values in \w+/weight)"):
            updates.load(right | {name: value}, 1)
