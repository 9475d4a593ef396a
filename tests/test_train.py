"""``train.py`` from end to end, in separate processes."""

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import torch
from hydra.core.override_parser.overrides_parser import OverridesParser
from omegaconf import OmegaConf
from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

from tests.programs import outcomes
from ucon.core.errors import ConfigError, DataError
from ucon.programs.training import chosen_run, use_threads

ROOT = Path(__file__).parents[1]
SMALL = ("learner=retriever", "learner.rank=2", "learner.n_kbs=1", "progress=false", "training.validate_every=2")


def train(*overrides: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "train.py", *overrides]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=600)


def error_line(result: subprocess.CompletedProcess[str]) -> str:
    lines = result.stderr.strip().splitlines()
    assert result.returncode == 2, result.stderr
    assert len(lines) == 1, result.stderr
    return lines[0]


def test_mistakes_end_in_one_line(tmp_path):
    run, broken = f"out={tmp_path}/run", tmp_path / "broken"
    broken.mkdir()
    (broken / "config.yaml").write_text("learner: [")
    told = {
        (f"resume={tmp_path}/nothing",): "no run there",
        (f"resume={tmp_path}", "training.keep=3"): "leave out training.keep=3",
        ("learner=retreiver",): "unknown learner 'retreiver': did you mean retriever",
        ("threads=0", run): "threads=0: expected a whole number",
        ("wandb=onlin", run): "wandb=onlin: expected false or null or offline or online",
        ("+training.foo=1", run): "unknown option 'training.foo'",
        ("seed=abc", run): "seed=abc: expected a whole number",
        ("learner=imitation",): "scores views, and stored solutions name actions",
        ("agent=frontier",): "or one that has: habit_policy, ",
        ("agent=frontier", "learner=imitation"): "no policy that could be trained",
        ("agent=vtn", "learner=retriever"): "trains no policy; give learner=imitation",
        (
            "agent=vtn",
            f"agent.checkpoint={tmp_path}",
        ): "agent.checkpoint is for playing only; give learner.initial=FOLDER",
        (f"learner.initial={tmp_path}", run): "no trained weights there",
        ("agent=vtn", "learner=dagger", "learner.device=cuda:9"): "torch sees no such GPU",
        (f"resume={broken}",): "not YAML",
    }
    for words, (code, error) in zip(told, outcomes([("train.py", *words) for words in told]), strict=True):
        assert code == 2, (words, error)
        assert error.count("\n") == 1, (words, error)
        assert told[words] in error
    assert not (tmp_path / "nothing").exists()
    assert not (tmp_path / "run").exists()


def resumed(path):
    watched = {"progress": False, "wandb": False, "tensorboard": False, "runner": {}}
    return chosen_run(OmegaConf.create({"resume": str(path), **watched}), [], None)


WHOLE = "learner: {_target_: ucon.learning.retriever.learner.RetrieverLearner}\ntraining: {steps: 3}\nthreads: 1\n"


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (
            b"learner: {_target_: ucon.learning.retriever.learner.RetrieverLearner}\nthreads: [1\n",
            r"config\.yaml:3: not YAML; restore it",
        ),
        (b"threads: \x00", r"config\.yaml:1: not YAML"),
        (b"threads: \xff", r"config\.yaml: not UTF-8; restore it"),
        (b"threads: !!int abc", r"config\.yaml: not the configuration of a run"),
        (b"threads: ${", r"config\.yaml: not the configuration of a run"),
        (b"", r"config\.yaml: no learner in it; restore it"),
        (b"text", r"config\.yaml: no learner in it"),
        (b"- a\n", r"config\.yaml: no options in it"),
        (WHOLE.replace("threads: 1\n", "").encode(), r"config\.yaml: no threads in it"),
        (WHOLE.replace("_target_", "target").encode(), r"config\.yaml: learner has no _target_"),
        (
            WHOLE.replace("ucon.learning.retriever.learner.RetrieverLearner", "os.mkdir").encode(),
            r"learner\._target_=os\.mkdir: nothing in configs/ builds that there",
        ),
        (
            f"{WHOLE}agent: {{of: [{{_target_: os.mkdir}}]}}\n".encode(),
            r"config\.yaml: agent\.of\.0\._target_=os\.mkdir",
        ),
        (
            WHOLE.replace("3", "x").encode(),
            r"config\.yaml: training\.steps=x: expected a whole number from 1 up; restore",
        ),
        (WHOLE.replace("3", "'${oc.env:HOME}'").encode(), r"training\.steps=\$.*has no interpolations"),
    ],
)
def test_spoilt_configurations_are_named(tmp_path, content, message):
    (tmp_path / "config.yaml").write_bytes(content)
    with pytest.raises(DataError, match=message):
        resumed(tmp_path)


def test_a_run_goes_on_where_it_began(tmp_path):
    """A run begun on a GPU is not continued on a CPU unless asked to, nor vice versa."""
    (tmp_path / "config.yaml").write_text(
        WHOLE.replace(
            "ucon.learning.retriever.learner.RetrieverLearner",
            "ucon.learning.retriever.learner.RetrieverLearner, device: cuda:7",
        )
    )
    with pytest.raises(
        ConfigError, match=r"was started with learner\.device=cuda:7, which torch does not see"
    ) as caught:
        resumed(tmp_path)
    assert "\n" not in str(caught.value)
    (tmp_path / "config.yaml").write_text(
        WHOLE.replace(
            "ucon.learning.retriever.learner.RetrieverLearner",
            "ucon.learning.retriever.learner.RetrieverLearner, device: cpu",
        )
    )
    assert resumed(tmp_path).config["learner"]["device"] == "cpu"


def test_a_checkpoint_may_be_named_from_where_one_stands(tmp_path, monkeypatch):
    run = tmp_path / "run"
    (run / "checkpoints" / "step_00000010").mkdir(parents=True)
    (run / "config.yaml").write_text(WHOLE)
    monkeypatch.chdir(run / "checkpoints")
    for name in ("step_00000010", run / "checkpoints" / "step_00000010"):
        found = resumed(name)
        assert (found.folder, found.checkpoint) == (run.resolve(), "step_00000010")
    for nowhere in ("/step_00000010", 3):
        with pytest.raises(ConfigError, match="no run there"):
            resumed(nowhere)


@pytest.mark.parametrize("threads", [0, -1, 1.5, "two", None, True, 10**12])
def test_impossible_numbers_of_threads(threads):
    before = torch.get_num_threads()
    with pytest.raises(ConfigError, match=r"threads=.*expected a whole number from 1"):
        use_threads(threads)
    assert torch.get_num_threads() == before


@pytest.mark.slow
@pytest.mark.parametrize("learner", ["imitation", "dagger"])
def test_a_policy_is_trained_and_then_played(tmp_path, learner):
    run, small = tmp_path / "run", ("learner.n_episodes=2", "learner.batch=2", "training.steps=2", "progress=false")
    validation = [f"learner.validation.{x}" for x in ("n_demonstrations=2", "n_play=0", "choose=loss")]
    rollouts = ["learner.rollouts.episodes=2", "learner.rollouts.max_steps=20"] if learner == "dagger" else []
    result = train("agent=vtn", f"learner={learner}", *small, *validation, *rollouts, f"out={run}")
    assert result.returncode == 0, result.stderr[-2000:]
    lines = [json.loads(line) for line in (run / "metrics.jsonl").read_text().splitlines()]
    assert lines[-1]["val/loss"] > 0
    kept = OmegaConf.load(run / "config.yaml").learner
    assert (kept.precision, kept.batch) == ("bfloat16" if kept.device == "cuda" else "float32", 2)
    assert kept.device in ("cpu", "cuda"), "what auto came to is kept"
    assert f"computing with device {kept.device}, precision {kept.precision}, batch 2" in result.stderr
    card = (run / "MODEL_CARD.md").read_text()
    assert "different labelled frames" in card
    assert "## Licence\n\nCC BY 4.0" in card
    command = [sys.executable, "eval.py", "agent=vtn", f"agent.checkpoint={run}", "limit=1", f"out={tmp_path}/eval"]
    played = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=600)
    assert played.returncode == 0, played.stderr[-2000:]
    assert json.loads((tmp_path / "eval" / "summary.json").read_text())["n"] == 1


@pytest.mark.slow
@pytest.mark.parametrize("launcher", ["basic", "joblib", "submitit_local"])
def test_sweeps_train_every_run(tmp_path, launcher):
    small = (*SMALL, "training.steps=1", "learner.seed=1,2", f"out={tmp_path}")
    result = train("-m", *small, f"hydra/launcher={launcher}")
    assert result.returncode == 0, result.stderr[-2000:]
    runs = [next(tmp_path.glob(f"*learner.seed-{seed}+*/summary.json")).parent for seed in (1, 2)]
    for run in runs:  # its name needs no quotes
        assert OverridesParser.create().parse_override(f"resume={run}").value() == str(run)
    assert len({(run / "model" / "retriever.safetensors").read_bytes() for run in runs}) == 2


@pytest.mark.slow
def test_sigterm_saves_and_resume_gives_the_same_bytes(tmp_path):
    whole, parts = tmp_path / "whole", tmp_path / "parts"
    result = train(*SMALL, "training.steps=4", f"out={whole}", "tensorboard=true")
    assert result.returncode == 0, result.stderr[-2000:]
    assert "best validation" in result.stdout
    assert {"config.yaml", "metrics.jsonl", "MODEL_CARD.md", "summary.json"} <= {p.name for p in whole.iterdir()}
    written = EventAccumulator(str(whole / "tensorboard")).Reload()
    logged = [json.loads(line) for line in (whole / "metrics.jsonl").read_text().splitlines()]
    losses = [(line["step"], np.float32(line["loss"])) for line in logged if "loss" in line]
    assert [(event.step, event.value) for event in written.Scalars("loss")] == losses
    command = [sys.executable, "train.py", *SMALL, "training.steps=4", f"out={parts}"]
    process = subprocess.Popen(command, cwd=ROOT, stderr=subprocess.PIPE, text=True)
    metrics = parts / "metrics.jsonl"
    while not (metrics.is_file() and '"step":1' in metrics.read_text()):
        assert process.poll() is None, process.communicate()[1]
        time.sleep(0.02)
    process.send_signal(signal.SIGTERM)
    _, told = process.communicate(timeout=120)
    assert process.returncode == 128 + signal.SIGTERM
    assert f"continue with resume={parts}" in told
    result = train(f"resume={parts}", "progress=false")
    assert result.returncode == 0, result.stderr[-2000:]
    for name in ("metrics.jsonl", "model/retriever.safetensors"):
        assert (whole / name).read_bytes() == (parts / name).read_bytes()
    for name in ("summary.json", "MODEL_CARD.md"):
        assert (whole / name).read_bytes() == (parts / name).read_bytes()
    longer = train(f"resume={parts}", "progress=false", "training.steps=6")
    assert longer.returncode == 0, longer.stderr[-2000:]
    assert "planned for 4 steps, extended to 6 after 4; from then on its learning rate" in longer.stderr
    assert json.loads((parts / "summary.json").read_text())["extended"] == [{"at": 4, "steps": 6}]
    assert OmegaConf.load(parts / "config.yaml").training.extended == [{"at": 4, "steps": 6}]
    assert "6 steps are done; give more" in error_line(train(f"resume={parts}", "progress=false", "training.steps=6"))
    begun = train(*SMALL, "training.steps=1", f"learner.initial={parts}", f"out={tmp_path / 'begun'}")
    assert begun.returncode == 0, begun.stderr[-2000:]
