"""``check-env``: our environments keep their contract, and every violation is caught."""

from __future__ import annotations

import json
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from tests.envs.mutants import OF_ACTIONS, OF_CHOICES
from ucon.__main__ import main
from ucon.core.errors import ConfigError
from ucon.envs.checking import check, subject_of
from ucon.envs.checking.findings import same
from ucon.envs.checking.subject import OURS, wrapped

pytestmark = pytest.mark.filterwarnings("ignore::UserWarning")


@pytest.mark.parametrize("name", OURS)
def test_our_environments_keep_what_the_task_promises(name: str) -> None:
    findings = list(check(subject_of(name)))
    assert len(findings) >= 14
    assert [finding.line() for finding in findings if not finding.ok] == []


#: The check that catches each fault.
CAUGHT_BY = {
    "WorldFrame": "frame", "MirroredFrame": "frame", "Degrees": "frame", "LeakedPosition": "secrets",
    "LeakedScene": "secrets", "LeakedSolution": "secrets", "LeakedDistance": "unseen target", "Undead": "after the end",
    "SeedsIgnored": "seeds", "SeedsForgotten": "seeds", "EpisodeIgnored": "episodes", "RewardedFailure": "rewards",
    "UnpaidSuccess": "rewards", "MaskedMoves": "masks", "OtherLevel": "habits", "HabitMaskLate": "habits",
    "OtherTarget": "target", "Stale": "camera", "Millimetres": "camera", "SharedCopies": "copies",
    "StiffCopies": "copies", "CutEarly": "last step", "CutNever": "last step", "DoneGoesOn": "done",
    "AlwaysSuccess": "figures", "TurnsCount": "figures", "NeverCollides": "collision",
    "LateAction": "last action, step", "StepsFromOne": "last action, step",
    "AnyAction": "actions", "WrongType": "spaces", "StillPicture": "frames",
}  # fmt: skip


@pytest.mark.parametrize("mutant", OF_ACTIONS, ids=lambda cls: cls.__name__)
def test_a_broken_environment_is_caught(mutant: Any) -> None:
    failed = [finding.check for finding in check(wrapped(subject_of("UcON-v0"), mutant)) if not finding.ok]
    assert CAUGHT_BY[mutant.__name__] in failed


@pytest.mark.parametrize("mutant", OF_CHOICES, ids=lambda cls: cls.__name__)
def test_a_broken_mask_is_caught(mutant: Any) -> None:
    assert any(not finding.ok for finding in check(wrapped(subject_of("UcONSearch-v0"), mutant)))


def test_the_command_prints_a_line_a_check_and_counts_failures(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check-env", "tests.envs.mutants:NeverCollides", "--json"]) == 1
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert [line["check"] for line in lines if not line["ok"]] == ["collision"]
    assert all(line["expected"] and line["found"] for line in lines)


@pytest.mark.parametrize(
    ("word", "said"),
    [
        ("UcON-v7", "did you mean UcON-v0"),
        ("CartPole-v1", "made of CartPoleEnv"),
        ("nothing_here:Env", "not found"),
        ("json:__doc__", "expected a class or a function"),
    ],
)
def test_what_is_no_environment_of_ours_is_one_line(word: str, said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        subject_of(word)


def test_a_harmless_wrapper_passes() -> None:
    findings = list(check(wrapped(subject_of("UcON-v0"), gym.wrappers.RecordEpisodeStatistics)))
    assert [finding.line() for finding in findings if not finding.ok] == []


@pytest.mark.parametrize(
    ("a", "b", "alike"),
    [
        (1, 1.0, True), (1, 2.0, False), (True, np.bool_(True), True), (np.float32(0.5), 0.5, True), (1, "1", False),
        ("1", 1, False), ((1, 2), [1, 2], True), ((1, 2), (1,), False), ({"a": 1}, {"a": 1}, True),
        ({"a": 1}, {"b": 1}, False), (np.zeros(2), np.zeros(2, np.float32), False), (np.zeros(2), np.zeros(2), True),
        (None, None, True), (None, 0, False),
    ],
)  # fmt: skip
def test_what_is_the_same(a: Any, b: Any, alike: bool) -> None:
    assert same(a, b) is alike
