"""Replaying finished runs gives the same records, and any difference is reported."""

import json
import lzma
import shutil
from pathlib import Path

import pytest
import torch
import yaml
from omegaconf import OmegaConf

from tests.commands.test_cli import run, user_error
from tests.evaluation.records import reseal
from ucon.evaluation.figures.report import versions
from ucon.evaluation.kept.folder import RunFolder
from ucon.evaluation.kept.record import EpisodeTiming, read_records
from ucon.evaluation.kept.seal import sealed
from ucon.evaluation.playing.play import PlayedEpisode

ROOT = Path(__file__).parents[2]
RESULTS = ROOT / "results"
#: What shipped weights were called when they were measured.
SHIPPED = ("runs/e2e-searches", "checkpoints/habit_policy_e2e")


def asks_for_more_than_is_shipped(folder: Path) -> bool:
    """Whether a run needs weights that are not shipped, other data, or a language model that must be fetched."""
    text = (folder / "config.yaml").read_text().replace("\nout: runs/", "").replace(SHIPPED[0], "")
    return any(asked in text for asked in ("runs/", "PATH/", "path: smollm2"))


RECORDED = sorted(path.parent for path in RESULTS.glob("*/episodes.jsonl.xz"))
OWN = [folder for folder in RECORDED if not asks_for_more_than_is_shipped(folder)]


@pytest.fixture
def kept(tmp_path):
    """A run from results/, cut to its first three episodes."""
    folder = tmp_path / "kept"
    shutil.copytree(RESULTS / "learned-frontier", folder)
    packed = folder / "episodes.jsonl.xz"
    lines = lzma.decompress(packed.read_bytes()).decode().splitlines()[:3]
    packed.unlink()
    (folder / "episodes.jsonl").write_text("".join(f"{line}\n" for line in lines))
    config = OmegaConf.load(folder / "config.yaml")
    config.limit = 3
    OmegaConf.save(config, folder / "config.yaml")
    reseal(folder, n=3)
    return folder


def altered(folder, **options):
    """Change options in the run's configuration."""
    config = OmegaConf.load(folder / "config.yaml")
    for name, value in options.items():
        config[name] = value
    OmegaConf.save(config, folder / "config.yaml")
    reseal(folder)


def replay(tmp_path, *words):
    return run("replay", *map(str, words), "--workers", "0", "--out", str(tmp_path / "out"))


def test_what_was_measured_comes_out_again(kept, tmp_path):
    result = replay(tmp_path, kept)
    assert result.returncode == 0, result.stderr
    assert result.stdout == f"{kept}: frontier, any, 3 episodes played: the same to the byte\n"
    assert (tmp_path / "out" / "kept" / "episodes.jsonl").read_bytes() == (kept / "episodes.jsonl").read_bytes()


def test_a_part_can_be_played(kept, tmp_path):
    assert "frontier, any, 2 episodes played: the same to the byte" in replay(tmp_path, kept, "--every", "2").stdout


def content(folder):
    return {path.relative_to(folder): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.slow
def test_a_run_of_a_gpu_can_be_played_on_the_processor(tmp_path):
    """--device says where its networks run; there is no GPU here to replay it as it is stored."""
    folder = tmp_path / "kept"
    shutil.copytree(RESULTS / "learned-habit_policy-retrieval", folder)
    altered(folder, agent={**OmegaConf.load(folder / "config.yaml").agent, "device": "cuda:9"})
    words = (folder, "--every", "500")
    told = replay(tmp_path, *words).stderr
    assert told.endswith("torch sees no such GPU here; replay --device cpu plays it here\n")
    assert "2 episodes played" in replay(tmp_path, *words, "--device", "cpu").stdout
    told = user_error(replay(tmp_path, *words, "--device", "gpu"))
    assert told == "error: --device=gpu: expected cpu, cuda, cuda:NUMBER or auto"


def test_every_time_it_is_really_played_and_what_is_kept_stays_as_it_is(kept, tmp_path):
    """Each replay, whole or in part, goes to a new folder beside the run and earlier replays."""
    before, found = content(kept), []
    for runs, words in (([kept, kept], []), ([kept], ["--every", "2"])):
        result = run("replay", *map(str, runs), "--workers", "0", "--out", str(kept.parent), "--json", *words)
        assert result.returncode == 0, result.stderr
        found += map(json.loads, result.stdout.splitlines())
    told = [(one["out"], one["played"], one["same"]) for one in found]
    assert told == [(f"{kept}-2", 3, True), (f"{kept}-3", 3, True), (f"{kept}-4", 2, True)]
    assert f"out: {kept}-4\n" in (tmp_path / "kept-4" / "config.yaml").read_text()
    assert content(kept) == before


def test_an_interrupted_one_goes_on(kept, tmp_path):
    assert replay(tmp_path, kept).returncode == 0
    whole = tmp_path / "out" / "kept"
    run_of = RunFolder(
        tmp_path / "out" / "kept-2", json.loads((whole / "summary.json").read_text())["hashes"], versions()
    )
    records = read_records(whole)
    run_of.open([record.episode for record in records])
    timing = EpisodeTiming(**json.loads((whole / "timing.jsonl").read_text().splitlines()[0]))
    run_of.add(PlayedEpisode(0, records[0], timing))
    other = RunFolder(tmp_path / "out" / "kept-3", {"config": "of another run"}, versions())
    other.open([])
    going_on, once_more = map(json.loads, replay(tmp_path, kept, kept, "--json").stdout.splitlines())
    assert [going_on[name] for name in ("out", "n", "played", "same")] == [str(run_of.path), 3, 2, True]
    assert [once_more[name] for name in ("out", "n", "played")] == [str(tmp_path / "out" / "kept-4"), 3, 3]
    assert {path.name for path in other.path.iterdir()} == {"episodes.jsonl.partial"}


@pytest.mark.slow
def test_an_episode_that_comes_out_otherwise_is_told(kept, tmp_path):
    first, *rest = map(json.loads, (kept / "episodes.jsonl").read_text().splitlines())
    first["n_habits"] += 1
    (kept / "episodes.jsonl").write_text("".join(json.dumps(line) + "\n" for line in (first, *rest)))
    reseal(kept)
    result = replay(tmp_path, kept, "--json")
    assert result.returncode == 1
    found = json.loads(result.stdout)
    assert (found["same"], found["n"], found["differing"]) == (False, 3, [first["episode"]])
    assert f"see {tmp_path / 'out' / 'kept-2'}\n" in replay(tmp_path, kept).stdout


@pytest.mark.slow
def test_figures_are_compared_where_no_episodes_are_kept(kept, tmp_path):
    assert replay(tmp_path, kept).returncode == 0
    (kept / "episodes.jsonl").unlink()
    for name in ("summary.json", "seconds.json"):
        shutil.copy(tmp_path / "out" / "kept" / name, kept)
    reseal(kept)
    assert "3 episodes played: the same in every figure" in replay(tmp_path, kept).stdout
    refused = replay(tmp_path / "part", kept, "--every", "2")
    assert "only figures of all of them; play all (every 1)" in refused.stderr
    assert not (tmp_path / "part").exists(), "nothing was played"
    figures = json.loads((kept / "summary.json").read_text())
    reseal(kept, spl=figures["spl"] + 0.01, opens=99.0)
    result = replay(tmp_path, kept)
    assert result.returncode == 1
    assert "2 figures differ (spl, opens)" in result.stdout


def test_a_summary_without_figures_is_none(kept, tmp_path):
    said, records = {"agent": "frontier", "habit_level": "none"}, (kept / "episodes.jsonl").read_bytes()
    (kept / "summary.json").write_text(sealed(said, {"episodes.jsonl": records}))
    result = replay(tmp_path, kept)
    assert (result.returncode, result.stdout) == (1, "")
    assert "no summary of a finished run" in result.stderr


def test_a_run_that_cannot_be_played_does_not_keep_others_from_it(kept, tmp_path):
    lost = tmp_path / "lost"
    shutil.copytree(kept, lost)
    altered(lost, episodes="FAR/AWAY.jsonl.xz")
    result = replay(tmp_path, lost, tmp_path / "nothing", kept)
    assert result.returncode == 1
    assert result.stdout.count("the same") == 1
    assert f"{lost}: not played: unknown episode set or file 'FAR/AWAY.jsonl.xz'" in result.stderr
    assert f"{tmp_path / 'nothing'}: not played: " in result.stderr


def test_paths_may_lie_elsewhere(kept, tmp_path):
    altered(kept, episodes="FAR/mini.jsonl.xz")
    found = replay(tmp_path, kept, "--path", f"FAR={ROOT / 'ucon/task/data'}")
    assert "its configuration now names other episodes than those kept" in found.stderr
    assert not (tmp_path / "out").exists(), "nothing was played"


ODD = [
    ("task.context", None, "config.yaml: no usable task.context in it"),
    ("env.detector", None, "no usable env.detector._target_"),
    ("agent", "belief", "no usable agent._target_"),
    ("every", "x", "every=x: expected a whole number"),
    ("batch", 0, "batch=0: expected a whole number from 1 up"),
    ("agent._target_", "os.mkdir", "agent._target_=os.mkdir: nothing in configs/ builds that there; a stored run"),
    ("env.source.context", {"_target_": "os.mkdir", "path": "made"}, "env.source.context._target_=os.mkdir"),
    ("agent._target_", "ucon.core.files.os.mkdir", "agent._target_=ucon.core.files.os.mkdir: nothing in configs/"),
    ("agent._target_", "ucon.habits.book", "agent._target_=ucon.habits.book: nothing in configs/ builds that there"),
    ("agent", {"_target_": "models.agents.belief.BeliefAgent", "_partial_": True}, "is called with _partial_: True"),
    ("habits", [{"_target_": "models_of_others.Agent"}], "habits.0._target_=models_of_others.Agent"),
    ("agent.locate", "${oc.create:{_target_:os.mkdir,path:made}}", "a stored run has no interpolations"),
    ("agent._target_", "models.agents.nobody.Agent", "agent._target_=models.agents.nobody.Agent: nothing in configs/"),
    (
        "env.source.dataset",
        {"_target_": "ucon.habits.book", "_args_": 7},
        "env.source.dataset is called with _args_: 7, which configs/ never does",
    ),
    ("agent", {"_target_": "models.agents.belief.BeliefAgent", "locate": 7}, "BeliefAgent.locate=7: expected a part"),
]


def test_odd_configurations_are_told_and_the_others_played(kept, tmp_path):
    for number, (key, value, _) in enumerate(ODD):
        shutil.copytree(kept, tmp_path / f"odd{number}")
        config = OmegaConf.to_container(OmegaConf.load(kept / "config.yaml"))
        *groups, name = key.split(".")
        node = config
        for group in groups:
            node = node[group]
        node[name] = value
        (tmp_path / f"odd{number}" / "config.yaml").write_text(yaml.safe_dump(config))
        reseal(tmp_path / f"odd{number}")
    odd = [str(tmp_path / f"odd{number}") for number in range(len(ODD))]
    result = run("replay", *odd, str(kept), "--workers", "1", "--out", str(tmp_path / "out"))
    assert result.returncode == 1
    assert result.stdout == f"{kept}: frontier, any, 3 episodes played: the same to the byte\n", result.stderr
    told = result.stderr.split(": not played: ")[1:]
    assert len(told) == len(ODD), result.stderr
    for (key, value, part), text in zip(ODD, told, strict=True):
        assert part in text, (key, value)
    assert not (ROOT / "made").exists()


@pytest.mark.parametrize(
    ("words", "part"),
    [
        (["x", "--every", "0"], "--every 0: expected a whole number from 1 up"),
        (["x", "--path", "runs"], "--path runs: expected OLD=NEW"),
    ],
)
def test_bad_options_end_in_one_line(words, part, tmp_path):
    assert part in user_error(replay(tmp_path, *words))


def has_a_network(folder: Path) -> bool:
    """Whether a network is asked: its float32 sums differ between kinds of processors, which can tip near-ties."""
    return "policy" in OmegaConf.load(folder / "config.yaml").agent


@pytest.mark.slow
@pytest.mark.parametrize("folder", OWN, ids=lambda folder: folder.name)
def test_the_results_come_out_again(folder, tmp_path):
    """Some episodes of every recorded run that needs only what is shipped."""
    if has_a_network(folder) and torch.backends.cpu.get_cpu_capability() != "AVX512":
        pytest.skip("recorded with AVX-512, and a network is asked")
    words = (str(folder), "--every", "200", "--path", "=".join(SHIPPED), "--out", str(tmp_path))
    result = run("replay", *words, timeout=900)  # the first run with another encoder has to encode all sentences
    assert "the same to the byte" in result.stdout, result.stdout + result.stderr
