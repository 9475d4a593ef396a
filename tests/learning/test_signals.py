"""Real learners that get a signal anywhere in a run: they save within seconds and continue to the same bytes."""

import os
import signal
import time

import pytest

from tests.learning.test_imitation import files
from tests.learning.tiny_policy import TinyPolicy, tiny_dagger, tiny_imitation, training_file
from tests.learning.tiny_ppo import tiny_ppo
from ucon.learning.ppo.collecting import InWorkers
from ucon.learning.run import stopping
from ucon.learning.run.training_run import Interrupted, Plan, TrainingRun

STEPS = 5
PLAN = Plan(steps=STEPS, validate_every=4, save_every=2, keep=2)
#: Promised limit on the seconds from the signal to the end.
MOST_S = 5.0


def imitation(episodes, **options):
    return tiny_imitation(None, TinyPolicy(dropout=0.2), episodes=episodes, steps=STEPS, average=0.8, **options)


def imitation_in_workers(episodes):
    return imitation(episodes, workers=1)


def dagger(episodes):
    few = {"per_iteration": 2, "episodes": 3, "max_steps": 12}
    return tiny_dagger(None, TinyPolicy(dropout=0.2), few, episodes=episodes, steps=STEPS, average=0.8)


def ppo(episodes, **options):
    return tiny_ppo(None, TinyPolicy(dropout=0.2), episodes=episodes, steps=STEPS, average=0.8, **options)


def ppo_in_workers(episodes):
    return ppo(episodes, collector=InWorkers(2), levels=("none",))


#: Where the signal comes: the learner, an object of the run, its method, and the number of the call.
PLACES = {
    "validating the initial state": (imitation, lambda run: run.learner.validation, "played", 1),
    "before the first step": (ppo, lambda run: run.learner, "step", 1),
    "playing": (ppo, lambda run: run.learner.rollouts, "_collected", 3),
    "learning": (ppo, lambda run: run.learner.updates, "take", 7),
    "collecting": (dagger, lambda run: run.learner, "_collect", 2),
    "validating": (dagger, lambda run: run.learner.validation, "played", 2),
    "saving": (imitation, lambda run: run.checkpoints, "_put", 2),
    "in the last step": (imitation, lambda run: run.learner.updates, "take", STEPS),
}
WITH_WORKERS = {
    "waiting for who plays ahead": (imitation_in_workers, lambda run: run.learner.feeder, "_receive", 5),
    "waiting for who gathers experience": (ppo_in_workers, lambda run: run.learner.rollouts, "_collected", 2),
}
SIGNALS = [signal.SIGINT, signal.SIGTERM]
SLOW = pytest.mark.slow


def cases(places):
    """Each place with both signals, with and without a hang; one case per learner is ordinary, the others slow."""
    quick = {("before the first step", False), ("validating", True), ("saving", False)}
    for place in places:
        for number in SIGNALS:
            for hangs in (False, True):
                if hangs and place == "saving":
                    continue  # a save in progress is never abandoned
                ordinary = (place, hangs) in quick and number == SIGNALS[hangs]
                name = f"{place}-{number.name}{'-hangs' if hangs else ''}"
                yield pytest.param(place, number, hangs, id=name, marks=() if ordinary else SLOW)


@pytest.fixture(scope="module")
def episodes(tmp_path_factory):
    return training_file(tmp_path_factory.mktemp("episodes"))


@pytest.fixture(scope="module")
def whole(tmp_path_factory, episodes):
    """Files of a run without a signal, by the function that makes its learner."""
    made = {}

    def of(make):
        if make not in made:
            folder = tmp_path_factory.mktemp("whole") / make.__name__
            begun(make, episodes, folder)
            made[make] = files(folder)
        return made[make]

    return of


def begun(make, episodes, folder, prepare=lambda run: None, resume=False):
    """Start or continue a run until it ends."""
    learner = make(episodes)
    run = TrainingRun(folder, learner, PLAN, {})
    try:
        run.resume() if resume else run.start("a: 1\n")
        prepare(run)
        run.run()
    finally:
        learner.close()


def disturb(owner, method, call, number, hangs, told):
    """Send a signal in one call of a method of ``owner``; with ``hangs``, the call then sleeps for a minute."""
    done, calls = getattr(owner, method), 0

    def disturbed(*args, **options):
        nonlocal calls
        calls += 1
        if calls == call:
            told.append(time.monotonic())
            os.kill(os.getpid(), number)
            if hangs:
                time.sleep(60)
        return done(*args, **options)

    object.__setattr__(owner, method, disturbed)


@pytest.mark.parametrize(("place", "number", "hangs"), cases(PLACES | WITH_WORKERS))
def test_a_signal_at_any_place_is_saved_in_time_and_the_rest_is_the_same(
    monkeypatch, tmp_path, episodes, whole, place, number, hangs
):
    """A step that hangs is abandoned, and repeated when the run continues."""
    monkeypatch.setattr(stopping, "GRACE_S", 0.2)
    make, owner, method, call = (PLACES | WITH_WORKERS)[place]
    folder, told = tmp_path / "run", []
    stopped = None
    try:
        begun(make, episodes, folder, lambda run: disturb(owner(run), method, call, number, hangs, told))
    except Interrupted as caught:
        stopped = caught
    assert time.monotonic() - told[0] < MOST_S
    if stopped is None:
        assert not hangs
        assert place == "in the last step", "there was nothing left to do"
    else:
        assert stopped.number == number
        assert stopped.abandoned or not hangs
        begun(make, episodes, folder, resume=True)
    ours, theirs = files(folder), whole(make)
    assert ours.keys() == theirs.keys()
    assert [name for name in ours if ours[name] != theirs[name]] == []


def test_an_error_in_the_wake_of_abandoning_hides_nothing(monkeypatch, tmp_path, episodes):
    """As TorchRL does when an exception interrupts the start of its workers."""
    monkeypatch.setattr(stopping, "GRACE_S", 0.2)

    def prepare(run):
        def step():
            try:
                os.kill(os.getpid(), signal.SIGTERM)
                time.sleep(60)
            except BaseException:
                raise RuntimeError from None

        run.learner.step = step

    with pytest.raises(Interrupted) as stopped:
        begun(imitation, episodes, tmp_path / "run", prepare)
    assert (stopped.value.step, stopped.value.abandoned) == (0, True)


def test_a_step_that_goes_on_is_abandoned_in_three_seconds_and_the_state_before_it_is_saved(
    monkeypatch, tmp_path, episodes, whole
):
    """With the real grace period, in a step before which nothing was saved to disk."""
    monkeypatch.setattr("ucon.learning.run.training_run._SLOW_S", 0.0)
    folder, told = tmp_path / "run", []
    with pytest.raises(Interrupted) as stopped:
        begun(
            imitation, episodes, folder,
            lambda run: disturb(run.learner.updates, "take", 4, signal.SIGTERM, True, told),
        )  # fmt: skip
    assert stopping.GRACE_S <= time.monotonic() - told[0] < MOST_S
    assert (stopped.value.step, stopped.value.abandoned) == (3, True)
    begun(imitation, episodes, folder, resume=True)
    assert files(folder) == whole(imitation)
