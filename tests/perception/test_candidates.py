from __future__ import annotations

from toy import ToyEnv, two_rooms

from ucon.perception.mapping.planner import UNREACHED, Planner
from ucon.perception.mapping.semantic_map import SemanticMap
from ucon.perception.places.target_places import Places
from ucon.perception.views.candidates import candidates, frontiers


def seen_after(actions: list[int]) -> tuple[ToyEnv, SemanticMap, Planner, Places]:
    env = ToyEnv(two_rooms(), "ring", (14, 4, 2))
    obs, info = env.reset()
    known, planner, places = SemanticMap(), Planner(info["nav"]), Places(0.1)
    known.update(obs, info)
    for action in actions:
        obs, _, _, _, info = env.step(action)
        known.update(obs, info)
        places.refresh(known)
        places.look(known, obs["depth"], places.share > 0, 3.0, 0.1)
    planner.update(known)
    return env, known, planner, places


def test_frontiers_border_on_the_unknown_and_can_be_reached() -> None:
    for actions in ([], [2, 2, 2, 2]):
        _, known, planner, _ = seen_after(actions)
        found = frontiers(known, planner)
        assert found
        for candidate in found:
            assert candidate.cost < UNREACHED
            i, j = candidate.view.i, candidate.view.j
            assert known.explored[i, j]
            assert not known.explored[i - 1 : i + 2, j - 1 : j + 2].all()


def test_an_explored_home_has_no_frontier() -> None:
    _, known, planner, _ = seen_after([])
    known.explored[:] = 1
    assert frontiers(known, planner) == []


def test_closed_containers_and_unseen_furniture_are_offered() -> None:
    walk = [1, 1, *[0] * 3, 2, *[0] * 4, 1, *[0] * 10]
    _, known, planner, places = seen_after(walk)
    found = candidates(known, planner, places)
    assert {c.kind for c in found} >= {"frontier", "container"}
    for candidate in found:
        assert candidate.cost < UNREACHED
        if candidate.kind == "container":
            assert candidate.category == "bottom_cabinet"
            assert known.gap_m(candidate.track, candidate.view.xy) <= 1.0
    known.opened[[c.track for c in found if c.kind == "container"]] = True
    assert not any(c.kind == "container" for c in candidates(known, planner, places))


def test_what_was_looked_at_is_no_landmark() -> None:
    _, known, planner, places = seen_after([2, 2, 2, 2])
    named = {c.track for c in candidates(known, planner, places) if c.kind == "landmark"}
    places.unseen[:] = 0.0
    assert not any(c.kind == "landmark" for c in candidates(known, planner, places))
    places.unseen[:] = 1.0
    assert {c.track for c in candidates(known, planner, places) if c.kind == "landmark"} >= named
