"""Things in a closed container cannot be seen from anywhere; when it is open, they can be seen from somewhere."""

import pytest

from tests.sim.homes import FAST_SCENES
from tests.sim.triples import house_of, sample, try_triple
from ucon.scenes import SCENES
from ucon.sim.arrangement import Arrangement, PlacedObject
from ucon.sim.checks import near_nodes
from ucon.sim.placement import with_object
from ucon.sim.render import RasterRenderer

EYE_M = 1.25
VISIBLE_PX = 4
PITCHES = (0, -30, -60, 30, 60)


def seen_from(renderer, nodes, instance):
    """Most pixels of an instance over nodes, headings and pitches; stops as soon as it counts as visible."""
    best = 0
    for x, y in nodes:
        for pitch in PITCHES:
            for heading in range(4):
                best = max(best, int(renderer.visible(float(x), float(y), EYE_M, heading, pitch)[instance]))
                if best >= VISIBLE_PX:
                    return best
    return best


def check(count, scenes):
    renderer = RasterRenderer()
    leaks, unseen, total = [], [], 0
    for triple, name in sample("inside", count, scenes):
        house = house_of(name)
        placed = try_triple(triple, name)
        if not isinstance(placed, PlacedObject) or placed.holder < 0:
            continue
        total += 1
        renderer.load(house, with_object(house, Arrangement(), placed))
        nodes = house.grid.xy(near_nodes(house.grid, house.boxes[placed.anchor], 1.5))
        if seen_from(renderer, nodes[::2], house.n_instances) > 0:
            leaks.append((*triple, name))
        renderer.set_open(placed.holder, 1.0)
        within = house.grid.xy(near_nodes(house.grid, house.boxes[placed.anchor], 1.0))
        if seen_from(renderer, within, house.n_instances) < VISIBLE_PX:
            unseen.append((*triple, name))
    return leaks, unseen, total


def test_a_sample_is_hidden_then_seen():
    leaks, unseen, total = check(40, FAST_SCENES)
    assert total >= 15
    assert not leaks
    assert len(unseen) <= 1, unseen


@pytest.mark.slow
def test_all_are_hidden_and_99_percent_seen():
    leaks, unseen, total = check(0, SCENES)
    assert total >= 300
    assert not leaks, leaks[:10]
    assert len(unseen) <= 0.01 * total, (len(unseen), total, unseen[:20])
