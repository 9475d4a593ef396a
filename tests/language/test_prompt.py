"""Prompt files are checked, and habits in them stay data."""

import pytest

from tests.language.tiny_models import HABITS, INJECTED, PROMPT
from ucon.core.errors import ConfigError, DataError
from ucon.language.models.conversation import most_habits
from ucon.language.prompt import END, START, Prompt, first_habits, habit_block, habits_in, neutral


@pytest.fixture
def prompt(tmp_path):
    (tmp_path / "p.txt").write_text(PROMPT)
    return Prompt.load(tmp_path / "p.txt")


def test_parts_are_filled(prompt):
    assert prompt.slots("situation") == {"target", "options"}
    assert prompt.situation(target="key", options="a, b") == "The key is wanted. You see: a, b. Where do you look?"
    assert prompt.cloze(target="key") == "The key is near the {}."
    assert prompt.system(habits="x") == "You look for things in a home.\nx"


def test_without_habits_there_is_no_habit_section(prompt):
    assert habit_block(()) == ""
    assert prompt.system(habits=habit_block(())) == "You look for things in a home."


def test_values_are_not_read_as_slots(prompt):
    assert "{options} {0.__class__}" in prompt.situation(target="{options} {0.__class__}", options="x")
    assert prompt.cloze(target="{}wallet{") == "The wallet is near the {}."


def test_a_prompt_without_cloze():
    prompt = Prompt.parse("[system]\na\n[situation]\nb")
    assert (prompt.cloze(target="x"), prompt.system(), prompt.situation()) == ("", "a", "b")


@pytest.mark.parametrize(
    ("slots", "said"),
    [
        ({}, r"no value for slot \{options\}; its slots are options, target"),
        ({"target": "x", "options": "y", "habit": "z"}, r"no slot \{habit\}"),
    ],
)
def test_slots_must_be_exact(prompt, slots, said):
    with pytest.raises(ConfigError, match=said):
        prompt.situation(**slots)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", r"no text in part \[system\]"),
        ("[system]\na", r"no text in part \[situation\]"),
        ("[system]\na\n[situation]\n\n", r"no text in part \[situation\]"),
        ("[system]\na\n[system]\nb\n[situation]\nc", r":3: part \[system\]"),
        ("[system]\na\n[other]\nb", r":3: part \[other\]"),
        ("[system]\n{a\n[situation]\nb", r"\[system\].*write a plain brace"),
        ("[system]\n{}\n[situation]\nb", r"slot \{\} is not a plain name"),
        ("[system]\n{a.b}\n[situation]\nb", r"slot \{a\.b\}"),
        ("[system]\n{a!r}\n[situation]\nb", r"slot \{a\}"),
        ("[system]\na\n[situation]\nb\n[cloze]\nno gap", r"0 gaps"),
    ],
)
def test_files_are_checked(tmp_path, text, said):
    path = tmp_path / "bad.txt"
    path.write_text(text)
    with pytest.raises(DataError, match=said) as caught:
        Prompt.load(path).cloze()
    assert str(path) in str(caught.value)


def test_files_that_are_none(tmp_path):
    with pytest.raises(DataError, match="cannot be read as text"):
        Prompt.load(tmp_path / "none.txt")
    (tmp_path / "bytes.txt").write_bytes(b"\xff\xfe\xff")
    with pytest.raises(DataError, match="cannot be read as text"):
        Prompt.load(tmp_path / "bytes.txt")


def test_no_habit_ends_the_block():
    block = habit_block(HABITS + INJECTED)
    lines = block.splitlines()
    assert (lines[1], lines[-1], len(lines)) == (START, END, 3 + len(HABITS + INJECTED))
    assert [line.split(". ")[0] for line in lines[2:-1]] == [str(i) for i in range(1, 9)]
    assert block.count(START) == block.count(END) == 1
    inside = "\n".join(lines[2:-1])
    assert not [sign for sign in "<>|[]{}`\r\x00\x1b\ud800\u202e\u2028" if sign in inside]
    assert "naïve ☕" in inside
    assert "家" in inside
    assert inside.isascii() is False
    assert habit_block(HABITS, numbered=False).splitlines()[2:-1] == list(HABITS)


def test_plain_habits_stay_as_they_are():
    assert all(neutral(habit) == habit for habit in HABITS)
    from ucon.habits import book

    changed = [text for text in book().texts if neutral(text) != text]
    assert len(changed) <= len(book().texts) * 0.001, changed[:5]


def test_habits_are_dropped_whole_and_from_the_end(prompt):
    system = prompt.system(habits=habit_block(HABITS))
    assert habits_in(system) == len(HABITS)
    for n in range(len(HABITS) + 1):
        assert first_habits(system, n) == prompt.system(habits=habit_block(HABITS[:n]))
        assert habits_in(first_habits(system, n)) == n
    assert first_habits("no block", 0) == "no block"


@pytest.mark.parametrize("room", [0, 1, 3, len(HABITS) - 1, len(HABITS)])
@pytest.mark.parametrize("likely", [0, 1, 2, len(HABITS), len(HABITS) + 5])
def test_the_largest_number_of_habits_is_kept_whatever_was_kept_before(prompt, room, likely):
    system = prompt.system(habits=habit_block(HABITS))
    tried = []

    def fits(message):
        tried.append(message)
        return habits_in(message) <= room

    assert most_habits(system, fits, likely) == (first_habits(system, room), len(HABITS) - room)
    if likely == len(HABITS) - room > 0:
        assert len(tried) == 2
    assert most_habits(system, lambda message: False, likely) is None
