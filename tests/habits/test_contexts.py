import pytest

from ucon.core.errors import DataError
from ucon.core.rng import stream
from ucon.habits import book
from ucon.habits.contexts import SEASONS, Context, condition_of, context_table, draw_context, read_contexts

SUMMER_EVENING = Context(day=5, hour=19, season="summer", occasion=None, asker="a family")


def table(tmp_path, text):
    path = tmp_path / "contexts.txt"
    path.write_text(text)
    return read_contexts(path)


def test_every_context_of_the_book_is_in_the_table_and_no_other():
    used = {p.context for entry in book().entries for p in entry.placements if p.context}
    assert used == set(context_table())
    kinds = {kind for text in used for kind in condition_of(text).kinds}
    assert kinds == {"day", "time", "season", "event", "other"}


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
        ("a = weather rain\n", r":1: condition 'weather rain', expected day, time, season, event or other"),
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
    expected = "It is Saturday, about 19 o'clock, in summer. Occasion: family visit. Asking: a family of four."
    assert told == expected
