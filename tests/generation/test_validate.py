"""Validation: placements that PyBullet refuses get its reason; the result is the same with any number of processes."""

import pytest

from ucon.core.errors import DataError
from ucon.generation.validate import NEVER_SEEN, dataset_triples, try_triple, validate
from ucon.habits import book
from ucon.scenes import SCENES
from ucon.sim.cache import load_house
from ucon.sim.placement import REASONS, importable
from ucon.sim.render import RasterRenderer

SOUND = [("apple", "ontop", "coffee_table"), ("apple", "inside", "fridge"), ("backpack", "nextto", "sofa")]
ABSURD = [("guitar", "inside", "microwave"), ("bathtub", "nextto", "sofa"), ("backpack", "ontop", "door")]
IMPORTED = ("apple", "inside", "wicker_basket")


@pytest.mark.parametrize("triple", SOUND)
def test_sound_placements_hold(triple):
    assert try_triple(load_house("Rs_int"), triple, RasterRenderer()) is None


@pytest.mark.parametrize("triple", ABSURD)
def test_absurd_placements_are_refused_with_a_reason(triple):
    assert try_triple(load_house("Rs_int"), triple, RasterRenderer()) in {*REASONS, NEVER_SEEN}


def test_a_missing_anchor_is_brought_in_where_it_can_be():
    home = next(h for h in SCENES if IMPORTED[2] not in load_house(h).categories)
    assert importable(IMPORTED[2])
    assert try_triple(load_house(home), IMPORTED, RasterRenderer()) is None
    assert try_triple(load_house(home), ("apple", "nextto", "swimming_pool"), RasterRenderer()) == "not_importable"


def test_every_placement_of_the_book_is_tried_somewhere_and_wherever_its_anchor_stands():
    wanted = dataset_triples(book())
    tried = {triple for triples in wanted.values() for triple in triples}
    assert tried == {(e.category, p.relation, p.anchor) for e in book().entries for p in e.placements}
    assert tried == set(book().verdicts.of)
    for home, triples in wanted.items():
        there = {t for t in tried if t[2] in load_house(home).categories}
        assert there <= set(triples)


def test_verdicts_do_not_depend_on_processes_and_interrupted_work_goes_on(tmp_path):
    wanted = {"Rs_int": [*SOUND, *ABSURD], "Benevolence_0_int": [SOUND[2]]}
    alone = validate(wanted, tmp_path / "one", workers=0)
    calls = []
    both = validate(wanted, tmp_path / "two", workers=2, progress=lambda *a: calls.append(a))
    assert alone.to_json() == both.to_json()
    assert calls[-1] == (7, 7)
    first = sorted((tmp_path / "two").glob("*.json"))[0]
    first.unlink()
    assert validate(wanted, tmp_path / "two", workers=0).to_json() == alone.to_json()
    first.write_text("[1, 2]")
    with pytest.raises(DataError, match="not the verdicts of"):
        validate(wanted, tmp_path / "two", workers=0)
    assert alone.of[SOUND[2]].tried == 2


def test_shipped_verdicts_are_those_of_this_code():
    """A sample of the shipped verdicts, tried again."""
    of = book().verdicts.of
    eyes = RasterRenderer()
    for home in ("Rs_int", "office_large"):
        triples = dataset_triples(book())[home][::400]
        again = {t: try_triple(load_house(home), t, eyes) for t in triples}
        assert again == {t: of[t].refused.get(home) for t in triples}
