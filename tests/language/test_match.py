"""A text names one option, or none."""

import pytest

from ucon.language.match import chosen, named

NAMES = ("sofa", "sofa bed", "desk", "mug rack")


@pytest.mark.parametrize(
    ("text", "number"),
    [
        ("sofa", 0),
        ("sofa bed", 1),
        (" Sofa-Bed! ", 1),
        ("SOFA.", 0),
        ("mug_rack", 3),
        ("the sofa bed, of course", 1),
        ("the sofa, of course", 0),
        ("bed", 1),
        ("rack", 3),
        ("sofa bed, not the sofa", -1),
        ("desk and sofa", -1),
        ("bathroom", -1),
        ("", -1),
        ("!?", -1),
        ("sofabed", -1),
        ("desktop", -1),
        ("desk " * 1000, -1),
    ],
)
def test_names(text, number):
    assert named(text, NAMES) == number


def test_numbers_keep_their_sign():
    turns = ("-90", "90", "180", "0")
    assert [named(text, turns) for text in ("-90", "90", "turn by -90 degrees", "90°", "+180", "9")] == [
        0,
        1,
        0,
        1,
        -1,
        -1,
    ]


def test_what_is_written_alike_is_a_tie():
    assert named("a", ("a", "a")) == -1
    assert named("mug rack", ("mug-rack", "mug_rack")) == -1
    assert named("mug_rack", ("mug-rack", "mug_rack")) == 1
    assert named("?", ("?", "!")) == 0
    assert named("...", ("?", "!")) == -1


@pytest.mark.parametrize(
    ("text", "number"),
    [
        ('{"choice": "desk"}', 2),
        ('{"reason": "not the sofa", "choice": "Desk."}', 2),
        ('Well:\n```json\n{"choice": "sofa bed"}\n```', 1),
        ("<think>the sofa?</think>desk", 2),
        ('{"choice": null}', -1),
        ('{"answer": "desk"}', -1),
        ('{"choice": {"a": "desk"}}', -1),
        ('{"choice": "de', -1),
        ('{"choice": "sofa', -1),
    ],
)
def test_answers(text, number):
    assert chosen(text, NAMES) == number
