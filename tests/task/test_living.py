"""Who lives where, and that episodes with a stated context follow it."""

from collections import Counter
from dataclasses import replace

import pytest

from ucon.core.rng import stream
from ucon.habits import book
from ucon.habits.contexts import Context, condition_of
from ucon.habits.verdicts import Verdict, Verdicts
from ucon.scenes import SCENES, home_spec
from ucon.sim.cache import load_house
from ucon.task.episode import Episode
from ucon.task.making.living import any_placement, drawn_context, home_kinds, living_in, placement_now, placements_of
from ucon.task.making.sampler import EpisodeSampler

WHOLE = {"Rs_int": (), "office_large": ("office",), "grocery_store_cafe": ("shop",), "Pomaria_0_garden": ("garden",)}


@pytest.mark.parametrize(("scene", "kinds"), WHOLE.items())
def test_kinds_of_homes(scene, kinds):
    assert home_kinds(home_spec(scene)) == kinds


@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("part", ["train", "val", "test"])
def test_every_scene_offers_forty_targets(scene, part):
    assert len(living_in(load_house(scene), book(), part)) >= 40


def test_a_refused_placement_is_not_realisable():
    house, data = load_house("Rs_int"), book()
    living = living_in(house, data)
    host = next(h for found in living.values() for h in found if h.ok and len(h.realisable) > 2)
    place = host.placements[0]
    verdict = Verdict(1, {"Rs_int": "unstable"})
    refusing = replace(data, verdicts=Verdicts({(host.entry.category, place.relation, place.anchor): verdict}))
    (changed,) = [h for h in living_in(house, refusing)[host.entry.category] if h.entry.id == host.entry.id]
    assert place not in changed.placements
    assert place not in placements_of(house, refusing, [host.entry], None)


def contextual():
    """(living, category, host) of hosts with placements both with and without a context in one home."""
    living = living_in(load_house("Rs_int"), book())
    for name, hosts in living.items():
        for host in hosts:
            told = [p.context for p in host.placements]
            if host.ok and any(told) and not all(told):
                yield living, name, host


def test_a_placement_whose_context_is_fulfilled_comes_first_and_no_unfulfilled_one_is_used():
    seen = Counter()
    for number, (living, name, host) in enumerate(contextual()):
        for k in range(4):
            rng = stream(0, "test", number, k)
            context = drawn_context(living, [name], name, rng)
            context = replace(context, asker=host.entry.household)
            places = [host.entry.placements[d.index] for d in placement_now(living, name, context, rng)]
            holds = [p.context is not None and condition_of(p.context).holds(context) for p in places]
            assert all(h or p.context is None for h, p in zip(holds, places, strict=True))
            assert holds == sorted(holds, reverse=True)
            seen["fulfilled" if any(holds) else "always"] += 1
    assert min(seen["fulfilled"], seen["always"]) > 20


def test_without_a_context_every_realisable_placement_may_be_drawn():
    living, name, _ = next(contextual())
    drawn = any_placement(living, name, stream(0))
    assert len(drawn) == sum(len(h.realisable) for h in living[name] if h.ok)


def test_an_episode_that_states_its_context_follows_it_and_can_be_stored():
    sampler = EpisodeSampler(book(), context=True)
    for seed in range(3):
        episode = sampler.sample("Rs_int", seed, part="test")
        assert isinstance(episode.context, Context)
        assert Episode.from_json(episode.to_json()) == episode
        for entry_id, index in episode.placed_by:
            if entry_id:
                told = book().entries[book().entry_number[entry_id]].placements[index].context
                assert told is None or condition_of(told).holds(episode.context)
        target = book().entries[book().entry_number[episode.placed_by[episode.target][0]]]
        assert target.household == episode.context.asker
        locations = placements_of(load_house("Rs_int"), book(), [target], episode.context)
        assert (episode.target_object.relation, target.placements[episode.placed_by[episode.target][1]].anchor) in {
            (p.relation, p.anchor) for p in locations
        }
