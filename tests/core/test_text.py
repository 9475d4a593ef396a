"""Which texts can be shown: joined emoji and other scripts can, control and text-direction characters cannot."""

import pytest

from ucon.core.errors import brief
from ucon.core.text import is_shown, shown
from ucon.habits.release import plain
from ucon.habits.rules import line_fault
from ucon.language.prompt import neutral

SHOWN = {
    "cook": "She \U0001f469\u200d\U0001f373 keeps it by the stove.",
    "family": "\U0001f468\u200d\U0001f469\u200d\U0001f467\u200d\U0001f466 share it",
    "heart on fire": "a mug \u2764\ufe0f\u200d\U0001f525",
    "skin tone": "\U0001f9d1\U0001f3fd\u200d\U0001f680 has one",
    "woman running": "\U0001f3c3\u200d\u2640\ufe0f leaves it by the door",
    "nodding": "\U0001f642\u200d\u2195\ufe0f",
    "pirate flag": "\U0001f3f4\u200d\u2620\ufe0f",
    "flag of Wales": "\U0001f3f4\U000e0067\U000e0062\U000e0077\U000e006c\U000e0073\U000e007f mug",
    "keycap": "drawer 3\ufe0f\u20e3",
    "younger than this Python": "a face \U0001fae9 too",
    "Persian": "\u0645\u06cc\u200c\u062e\u0648\u0627\u0647\u0645",
    "Hindi": "\u0915\u094d\u200d\u0937",
    "plain": "Naïve Zoë, 家, عربي",
}
HIDDEN = {
    "bell": "a\x07b",
    "NUL": "a\x00b",
    "escape": "\x1b[31mred",
    "line break": "a\nb",
    "line separator": "a\u2028b",
    "right to left override": "a\u202eb",
    "isolate": "a\u2066b\u2069",
    "mark of direction": "a\u200fb",
    "byte-order mark": "a\ufeffb",
    "zero width space": "a\u200bb",
    "joiner in a word": "c\u200dup",
    "non-joiner in a word": "c\u200cup",
    "joiner at the end": "\U0001f469\u200d",
    "joiner at the start": "\u200d\U0001f469",
    "two joiners": "\U0001f469\u200d\u200d\U0001f373",
    "tags without a flag": "mug\U000e0067\U000e0062\U000e007f",
    "half a character": "a\ud83d",
    "private": "a\ue000",
}


@pytest.mark.parametrize("text", SHOWN.values(), ids=SHOWN)
def test_what_can_be_shown_is_taken_as_it_is(text: str) -> None:
    assert is_shown(text)
    assert shown(text) == text == plain(text) == brief(text)
    assert line_fault(text) is None
    assert neutral(text) == text


@pytest.mark.parametrize("text", HIDDEN.values(), ids=HIDDEN)
def test_what_cannot_is_refused(text: str) -> None:
    assert not is_shown(text)
    assert is_shown(shown(text))
    assert len(shown(text)) == len(text)
    assert "control character" in str(line_fault(text))
    assert brief(text).isprintable()
