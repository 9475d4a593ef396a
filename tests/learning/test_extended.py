"""Extended runs: effects on schedules, bytes and descriptions, and what is refused."""

import functools
import json
import os
import signal

import pytest
from omegaconf import OmegaConf

from tests.learning.test_run import files
from tests.learning.tiny import Line, tiny_learner, write_tiny_bert
from tests.learning.tiny_policy import tiny_dagger, tiny_imitation
from tests.learning.tiny_ppo import tiny_ppo
from ucon.core.errors import ConfigError
from ucon.learning.run.checkpoints import CheckpointError
from ucon.learning.run.run_plan import Extension, Plan
from ucon.learning.run.training_run import CARD, CONFIG, METRICS, SUMMARY, Interrupted, TrainingRun
from ucon.programs.training import chosen_run, run_identity, write_extension

PLAN = Plan(steps=23, validate_every=5, save_every=3, keep=2)
STORED = {
    "learner": {"_target_": "ucon.learning.tiny.Line"},
    "training": {"steps": 23, "validate_every": 5, "save_every": 3, "keep": 2},
    "threads": 1,
}


class Annealed(Line):
    """A line whose learning rate falls until the end of its schedule."""

    length = PLAN.steps

    def __init__(self):
        super().__init__()
        self.followed = []

    def step(self):
        self.followed.append(self.length)
        before = self.weight
        figures = super().step()
        self.weight = before + (self.weight - before) * (1 - (self.done - 1) / self.length)
        return figures

    def lengthen(self, steps):
        self.length = steps
        return True


def a_run(folder, learner=None, *, stop_after=None):
    """A run with the plan in the folder's configuration, as ``train.py`` continues it."""
    learner = learner or Annealed()
    if stop_after:
        learner.on_step = lambda done: os.kill(os.getpid(), signal.SIGTERM) if done == stop_after else None
    config = OmegaConf.to_container(OmegaConf.load(folder / CONFIG)) if (folder / CONFIG).is_file() else STORED
    return TrainingRun(folder, learner, Plan.of(config["training"]), run_identity(config))


def begin(folder, learner=None, *, stop_after=None):
    run = a_run(folder, learner, stop_after=stop_after)
    run.start(OmegaConf.to_yaml(OmegaConf.create(STORED)))
    ended(run)
    return run


def ended(run):
    """Play a run until it ends or is stopped."""
    try:
        return run.run()
    except Interrupted:
        return None


def extend(folder, steps, checkpoint="latest", *, learner=None, stop_after=None):
    run = a_run(folder, learner, stop_after=stop_after)
    run.resume(checkpoint, steps)
    write_extension(folder, run.plan)
    ended(run)
    return run


def go_on(folder, checkpoint="latest", *, learner=None, stop_after=None):
    run = a_run(folder, learner, stop_after=stop_after)
    run.resume(checkpoint)
    ended(run)
    return run


@pytest.fixture(scope="module")
def extended(tmp_path_factory):
    """A run finished after 23 steps and then extended to 40."""
    folder = tmp_path_factory.mktemp("extended") / "run"
    begin(folder)
    extend(folder, 40)
    return folder


def test_it_is_said_wherever_the_run_is_described(extended):
    summary = json.loads((extended / SUMMARY).read_text())
    assert (summary["steps"], summary["extended"]) == (40, [{"at": 23, "steps": 40}])
    card = (extended / CARD).read_text()
    assert "Planned for 23 steps, extended to 40 after 23; from then on its learning rate follows the longer" in card
    config = OmegaConf.load(extended / CONFIG)
    assert config.training == {**STORED["training"], "extended": [{"at": 23, "steps": 40}]}
    lines = [json.loads(line) for line in (extended / METRICS).read_text().splitlines()]
    assert [line["step"] for line in lines if "loss" in line] == list(range(1, 41))
    assert [line["step"] for line in lines if "val/score" in line] == [0, 5, 10, 15, 20, 23, 25, 30, 35, 40]


def test_a_run_that_was_not_extended_says_nothing_of_it(tmp_path):
    begin(tmp_path)
    assert "extended" not in (tmp_path / SUMMARY).read_text() + (tmp_path / CONFIG).read_text()
    assert "extended" not in (tmp_path / CARD).read_text()
    assert "extended" not in "".join(p.read_text() for p in tmp_path.glob("checkpoints/*/state.json"))


def test_schedules_are_of_the_length_that_was_planned_at_each_step(tmp_path):
    first, second = Annealed(), Annealed()
    begin(tmp_path, first)
    run = extend(tmp_path, 40, learner=second)
    assert (first.followed, second.followed) == ([23] * 23, [40] * 17)
    assert run.rescheduled
    plain = Line()
    begin(tmp_path / "plain", plain)
    run = extend(tmp_path / "plain", 40, learner=Line())
    assert "no schedule depends on the number of steps" in run.extended()


@pytest.mark.parametrize("stops", [(24,), (25, 29, 36), (23, 33)])
def test_a_run_that_is_stopped_in_its_extension_ends_in_the_same_bytes(extended, tmp_path, stops):
    begin(tmp_path)
    first, *others = stops
    extend(tmp_path, 40, stop_after=first)
    for stop in others:
        go_on(tmp_path, stop_after=stop)
    go_on(tmp_path)
    assert files(tmp_path) == files(extended)


def test_one_that_was_killed_before_its_first_step_too(extended, tmp_path):
    begin(tmp_path)
    run = a_run(tmp_path)
    run.resume(steps=40)
    write_extension(tmp_path, run.plan)
    go_on(tmp_path)
    assert files(tmp_path) == files(extended)


def test_going_back_to_before_the_extension_repeats_it(tmp_path):
    begin(tmp_path)
    extend(tmp_path, 40)
    before = files(tmp_path)
    for checkpoint in ("step_00000039", "best"):
        name = checkpoint if checkpoint != "best" else (tmp_path / "checkpoints" / "best").read_text().strip()
        go_on(tmp_path, name)
        assert files(tmp_path) == before


def test_going_back_beyond_the_end_of_the_first_part_repeats_both(tmp_path):
    plain = {**STORED, "training": {**STORED["training"], "keep": 20}}
    run = TrainingRun(tmp_path, Annealed(), Plan.of(plain["training"]), run_identity(plain))
    run.start(OmegaConf.to_yaml(OmegaConf.create(plain)))
    run.run()
    extend(tmp_path, 40)
    before = files(tmp_path)
    again = Annealed()
    go_on(tmp_path, "step_00000018", learner=again)
    assert again.followed == [23] * 5 + [40] * 17
    assert files(tmp_path) == before


def test_a_stopped_run_may_be_extended_and_extended_again(tmp_path):
    begin(tmp_path, stop_after=7)
    later = Annealed()
    extend(tmp_path, 30, learner=later)
    assert later.followed == [30] * 23
    run = extend(tmp_path, 35)
    assert run.plan.extended == (Extension(7, 30), Extension(30, 35))
    assert json.loads((tmp_path / SUMMARY).read_text())["steps"] == 35
    assert "extended to 30 after 7, extended to 35 after 30" in (tmp_path / CARD).read_text()


@pytest.mark.parametrize("steps", [40, 39, 23, 1])
def test_fewer_steps_and_as_many_are_refused_and_nothing_changes(extended, steps):
    before = files(extended)
    run = a_run(extended)
    with pytest.raises(ConfigError, match=f"training.steps={steps}: 40 steps are done; give more"):
        run.resume(steps=steps)
    assert files(extended) == before


def test_a_configuration_without_the_extension_is_of_another_run(extended):
    run = TrainingRun(extended, Annealed(), PLAN, run_identity(STORED))
    with pytest.raises(CheckpointError, match=r"config\.yaml lists other extensions"):
        run.resume()


def asked(folder, *overrides, steps=None):
    """The run that ``train.py resume=folder`` chooses when other options are given."""
    given = {"resume": str(folder), "progress": False, "wandb": False, "tensorboard": False, "runner": {}}
    return chosen_run(OmegaConf.create(given | {"training": {"steps": steps}}), list(overrides), None)


def test_only_more_steps_are_taken_beside_resume(tmp_path):
    ours = STORED | {"learner": {"_target_": "ucon.learning.retriever.learner.RetrieverLearner"}}
    (tmp_path / CONFIG).write_text(OmegaConf.to_yaml(OmegaConf.create(ours)))
    assert asked(tmp_path, f"resume={tmp_path}", steps=4).steps is None, "the default of another learner"
    assert asked(tmp_path, "training.steps=40", steps=40).steps == 40
    assert asked(tmp_path, "++training.steps=23", steps=23).steps == 23
    for word in ("training.keep=3", "seed=1", "~training.steps", "training={steps: 40}", "+training.extended=[]"):
        with pytest.raises(ConfigError, match=r"leave out .*\(training\.steps=MORE extends it\)"):
            asked(tmp_path, word, steps=40)
    with pytest.raises(ConfigError, match=r"training\.steps=22: the run already has 23; give more"):
        asked(tmp_path, "training.steps=22", steps=22)
    for steps in ("many", 0, -4, 1.5, True, 10**12, None):
        with pytest.raises(ConfigError, match=r"training\.steps=.*expected a whole number from 1 to"):
            asked(tmp_path, f"training.steps={steps}", steps=steps)


def test_a_run_of_an_older_version_is_built_by_todays_names_and_known_by_its_own(tmp_path):
    old = STORED | {"learner": {"_target_": "ucon.learning.retriever.RetrieverLearner"}}
    (tmp_path / CONFIG).write_text(OmegaConf.to_yaml(OmegaConf.create(old)))
    chosen = asked(tmp_path)
    assert chosen.config["learner"]["_target_"] == "ucon.learning.retriever.learner.RetrieverLearner"
    assert run_identity(chosen.stored) == run_identity(old)


def test_a_new_run_is_not_extended(tmp_path):
    config = OmegaConf.create(
        {
            **STORED, "agent": None, "resume": None,
            "out": str(tmp_path), "training": {"steps": 3, "extended": []},
        }
    )  # fmt: skip
    with pytest.raises(ConfigError, match=r"training\.extended is for resumed runs only"):
        chosen_run(config, [], None)


def rates(learner, first, last):
    return [learner.step()["rate"] for _ in range(first, last)]


@pytest.mark.parametrize("kind", ["imitation", "dagger", "ppo", "retriever"])
def test_every_learner_follows_the_longer_schedule(tmp_path, kind):
    make = {
        "imitation": functools.partial(tiny_imitation, tmp_path),
        "dagger": functools.partial(tiny_dagger, tmp_path),
        "ppo": functools.partial(tiny_ppo, tmp_path, anneal=True),
        "retriever": lambda **options: tiny_learner(write_tiny_bert(tmp_path), **options),
    }[kind]
    short, long = make(steps=4), make(steps=9)
    expected = rates(long, 0, 6)
    assert rates(short, 0, 4) != expected[:4]
    assert short.lengthen(9)
    assert rates(short, 4, 6) == expected[4:]
    for learner in (short, long):
        learner.close()


def test_who_has_no_schedule_says_so(tmp_path):
    learner = tiny_ppo(tmp_path)
    assert not learner.lengthen(50)
    assert learner.updates.steps == 0
    learner.close()
