"""Imitation of stored solutions: it learns, can be stopped anywhere, and refuses senseless options."""

import functools
import itertools

import pytest
import torch

from models.nets.policy_defaults import PolicyModule
from tests.learning.tiny_policy import Counting, Stays, TinyPolicy, on_a_gpu, tiny_imitation, training_file
from ucon.core.device import torch_precision
from ucon.core.errors import ConfigError, DataError, DivergedError
from ucon.core.files import write_atomic, write_manifest
from ucon.learning.imitation.sequence_loss import SequenceLoss
from ucon.learning.policies.validation import Validation
from ucon.learning.run.network_files import load_network
from ucon.learning.run.training_run import METRICS, Plan, TrainingRun
from ucon.task.sets import load_episodes


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("episodes")


@pytest.fixture
def learner(folder):
    return functools.partial(tiny_imitation, folder)


def test_it_learns_three_episodes_by_heart(folder, learner):
    """The learner predicts nearly all labels at the end; always predicting the commonest is right for four in five."""
    found = learner(n_episodes=3, levels=("none",), steps=400, chunk=10, lr=5e-3, loss=SequenceLoss({"done": 2.0}))
    labels = "".join(episode.solution for episode in found.episodes)
    prior = max(labels.count(digit) for digit in set(labels)) / len(labels)
    figures = [found.step() for _ in range(400)]
    assert figures[0]["accuracy"] < prior
    assert figures[-1]["accuracy"] > 0.97 > prior + 0.1
    assert figures[-1]["cross_entropy"] < 0.2
    assert figures[-1]["value_loss"] < 0.1 * figures[0]["value_loss"]
    with found.updates.averaged():
        played = found.validation.__class__(training_file(folder), 3, 3, "none", 40, 3).played(found.players, 0)
    assert played["success_rate"] >= 1 / 3, "what was learned by heart is not what is played"


def test_budgets_are_counted(learner):
    found = learner(n_episodes=4, batch=3)
    total = sum(len(episode.solution) for episode in found.episodes)
    steps = [found.step() for _ in range(4)]
    batches = itertools.islice(learner(n_episodes=4, batch=3).batches(), 4)
    seen = [sum(len(job.episode.solution) for job in batch) for batch in batches]
    assert [s["frames"] for s in steps] == [sum(seen[: k + 1]) for k in range(4)]
    assert [s["labels"] for s in steps] == [min(s["frames"], total) for s in steps]
    assert steps[2]["labels"] == total


def test_a_batch_is_learned_from_at_once_or_every_few_chunks(learner):
    """The first update sees the same weights; later ones see the weights that the previous update left."""
    once, twice, each = (learner(n_episodes=1, batch=1, chunk=3, update_every=n) for n in (None, 2, 1))
    n_chunks = -(-len(once.episodes[0].solution) // 3)
    steps = [one.step() for one in (once, twice, each)]
    assert [one.updates.taken for one in (once, twice, each)] == [1, -(-n_chunks // 2), n_chunks]
    assert n_chunks > 2
    assert len({figures["loss"] for figures in steps}) == 3
    assert {figures["frames"] for figures in steps} == {float(len(once.episodes[0].solution))}
    all_at_once = learner(n_episodes=1, batch=1, chunk=3, update_every=n_chunks)
    assert all_at_once.step() == steps[0]
    with pytest.raises(ConfigError, match=r"update_every=0: .*null, or above 0"):
        learner(update_every=0)


@pytest.mark.parametrize("half", [False, True])
def test_it_begins_with_the_weights_of_another_run(learner, tmp_path, half):
    first = learner(steps=3, half=half)
    for _ in range(3):
        first.step()
    for name, content in first.product().items():
        write_atomic(tmp_path / name, content)
    write_manifest(tmp_path, first.product())
    second, plain = learner(TinyPolicy(seed=5), initial=str(tmp_path)), learner(TinyPolicy(seed=5))
    shown = first.validation.demonstrations(first.levels)
    assert second.measured(shown)["loss"] == pytest.approx(first.measured(shown)["loss"], abs=0.01)
    assert plain.measured(shown)["loss"] != pytest.approx(first.measured(shown)["loss"], abs=0.1)
    assert second.identity["initial"]
    assert second.identity.keys() - plain.identity.keys() == {"initial"}
    with pytest.raises(DataError, match="architecture tiny, expected other"):
        learner(type("Other", (TinyPolicy,), {"architecture": "other"})(), initial=str(tmp_path))


def test_only_what_is_named_is_learned(learner, tmp_path):
    found = learner(only=["choose.bias", "memory"])
    before = {name: value.clone() for name, value in found.policy.state_dict().items()}
    found.step()
    changed = {name for name, value in found.policy.state_dict().items() if not torch.equal(value, before[name])}
    assert changed == {"choose.bias", *(name for name in before if name.startswith("memory."))}
    for name, content in (product := found.product()).items():
        write_atomic(tmp_path / name, content)
    write_manifest(tmp_path, product)
    again = TinyPolicy(seed=1)
    load_network(str(tmp_path), again)
    assert torch.allclose(again.see[0].weight, before["see.0.weight"], atol=1e-3), "what stays as it was is kept too"


def test_statistics_are_told_of_every_frame_and_of_no_padding(learner):
    found = learner(Counting(), n_episodes=4, batch=3)
    assert [found.step()["frames"] for _ in range(3)][-1] == found.policy.n_seen > 0


def test_batches_mix_levels_and_visit_every_episode(learner):
    found = learner(levels=("none", "full", "gt"), batch=3)
    batches = list(itertools.islice(found.batches(), 6))
    assert all({t.level for t in batch} == {"none", "full", "gt"} for batch in batches)
    names = [t.episode.id for batch in batches for t in batch]
    assert sorted(names[:6]) == sorted(names[6:12]) == sorted(e.id for e in found.episodes)
    assert names[:6] != names[6:12]
    assert len({(t.episode.id, t.level) for batch in batches for t in batch}) > 6


def files(folder):
    found = {p.relative_to(folder).as_posix(): p.read_bytes() for p in folder.rglob("*") if p.is_file()}
    assert found.pop("seconds.json")
    return found


@pytest.mark.parametrize("at", [1, 5])
def test_a_run_that_is_killed_goes_on_to_the_same_bytes(learner, tmp_path, at):
    """This includes dropout, the moving average, the order of episodes and the replays in memory."""

    def made():
        return learner(TinyPolicy(dropout=0.2), steps=7, average=0.9)

    class KilledError(Exception):
        pass

    def kill(step, figures):
        if step == at and "loss" in figures:
            raise KilledError

    plan = Plan(steps=7, validate_every=3, save_every=1, keep=2)
    whole = TrainingRun(tmp_path / "whole", made(), plan, {})
    whole.start("a: 1\n")
    whole.run()
    parts = TrainingRun(tmp_path / "parts", made(), plan, {})
    parts.start("a: 1\n")
    with pytest.raises(KilledError):
        parts.run(kill)
    again = TrainingRun(tmp_path / "parts", made(), plan, {})
    again.resume()
    assert again.step in (at - 1, at)
    again.run()
    assert files(tmp_path / "parts") == files(tmp_path / "whole")
    assert len((tmp_path / "whole" / METRICS).read_text().splitlines()) == 7 + 4


def test_validating_changes_nothing(learner):
    plain, watched = (learner(TinyPolicy(dropout=0.2), average=0.5) for _ in range(2))
    first = watched.validate()
    assert first == watched.validate()
    assert [plain.step() for _ in range(2)] == [watched.step() for _ in range(2)]
    watched.validate()
    assert plain.step() == watched.step()


def test_the_score_is_the_figure_that_was_chosen_and_the_loss_decides_among_equals(learner):
    found = learner(validation={"choose": "spl"}).validate()
    assert found["spl"] == 0
    assert -1e-3 < found["score"] < 0
    worse = {**found, "loss": found["loss"] + 1}
    assert Validation(choose="spl", n_play=1).score(worse)["score"] < found["score"]
    assert Validation(choose="loss", n_play=0).score({"loss": 2.0})["score"] == pytest.approx(-2.0, abs=1e-4)


def test_the_product_is_the_average_and_is_loaded_again(learner, tmp_path):
    found = learner(average=0.9)
    for _ in range(3):
        found.step()
    run = TrainingRun(tmp_path / "run", found, Plan(steps=4, validate_every=4), {})
    run.start("")
    run.run()
    policy = TinyPolicy(seed=9)
    load_network(str(tmp_path / "run"), policy)
    with found.updates.averaged():
        expected = {name: value.half().float() for name, value in found.policy.state_dict().items()}
    assert all(torch.equal(value, expected[name]) for name, value in policy.state_dict().items())
    card = (tmp_path / "run" / "MODEL_CARD.md").read_text()
    assert "different labelled frames" in card


class Broken(TinyPolicy):
    """A policy with a non-finite number in a place given by ``where``."""

    def __init__(self, where):
        super().__init__()
        self.where = where
        if where == "gradient of worth.weight":
            self.worth.weight.register_hook(lambda gradient: gradient / 0)

    def frame(self, observation, info):
        frame = super().frame(observation, info)
        return {**frame, "depth": frame["depth"] + float("nan")} if self.where == "frames depth" else frame

    def forward(self, frames, context, state):
        out = super().forward(frames, context, state)
        if self.where == "value":
            return out._replace(value=out.value / 0)
        if self.where == "logits":
            return out._replace(logits=out.logits * float("nan"))
        return out


@pytest.mark.parametrize(
    "where", ["frames depth", "value", "logits", "gradient of worth.weight", "parameter see.0.weight"]
)
def test_numbers_that_are_none_stop_it_and_are_named(learner, where):
    found = learner(Broken(where))
    if where.startswith("parameter"):
        with torch.no_grad():
            found.policy.see[0].weight[0, 0, 0, 0] = float("inf")
    before = found.state_dict().tensors["learned/choose.weight"].clone()
    with pytest.raises(DivergedError) as caught:
        found.step()
    assert str(caught.value).startswith(f"step 1: {where}")
    assert "\n" not in str(caught.value)
    assert torch.equal(found.policy.state_dict()["choose.weight"], before)


def test_half_the_bits_learn_as_well(learner):
    found = learner(precision="bfloat16", n_episodes=3)
    losses = [found.step()["cross_entropy"] for _ in range(20)]
    assert losses[-1] < 0.7 * losses[0]
    assert {value.dtype for value in found.updates.parameters.values()} == {torch.float32}


AUTO = {"device": "auto", "precision": "auto", "batch": "auto"}


def test_a_gpu_is_used_in_half_the_bits_and_larger_batches(learner, monkeypatch):
    on_a_gpu(monkeypatch)
    found = learner(Stays(), **AUTO)
    assert found.resolved_options == {"device": "cuda", "precision": "bfloat16", "batch": 64}
    assert found.policy.sent == "cuda"
    kept = learner(Stays(), device="auto", precision="float32", batch=5)
    assert kept.resolved_options == {"device": "cuda", "precision": "float32", "batch": 5}


def test_on_a_cpu_auto_is_what_the_processor_has(learner, monkeypatch):
    monkeypatch.setattr(torch.cuda, "is_available", lambda: False)
    precision = str(torch_precision("auto", "cpu", on_cpu=True)).removeprefix("torch.")
    plain, auto = (learner(n_episodes=3, **options) for options in ({"batch": 16, "precision": precision}, AUTO))
    assert auto.resolved_options == {"device": "cpu", "precision": precision, "batch": 16} == plain.resolved_options
    assert plain.step() == auto.step()
    states = [found.state_dict().tensors for found in (plain, auto)]
    assert all(torch.equal(value, states[1][name]) for name, value in states[0].items())


def test_a_state_of_another_network_is_refused(learner):
    state = learner(TinyPolicy(width=16)).state_dict()
    with pytest.raises(DataError, match="state of another learner"):
        learner().load_state_dict(state)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"policy": 3}, "no policy that can be trained"),
        ({"steps": 0}, r"learner\.steps=0: must be above 0"),
        ({"only": "memory"}, r"learner\.only=memory: expected null, or a list of names"),
        ({"only": ["chose"]}, r"learner\.only: unknown parameter or module 'chose': did you mean choose"),
        ({"batch": "all"}, r"learner\.batch=all: must be above 0 and whole"),
        ({"lr": "fast"}, r"learner\.lr=fast: must be above 0"),
        ({"average": 1.0}, r"learner\.average=1\.0: must be at least 0 and below 1"),
        ({"precision": "float8"}, "unknown precision 'float8'"),
        ({"device": "cuda:7"}, r"learner\.device=cuda:7: torch sees no such GPU"),
        ({"levels": "full"}, r"learner\.levels=full: expected a list"),
        ({"levels": ["ful"]}, "unknown habit level 'ful'"),
        ({"n_episodes": 99}, r"learner\.n_episodes=99: expected a whole number from 1 to 6"),
        ({"episodes": "nowhere"}, "unknown episode set or file 'nowhere'"),
        ({"episodes": "val"}, r"of the (val|test) part, which is not for training"),
        ({"episodes": "mini"}, r"of the (val|test) part, which is not for training"),
        ({"validation": {"episodes": "test"}}, r"of the test part, which must not choose checkpoints"),
        ({"validation": {"choose": "sr"}}, r"unknown figure of learner\.validation\.choose 'sr'"),
        ({"validation": {"n_play": 0}}, "nothing is played; choose loss or accuracy"),
        ({"validation": {"slots": 0}}, r"validation\.slots=0: must be a whole number from 1"),
    ],
)
def test_options_that_make_no_sense(learner, options, message):
    with pytest.raises(ConfigError if options.get("episodes") != "nowhere" else Exception, match=message) as caught:
        learner(**options)
    assert "\n" not in str(caught.value)


def test_a_policy_without_habits_has_one_level(learner):
    class Blind(TinyPolicy):
        uses_habits = False

    assert learner(Blind()).levels == ("none",)
    assert isinstance(Blind(), PolicyModule)


def test_the_training_set_is_of_the_train_part():
    """Its households are checked with those of all sets; its homes must not be used in any measured set."""
    homes = {episode.scene for episode in load_episodes("train")}
    measured = {episode.scene for name in ("mini", "val", "test", "test_large") for episode in load_episodes(name)}
    assert len(homes) == 800
    assert not homes & measured
    assert sum("~" in home for home in homes) == 400
