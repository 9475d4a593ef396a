"""The map of a home between two searches, and expected mass where a thing was seen, in a home of boxes."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ucon.memory.map_memory import MapMemory
from ucon.perception.belief.coverage import Coverage, CoverageWeights
from ucon.perception.belief.recalled import EXACTLY, NEAR_M, Recalled, Remembering, remembering
from ucon.perception.mapping.semantic_map import SemanticMap
from ucon.perception.places.hollows import ALL_OPEN
from ucon.perception.places.target_places import Places

sys.path.insert(0, str(Path(__file__).parents[1] / "perception"))
from toy import Thing, ToyEnv, ToyHome, two_rooms

BOWL = (2.2, 2.9, 0.45, 2.35, 3.05, 0.53)
BOWL_LATER = (2.2, 2.6, 0.45, 2.35, 2.75, 0.53)
ONTOP = 0


def home(bowl: tuple[float, ...] = BOWL) -> ToyHome:
    made = two_rooms()
    made.things = [Thing("bowl", bowl) if thing.category == "bowl" else thing for thing in made.things]  # type: ignore[arg-type]
    return made


def looked(env: ToyEnv, known: SemanticMap, actions: tuple[int, ...], frame: Any = None) -> None:
    obs, info = frame or env.reset()
    known.update(obs, info)
    for action in actions:
        obs, _, _, _, info = env.step(action)
        known.update(obs, info)


#: Look around from the door of the living room.
AROUND = (2, 2, 2, 2)


@pytest.fixture
def known() -> SemanticMap:
    found = SemanticMap(target="teapot")
    looked(ToyEnv(home(), "teapot", (14, 4, 2)), found, AROUND)
    return found


def second_look(known: SemanticMap, bowl: tuple[float, ...]) -> None:
    """Look again, with a detector that continues the earlier tracks."""
    before, after = ToyEnv(home(), "teapot", (14, 4, 2)), ToyEnv(home(bowl), "teapot", (14, 4, 2))
    before.reset()
    for action in AROUND:
        before.step(action)
    after.reset()
    after.tracks = dict(before.tracks)
    looked(after, known, AROUND[:3], after._look(()))


def test_rooms_and_furniture_stay_known(known: SemanticMap) -> None:
    assert not known.lived_in
    explored, floor, walls = known.explored.copy(), known.floor.copy(), known.walls.copy()
    sofa = known.box[known.instances["sofa"][0]].copy()
    known.search_again("teapot")
    assert (known.explored == explored).all()
    assert (known.box[known.instances["sofa"][0]] == sofa).all()
    second_look(known, BOWL)
    for before, after in ((explored, known.explored), (floor, known.floor), (walls, known.walls)):
        assert (after >= before).all()
        assert before.any()


def test_poses_and_steps_begin_anew(known: SemanticMap) -> None:
    known.bumped[3, 3] = 1
    known.opened[known.instances["sofa"]] = True
    known.search_again("teapot")
    assert (known.step, known.views) == (0, [])
    assert known.lived_in
    assert not known.visited.any()
    assert not known.bumped.any()
    assert not known.opened.any()
    assert (known.last_seen == -1).all()
    second_look(known, BOWL)
    assert known.step == 3


def test_the_target_counts_as_unseen_and_others_where_they_were(known: SemanticMap) -> None:
    (bowl,) = known.instances["bowl"]
    box = known.box[bowl].copy()
    known.search_again("teapot")
    assert known.seen(bowl)
    assert (known.box[bowl] == box).all()
    known.search_again("bowl")
    assert known.instances["bowl"] == [bowl]
    assert not known.seen(bowl)
    second_look(known, BOWL)
    assert known.box[bowl] == pytest.approx(box, abs=0.02)


def test_a_small_thing_that_was_moved_is_where_it_is_seen(known: SemanticMap) -> None:
    (bowl,) = known.instances["bowl"]
    before = known.box[bowl].copy()
    known.search_again("teapot")
    second_look(known, BOWL_LATER)
    moved, sofa = known.box[bowl], known.instances["sofa"][0]
    assert np.linalg.norm((moved - before)[:3]) == pytest.approx(0.3, abs=0.05)
    assert (moved[3:] - moved[:3]).max() < 0.2, "a box around both places"
    assert not known.stale[bowl]
    assert not known.stale[sofa]


def test_furniture_is_not_forgotten_when_seen_again(known: SemanticMap) -> None:
    sofa = known.instances["sofa"][0]
    before = known.box[sofa].copy()
    known.search_again("bowl")
    second_look(known, BOWL)
    assert (known.box[sofa][:3] <= before[:3]).all()
    assert (known.box[sofa][3:] >= before[3:]).all()


def test_map_memory_gives_the_same_map_to_every_search() -> None:
    memory, env = MapMemory(), ToyEnv(home(), "teapot", (14, 4, 2))
    obs, info = env.reset()
    info = info | {"target": "teapot", "task": "paper"}
    first = memory.begin(info)
    assert "kept_map" not in info
    kept = SemanticMap.of(first)
    looked(env, kept, AROUND, (obs, info))
    memory.look(obs, info)
    memory.end()
    again = SemanticMap.of(memory.begin(info | {"target": "bowl"}))
    assert again is kept
    assert not again.views
    assert not again.seen(again.instances["bowl"][0])
    assert SemanticMap.of(info) is not kept


@pytest.fixture
def places(known: SemanticMap) -> Places:
    made = Places(0.1)
    made.refresh(known)
    return made


def point_on(known: SemanticMap, places: Places, category: str) -> np.ndarray:
    (track,) = known.instances[category]
    rows = np.flatnonzero((places.track == track) & (places.relation == ONTOP) & (places.share > 0.0))
    return places.xyz[rows[0]].copy()


def test_remembered_places_have_their_mass_and_the_rest_is_scaled(known: SemanticMap, places: Places) -> None:
    inner = Coverage("bowl", CoverageWeights())
    table, sofa = known.instances["coffee_table"][0], known.instances["sofa"][0]
    xyz = np.array(
        [point_on(known, places, "coffee_table") + np.array([0.0, 0.0, 0.05]), point_on(known, places, "sofa")]
    )
    plain = inner.expect(known, places)
    found = Remembering(inner, Recalled(xyz, np.array([0.5, 0.2]))).expect(known, places)
    added = np.zeros_like(plain.mass)
    added[table, ONTOP], added[sofa, ONTOP] = 0.5 * plain.unit, 0.2 * plain.unit
    assert found.mass == pytest.approx(0.3 * plain.mass + added)
    assert found.unknown_per_m2 == pytest.approx(0.3 * plain.unknown_per_m2)
    assert found.near_per_m2 == pytest.approx(0.3 * plain.near_per_m2)
    assert found.unit == plain.unit
    assert (inner.expect(known, places).mass == plain.mass).all(), "what is expected without memory was written to"


def test_two_memories_of_one_place_add_up(known: SemanticMap, places: Places) -> None:
    inner, table = Coverage("bowl", CoverageWeights()), known.instances["coffee_table"][0]
    xyz = np.tile(point_on(known, places, "coffee_table"), (2, 1))
    found = Remembering(inner, Recalled(xyz, np.array([0.25, 0.5]))).expect(known, places)
    plain = inner.expect(known, places)
    assert found.mass[table, ONTOP] == pytest.approx(0.25 * plain.mass[table, ONTOP] + 0.75 * plain.unit)


def test_a_remembered_place_has_a_point_of_its_own(known: SemanticMap, places: Places) -> None:
    inner, before = Coverage("bowl", CoverageWeights()), len(places.xyz)
    xyz = point_on(known, places, "coffee_table") + np.array([0.11, 0.07, 0.02])
    making = Remembering(inner, Recalled(xyz[None], np.array([0.5])))
    found = making.expect(known, places)
    assert len(places.xyz) == before + 1
    assert places.xyz[-1] == pytest.approx(xyz)
    assert places.weights(found.mass)[-1] == pytest.approx(EXACTLY * 0.5 * found.unit)
    places.unseen[-1] = 0.1
    again = making.expect(known, places)
    assert len(places.xyz) == before + 1, "a second point of one place"
    assert (again.mass == found.mass).all()
    assert places.searched(np.zeros(known.n_tracks, bool))[-1]


def test_what_holds_a_thing_counts_before_what_is_nearer(known: SemanticMap, places: Places) -> None:
    inner = Coverage("bowl", CoverageWeights())
    table = known.instances["coffee_table"][0]
    at = point_on(known, places, "coffee_table")
    others = np.flatnonzero((places.track != table) & (places.even > 0.0))
    other = others[np.linalg.norm(places.xyz[others] - at, axis=1).argmin()]
    xyz, near = places.xyz[other].copy(), places.track[other]
    assert np.linalg.norm(xyz - at) < 1.0
    plain = inner.expect(known, places).mass
    for spots, expected in (((), near), (((("ontop", "coffee_table"),),), table), (((("inside", "fridge"),),), near)):
        fresh = Places(0.1)
        fresh.refresh(known)
        found = Remembering(inner, Recalled(xyz[None], np.array([0.9]), spots)).expect(known, fresh)
        assert (found.mass - 0.1 * plain).sum(1).argmax() == expected


def test_a_place_goes_to_its_anchor_once_that_is_mapped(known: SemanticMap) -> None:
    """Before that, it goes to a nearby thing."""
    whole = Places(0.1)
    whole.refresh(known)
    table = known.instances["coffee_table"][0]
    xyz, recalled = point_on(known, whole, "coffee_table"), (((("ontop", "coffee_table"),),))
    name, box = known.category[table], known.box[table].copy()
    known.category[table], known.box[table] = "", (1e3, 1e3, 1e3, -1e3, -1e3, -1e3)
    places, inner = Places(0.1), Coverage("bowl", CoverageWeights())
    places.refresh(known)
    making = Remembering(inner, Recalled(xyz[None], np.array([0.9]), recalled))
    making.expect(known, places)
    before = making._rows.copy()
    assert places.track[before[0]] != table
    known.category[table], known.box[table] = name, box
    places.refresh(known)
    found = making.expect(known, places)
    assert (making._rows == before).all()
    assert (places.track[before[0]], places.relation[before[0]]) == (table, ONTOP)
    assert places.weights(found.mass)[before[0]] == pytest.approx(EXACTLY * 0.9 * found.unit)
    assert found.mass[table, ONTOP] == pytest.approx(
        (0.9 + 0.1 * inner.expect(known, places).mass[table, ONTOP] / found.unit) * found.unit
    )


def test_no_mass_is_lost_where_a_thing_turns_out_to_be_nothing(known: SemanticMap, places: Places) -> None:
    inner, table = Coverage("bowl", CoverageWeights()), known.instances["coffee_table"][0]
    xyz = point_on(known, places, "coffee_table")
    making = Remembering(inner, Recalled(xyz[None], np.array([0.9])))
    making.expect(known, places)
    known.category[table] = ""
    known.named_at[table] = known.step
    places._named = known.step - 1
    places.refresh(known)
    found = making.expect(known, places)
    fresh = Places(0.1)
    fresh.refresh(known)
    anew = Remembering(inner, Recalled(xyz[None], np.array([0.9]))).expect(known, fresh)
    assert found.mass == pytest.approx(anew.mass)
    assert places.weights(found.mass).sum() == pytest.approx(fresh.weights(anew.mass).sum())


def test_points_are_noted_beyond_the_room_for_them_and_not_for_nothing(known: SemanticMap, places: Places) -> None:
    xyz, before = np.tile(point_on(known, places, "coffee_table"), (1500, 1)), len(places.xyz)
    p = np.full(1500, 0.5 / 1499)
    p[700] = 0.0
    making = Remembering(Coverage("bowl", CoverageWeights()), Recalled(xyz, p))
    found = making.expect(known, places)
    assert len(places.xyz) == before + 1499
    assert making._rows[700] == -1
    own = places.weights(found.mass)[before:]
    assert own == pytest.approx(np.full(1499, EXACTLY * found.unit * p[0]))


def test_places_have_as_many_spots_or_none() -> None:
    with pytest.raises(ValueError, match="1 spots of 2 places"):
        Recalled(np.zeros((2, 3)), np.zeros(2), ((("ontop", "sofa"),),))


def test_a_point_outside_its_compartment_may_be_seen_from_everywhere(known: SemanticMap, places: Places) -> None:
    hollow = np.flatnonzero((places.faces != ALL_OPEN) & (places.even > 0.0))
    like = int(hollow[0])
    within = places.note(places.xyz[like], like)
    beyond = places.note(places.hollow[like, 3:] + 0.05, like)
    assert places.faces[within] == places.faces[like]
    assert places.faces[beyond] == ALL_OPEN
    assert (places.track[[within, beyond]] == places.track[like]).all()


def test_a_place_keeps_its_point_where_those_of_its_thing_are_replaced(known: SemanticMap, places: Places) -> None:
    inner, table = Coverage("bowl", CoverageWeights()), known.instances["coffee_table"][0]
    xyz = point_on(known, places, "coffee_table")
    making = Remembering(inner, Recalled(xyz[None], np.array([0.5])))
    making.expect(known, places)
    known.box[table, 3:5] += 0.3
    places.refresh(known)
    rows, p = making._at(known, places)
    assert p.tolist() == [0.5]
    assert (places.even[rows] > 0.0).all()
    assert places.xyz[rows[0]] == pytest.approx(xyz)


def test_a_place_that_the_map_lacks_says_nothing(known: SemanticMap, places: Places) -> None:
    inner = Coverage("bowl", CoverageWeights())
    far = places.xyz[places.share > 0.0].max(0) + np.array([0.0, 0.0, 1.1 * NEAR_M])
    found = Remembering(inner, Recalled(far[None], np.array([0.9]))).expect(known, places)
    assert (found.mass == inner.expect(known, places).mass).all()
    nothing = Places(0.1)
    assert Remembering(inner, Recalled(far[None], np.array([0.9])))._at(known, nothing)[1].shape == (0,)


def test_a_search_remembers_where_there_is_something() -> None:
    inner = Coverage("bowl", CoverageWeights())
    assert remembering(inner, {"target": "bowl"}) is inner
    made = remembering(inner, {"recalled": Recalled(np.zeros((0, 3)), np.zeros(0))})
    assert isinstance(made, Remembering)
    assert made.locations is None
