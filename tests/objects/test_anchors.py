"""Every anchor of the habit book supports each relation that the book allows for it."""

from __future__ import annotations

from importlib.resources import files

import pytest

from ucon.objects import build_model, catalogue
from ucon.objects.model import RELATIONS


def allowed() -> list[tuple[str, str]]:
    lines = (files("ucon") / "habits" / "book" / "anchors.txt").read_text(encoding="utf-8").splitlines()
    pairs = []
    for line in lines:
        if line.strip() and not line.startswith("#"):
            name, relations = line[1:].split(":")
            pairs += [(name.strip(), relation) for relation in relations.split()]
    return pairs


PAIRS = allowed()


def test_the_book_is_read() -> None:
    assert len(PAIRS) > 100
    assert {relation for _, relation in PAIRS} == set(RELATIONS)


@pytest.mark.parametrize(("anchor", "relation"), PAIRS)
def test_anchor_bears_relation(anchor: str, relation: str) -> None:
    model = build_model(anchor)
    if relation == "ontop":
        assert any(min(s.x1 - s.x0, s.y1 - s.y0) > 0.09 and s.clearance_m > 0.2 for s in model.surfaces), model.surfaces
    elif relation == "inside":
        sides = [sorted((c.box[3] - c.box[0], c.box[4] - c.box[1], c.box[5] - c.box[2])) for c in model.compartments]
        assert any(low > 0.06 and middle > 0.09 for low, middle, _ in sides), sides
    elif relation == "under":
        assert any(u[3] - u[0] > 0.09 and u[4] - u[1] > 0.09 and u[5] - u[2] > 0.1 for u in model.under), model.under
        assert all(u[2] == 0.0 for u in model.under)
    else:
        assert model.parts


def test_hanging_things_have_their_space_below() -> None:
    """Free spaces below end at z = 0 or at the floor of the room, which is below a hanging object's bottom."""
    for row in catalogue():
        for u in build_model(row.name).under:
            assert u[2] in (0.0, -row.bottom_z_m)
