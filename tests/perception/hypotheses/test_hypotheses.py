"""Tests of the posterior over names and existence, from looks of a detector that errs."""

from __future__ import annotations

import numpy as np
import pytest

from ucon.perception.errors.model import read_errors
from ucon.perception.hypotheses.hypotheses import Hypotheses, limits_m2
from ucon.perception.hypotheses.look_kernels import FOUND, MISSED, MOST_OCTAVES, NEVER, look_key

PX = 128
#: A thing of 0.2 m, 2 m ahead of a camera at the origin that looks along +x, 1 m above the floor.
BOX = np.array([[1.9, -0.1, 0.9, 2.1, 0.1, 1.1]])
KIND = np.zeros(1, np.uint8)


def camera(x: float = 0.0, y: float = 0.0) -> np.ndarray:
    return np.array([x, y, 1.0, 1.0, 0.0, 1.0, 0.0, 64.0])


def depth(metres: float = 5.0) -> np.ndarray:
    return np.full((PX, PX), metres, np.float32)


def named(target: str = "mug") -> Hypotheses:
    return Hypotheses(read_errors("noisy"), target)


def seen(hypotheses: Hypotheses, name: str, score: float = 0.8, x: float = 0.0, y: float = 0.0) -> None:
    hypotheses.look(BOX, KIND, [""], {0: (name, score)}, depth(), camera(x, y))


def test_a_look_from_the_same_side_and_distance_counts_once() -> None:
    hypotheses = named()
    seen(hypotheses, "mug")
    once = hypotheses.p_target[0]
    seen(hypotheses, "mug", x=0.1)
    assert hypotheses.p_target[0] == once
    seen(hypotheses, "mug", x=1.0)
    assert hypotheses.p_target[0] > once
    assert len(hypotheses.looks[0]) == 2


def test_another_look_that_agrees_makes_sure() -> None:
    hypotheses = named()
    seen(hypotheses, "mug", 0.3)
    assert 0.5 < hypotheses.p_target[0] < 0.95
    seen(hypotheses, "mug", 0.5, x=1.0)
    assert hypotheses.p_target[0] > 0.99


def test_a_better_score_is_better_evidence() -> None:
    p = []
    for score in (0.3, 0.6, 0.9):
        hypotheses = named()
        seen(hypotheses, "mug", score)
        p.append(hypotheses.p_target[0])
    assert p == sorted(p)
    assert (1.0 - p[0]) > 20.0 * (1.0 - p[2])


def test_two_names_of_one_thing_are_weighed() -> None:
    """If two sides say mug and one says cup, the thing is called a mug, and the other name keeps some probability."""
    hypotheses = named("cup")
    category = [""]
    for k, name in enumerate(("mug", "cup", "mug")):
        at = camera(0.0, 0.0) if k == 0 else camera(1.0, 0.0) if k == 1 else camera(1.2, 1.0)
        for track, new in hypotheses.look(BOX, KIND, category, {0: (name, 0.7)}, depth(), at).items():
            category[track] = new
    assert category == ["mug"]
    share = hypotheses.named(("mug", "cup", "no such name"), 1)[0]
    assert share[0] > share[1] > 1e-4
    assert share[2] == 0.0


def test_looks_in_vain_speak_against_a_thing_but_only_where_it_would_show() -> None:
    hypotheses = named()
    seen(hypotheses, "mug", 0.4)
    before = hypotheses.exists[0]
    hypotheses.look(BOX, KIND, ["mug"], {}, depth(0.5), camera(0.9, 0.6))
    assert hypotheses.exists[0] == before, "something hides it"
    hypotheses.look(BOX, KIND, ["mug"], {}, depth(), camera(4.0, 0.0))
    assert hypotheses.exists[0] == before, "it is behind the camera"
    for x, y in ((1.0, 0.0), (1.1, 0.6), (1.1, -0.6)):
        hypotheses.look(BOX, KIND, ["mug"], {}, depth(), camera(x, y))
    assert hypotheses.exists[0] < before
    assert hypotheses.absent(0) < -0.5


def test_what_should_have_been_seen_and_was_not_loses_its_name() -> None:
    hypotheses, category = named("bottom_cabinet"), [""]
    box = np.array([[1.5, -0.4, 0.4, 2.3, 0.4, 1.2]])
    category[0] = hypotheses.look(box, KIND, category, {0: ("bottom_cabinet", 0.3)}, depth(), camera())[0]
    assert category == ["bottom_cabinet"]
    for x in (-0.8, -2.0, 0.8, 1.2):
        for y in (0.0, 0.5, -0.5, 1.0, -1.0):
            changed = hypotheses.look(box, KIND, category, {}, depth(9.0), camera(x, y))
            category[0] = changed.get(0, category[0])
    assert category == [""]
    assert hypotheses.exists[0] < 0.5


def test_a_found_look_takes_back_one_in_vain() -> None:
    hypotheses = named()
    seen(hypotheses, "mug")
    hypotheses.look(BOX, KIND, ["mug"], {}, depth(), camera(1.0))
    assert hypotheses.state_from(0, 1.0, 0.0, 0.0) == MISSED
    seen(hypotheses, "mug", x=1.0)
    assert hypotheses.absent(0) == pytest.approx(0.0)
    assert hypotheses.state_from(0, 1.0, 0.0, 0.0) == FOUND
    assert hypotheses.state_from(0, -1.0, 0.0, 0.0) == NEVER


def test_names_outside_the_vocabulary_say_nothing() -> None:
    hypotheses = named()
    changed = hypotheses.look(BOX, KIND, [""], {0: ("a thing that nobody knows", 0.9)}, depth(), camera())
    assert changed == {}
    assert hypotheses.p_target[0] < 0.1


def test_sides_without_trigonometry_are_those_with_it() -> None:
    limits = limits_m2(1.0)
    for angle in np.linspace(-np.pi, np.pi, 721)[:-1] + 1e-4:
        dx, dy = float(np.cos(angle)), float(np.sin(angle))
        side = int(np.floor(np.arctan2(dy, dx) / (np.pi / 4))) % 8
        assert look_key(dx, dy, 0.0, 8, limits) // MOST_OCTAVES == side
        assert look_key(dx, dy, 0.0, 16, limits) // MOST_OCTAVES == int(np.floor(np.arctan2(dy, dx) / (np.pi / 8))) % 16


def test_distances_are_octaves() -> None:
    limits = limits_m2(1.0)
    for metres in np.geomspace(0.3, 20.0, 60):
        step = min(max(int(np.round(np.log2(metres))) + 2, 0), MOST_OCTAVES - 1)
        assert look_key(float(metres), 0.0, 0.0, 8, limits) % MOST_OCTAVES == step


def test_there_is_room_for_many_tracks() -> None:
    hypotheses, n = named(), 300
    box = np.tile(BOX, (n, 1)) + np.linspace(0.0, 0.3, n)[:, None]
    called = dict.fromkeys(range(n), ("mug", 0.7))
    changed = hypotheses.look(box, np.zeros(n, np.uint8), [""] * n, called, depth(), camera())
    assert len(changed) == n
    assert (hypotheses.p_target[:n] > 0.0).all()


def test_another_search_forgets_what_may_have_been_moved() -> None:
    hypotheses = named()
    seen(hypotheses, "mug")
    hypotheses.search_again("bowl", [0])
    assert (hypotheses.exists[0], hypotheses.p_target[0]) == (0.0, 0.0)
    assert hypotheses.looks == {}
    assert not hypotheses.named(("mug", "bowl"), 1).any()
    fresh = named("bowl")
    for one in (hypotheses, fresh):
        seen(one, "bowl")  # from the same pose as before
    assert hypotheses.p_target[0] == fresh.p_target[0] > 0.5
    assert hypotheses.exists[0] == fresh.exists[0]


def test_another_search_keeps_furniture_and_asks_for_its_own_target() -> None:
    hypotheses, alone = named("mug"), named("sofa")
    for one in (hypotheses, alone):
        seen(one, "sofa")
    before = hypotheses.p_target[0]
    hypotheses.search_again("sofa", [])
    assert before < 0.5 < hypotheses.p_target[0]
    assert hypotheses.p_target[0] == pytest.approx(alone.p_target[0])
    assert hypotheses.exists[0] == pytest.approx(alone.exists[0])
    assert len(hypotheses.looks[0]) == 1
    hypotheses.search_again("mug", [200])  # a track without looks
    assert hypotheses.p_target[0] == pytest.approx(before)
