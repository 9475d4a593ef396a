import pickle
from dataclasses import replace

import pytest

from ucon.core.errors import ConfigError, DataError
from ucon.core.rng import stream
from ucon.habits import book, category_split, contexts_book
from ucon.habits.book import CONTEXTS_FILE, CONTEXTS_FOLDER, read_book
from ucon.habits.contexts import SEASONS, Context, condition_of, context_table, draw_context, read_contexts
from ucon.habits.datafile import load_dataset_file
from ucon.habits.splits import entry_parts
from ucon.task.making.living import contradictory

SUMMER_EVENING = Context(day=5, hour=19, season="summer", occasion=None, asker="a family")


def table(tmp_path, text):
    path = tmp_path / "contexts.txt"
    path.write_text(text)
    return read_contexts(path)


def test_every_context_of_the_book_and_its_second_part_is_in_the_table_and_no_other():
    entries = (*book().entries, *contexts_book().entries)
    used = {p.context for entry in entries for p in entry.placements if p.context}
    assert used == set(context_table())
    kinds = {kind for text in used for kind in condition_of(text).kinds}
    assert kinds == {"day", "time", "season", "user", "event", "other"}


@pytest.mark.parametrize(
    ("line", "changes", "holds"),
    [
        ("season summer; time 18-22", {}, True),
        ("season summer; time 18-22", {"hour": 22}, False),
        ("season winter,autumn", {}, False),
        ("time 22-6", {"hour": 23}, True),
        ("time 22-6", {"hour": 5}, True),
        ("time 22-6", {"hour": 6}, False),
        ("day workday", {}, False),
        ("day weekend", {}, True),
        ("day mon,sat", {}, True),
        ("user Ines", {}, False),
        ("user Ines", {"user": "Ines"}, True),
        ("user Ines; season winter", {"user": "Ines"}, False),
        ("event guests/visit", {}, False),
        ("event guests/visit", {"occasion": "guests/visit"}, True),
        ("other half-empty", {"occasion": "other/half-empty"}, True),
    ],
)
def test_conditions(tmp_path, line, changes, holds):
    condition = table(tmp_path, f"# a comment\nsome time = {line}\n")["some time"]
    stated = Context(**{**{name: getattr(SUMMER_EVENING, name) for name in Context.__slots__}, **changes})
    assert condition.holds(stated) is holds


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("winter season winter\n", r"contexts\.txt:1: .*expected 'context = condition"),
        ("a = season winter\na = day mon\n", r":2: context 'a' is listed twice"),
        ("a = season wnter\n", r":1: 'season wnter' is no season"),
        ("a = time 25-3\n", r":1: 'time 25-3' is no time"),
        ("a = day someday\n", r":1: 'day someday' is no day"),
        ("a = event parties\n", r":1: 'event parties' is no event"),
        ("a = weather rain\n", r":1: condition 'weather rain', expected day, time, season, event, user or other"),
        ("a = user\n", r":1: 'user' is no user"),
        ("a = day mon; day tue\n", r":1: two conditions of one kind"),
    ],
)
def test_mistakes_name_file_and_line(tmp_path, text, message):
    with pytest.raises(DataError, match=message):
        table(tmp_path, text)


def test_a_context_that_the_table_lacks_holds_only_where_it_is_stated():
    condition = condition_of("When the comet passes!")
    assert condition.kinds == ("other",)
    assert not condition.holds(SUMMER_EVENING)
    stated = Context(0, 8, "spring", "other/when-the-comet-passes", "a family")
    assert condition.holds(stated)


def test_drawn_contexts_are_seeded_and_feasts_fall_into_their_season():
    drawn = [draw_context(stream(0, i), ["feast/christmas", "guests/visit"], "a family") for i in range(200)]
    assert drawn == [draw_context(stream(0, i), ["guests/visit", "feast/christmas"], "a family") for i in range(200)]
    assert {c.season for c in drawn if c.occasion == "feast/christmas"} == {"winter"}
    assert {c.season for c in drawn} == set(SEASONS)
    assert 60 < sum(c.occasion is None for c in drawn) < 140
    assert all(Context.from_json(c.to_json()) == c for c in drawn)


def test_a_context_reads_like_a_sentence():
    told = Context(5, 19, "summer", "guests/family-visit", "a family of four").sentence()
    expected = (
        "It is Saturday evening, about 19 o'clock, in summer, on the occasion 'family visit' (guests), and this is "
        "asked by a family of four."
    )
    assert told == expected
    assert replace(SUMMER_EVENING, asker="two sisters", user="Ines").sentence().endswith("by Ines (two sisters).")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"day": 7}, "context: day 7, expected 0 to 6"),
        ({"hour": 25}, "context: hour 25, expected 0 to 23"),
        ({"hour": 19.0}, "context: hour 19.0, expected 0 to 23"),
        ({"hour": True}, "context: hour True, expected 0 to 23"),
        ({"season": "smarch"}, "context: unknown season 'smarch': expected one of .*"),
        ({"occasion": "parties/loud"}, "context: occasion 'parties/loud', expected GROUP/NAME of guests, .*"),
        ({"occasion": ""}, "context: occasion '', expected a text"),
        ({"asker": ""}, "context: asker '', expected a text"),
        ({"user": "I\nnes"}, r"context: user 'I\\nnes', expected a text"),
    ],
)
def test_what_is_on_no_calendar_is_refused_in_one_line(change, message):
    with pytest.raises(ConfigError, match=message) as found:
        replace(SUMMER_EVENING, **change)
    assert "\n" not in str(found.value)
    data = SUMMER_EVENING.to_json() | {name: value for name, value in change.items() if name != "day"}
    with pytest.raises(ValueError, match=message if "day" not in change else "unknown day"):
        Context.from_json(data | ({"day": "someday"} if "day" in change else {}))


@pytest.mark.parametrize(
    ("one", "other", "excluded"),
    [
        ("weekdays", "weekends", True),
        ("weekdays", "Fridays", False),
        ("winter", "summer", True),
        ("mornings", "nights", True),
        ("evenings", "winter evenings", False),
        ("guests", "parties", True),
        ("for Ines", "for Marta", True),
        ("for Ines", "winter", False),
    ],
)
def test_conditions_exclude_each_other(one, other, excluded):
    assert condition_of(one).excludes(condition_of(other)) is excluded
    assert condition_of(other).excludes(condition_of(one)) is excluded


def test_the_second_part_contradicts_itself_and_leaves_the_book_as_it_is():
    whole, first = contexts_book(), book()
    added = [entry for entry in whole.entries if entry.id in whole.parts]
    assert len(added) == 95
    assert sum(map(contradictory, added)) == 90
    kept = [entry for entry in whole.entries if entry.id not in whole.parts]
    assert kept == [entry for entry in first.entries if entry.category not in {e.category for e in added}]
    assert not {e.id for e in added} & {e.id for e in first.entries}
    texts = [habit.text for entry in added for habit in entry.habits]
    assert len(set(texts)) == len(texts)
    assert not set(texts) & set(first.texts)
    parts, before = entry_parts(whole), entry_parts(first)
    assert {parts[entry.id] for entry in added} == {"val", "test"}
    assert all(parts[entry.id] == before[entry.id] for entry in kept)
    assert all(category_split(e.category) != "val" or parts[e.id] == "val" for e in added)
    assert pickle.loads(pickle.dumps(whole)) is whole


def test_the_shipped_file_is_the_text_of_the_second_part():
    text = read_book(CONTEXTS_FOLDER)
    assert load_dataset_file(CONTEXTS_FILE, verified=True).sha256 == text.sha256
