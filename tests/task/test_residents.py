"""The list of a home's residents for people agrees with the residents in episodes."""

from dataclasses import replace
from types import MappingProxyType

import pytest

from ucon.habits import book
from ucon.habits.verdicts import Verdict, Verdicts
from ucon.sim.cache import load_house
from ucon.task.making.living import living_in
from ucon.task.making.residents import BEARING, IMPORTED, UNHOSTED, residents


@pytest.mark.parametrize("scene", ["Rs_int", "office_large"])
def test_agrees_with_what_episodes_sample(scene):
    house = load_house(scene)
    everybody = residents(house, book())
    living = living_in(house, book())
    assert {one.category: one.hosts for one in everybody if one.refusal is None} == living
    assert {one.refusal for one in everybody} <= {None, BEARING, UNHOSTED}


def test_what_cannot_be_realised_has_a_reason():
    house = load_house("Rs_int")
    present = set(house.categories)
    for one in residents(house, book()):
        for host in one.hosts:
            for index, place in enumerate(host.entry.placements):
                note = one.notes.get((host.entry.id, index))
                assert (note in (None, IMPORTED)) == (index in host.realisable)
                assert (note is None) <= (place.anchor in present)


def test_a_verdict_is_the_reason():
    house = load_house("Rs_int")
    resident = next(one for one in residents(house, book()) if one.refusal is None)
    host = resident.hosts[0]
    place = host.placements[0]
    refused = Verdict(1, MappingProxyType({"Rs_int": "too_large"}))
    verdicts = Verdicts({(resident.category, place.relation, place.anchor): refused})
    again = next(o for o in residents(house, replace(book(), verdicts=verdicts)) if o.category == resident.category)
    assert again.notes[host.entry.id, host.realisable[0]] == "too_large"


def test_another_seed_other_people():
    house = load_house("Rs_int")
    first, second = residents(house, book()), residents(house, book(), seed=1)
    assert [one.category for one in first] == [one.category for one in second]
    assert [one.hosts for one in first] != [one.hosts for one in second]
