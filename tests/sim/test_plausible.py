"""Placements that no home can realise, judged by shapes alone; the samplers agree."""

import pytest

from tests.sim.homes import FAST_SCENES
from tests.sim.triples import Triple, house_of, sample, triples, try_triple
from ucon.core.errors import ConfigError
from ucon.objects.model import RELATIONS
from ucon.sim.arrangement import PlacedObject
from ucon.sim.placement import REASONS, implausible


@pytest.mark.parametrize(
    ("category", "relation", "anchor", "reason"),
    [
        ("bathtub", "nextto", "sofa", "implausible"),
        ("notebook", "inside", "walls", "implausible"),
        ("mug", "ontop", "ceilings", "implausible"),
        ("mug", "nextto", "floors", "implausible"),
        ("mug", "inside", "breakfast_table", "not_a_container"),
        ("mug", "ontop", "floor_lamp", "not_a_support"),
        ("mug", "under", "bottom_cabinet", "no_room_under"),
        ("bicycle", "inside", "bottom_cabinet", "too_large"),
        ("broom", "under", "top_cabinet", None),
        ("bicycle", "under", "sofa", "too_large"),
        ("mug", "ontop", "breakfast_table", None),
        ("mug", "inside", "top_cabinet", None),
        ("mug", "under", "breakfast_table", None),
        ("bicycle", "nextto", "walls", None),
        ("bicycle", "ontop", "floors", None),
        ("picture", "ontop", "coffee_table", None),
    ],
)
def test_the_reason(category, relation, anchor, reason):
    found = implausible(category, relation, anchor)
    assert (found and found[0]) == reason
    assert reason is None or reason in REASONS
    assert found is None or category in found[1] or anchor in found[1]


def test_a_larger_cabinet_takes_what_a_small_one_does_not():
    assert implausible("ice_bucket", "inside", "bottom_cabinet", (0.3, 0.3, 0.3))[0] == "too_large"
    assert implausible("ice_bucket", "inside", "bottom_cabinet", (0.6, 1.2, 0.9)) is None


def test_unknown_categories_are_named():
    with pytest.raises(ConfigError, match="did you mean mug"):
        implausible("mugg", "ontop", "breakfast_table")
    with pytest.raises(ConfigError, match="did you mean breakfast_table"):
        implausible("mug", "ontop", "breakfast_tabel")


@pytest.mark.parametrize("relation", RELATIONS)
def test_plausible_triples_of_the_official_data_are_plausible_here(relation):
    of_it = [t for t in triples() if t.relation == relation]
    refused = [t for t in of_it if implausible(*t)]
    assert len(refused) <= 0.05 * len(of_it), refused


def test_what_is_refused_by_shape_the_samplers_refuse_too():
    """With targets swapped among the triples, many are implausible, and none of those can be placed."""
    chosen = [(t, name) for relation in RELATIONS for t, name in sample(relation, 150, FAST_SCENES)]
    mixed = [
        (Triple(a.target, b.relation, b.anchor), name)
        for (a, _), (b, name) in zip(chosen, chosen[7:] + chosen[:7], strict=True)
    ]
    refused = [(t, name) for t, name in mixed if all(_refusals(t, name))]
    assert len(refused) >= 10
    placed = [(t, name) for t, name in refused if isinstance(try_triple(t, name), PlacedObject)]
    assert not placed


def _refusals(triple, name):
    sizes = [item.size for item in house_of(name).spec.items if item.category == triple.anchor]
    return [implausible(*triple, size) for size in sizes or (None,)]
