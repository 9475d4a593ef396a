"""Datasets in other languages get a warning; the shipped book, names, foreign words and emoji do not."""

import pytest

from ucon.habits import book
from ucon.language.english import foreign_share, is_english, language_warning

FOREIGN = {
    "German": (
        "Die Tasse steht nach dem Frühstück immer auf der Anrichte in der Küche.",
        "Er legt die Schlüssel am Abend in die Schale neben der Tür.",
        "Im Winter hängt der Schal am Haken im Flur, damit sie ihn nicht sucht.",
    ),
    "French": (
        "Il pose sa tasse sur la table du salon après le petit déjeuner.",
        "On me dit que le livre est sur la chaise à côté du lit.",
        "Elle range les clés dans le tiroir de la commode chaque soir.",
    ),
    "Chinese": ("她每天早上把咖啡杯放在厨房的桌子上。", "他晚上回家以后把钥匙放进门边的碗里。"),
    "Japanese": ("彼女は毎朝コーヒーカップを台所のテーブルに置きます。", "鍵はいつも玄関の棚の上にあります。"),
    "Arabic": ("تضع كوب القهوة على الطاولة في المطبخ كل صباح.", "يترك المفاتيح في الوعاء بجانب الباب عندما يعود."),
}
ENGLISH = (
    "Keeps it by the door.",
    "Grandma Żółć leaves it at the café window ☕️ \U0001f469\u200d\U0001f373.",
    "Naïve Zoë puts her crème brûlée torch in the drawer by the stove.",
    "\U0001f600\U0001f600",
    "",
)


@pytest.mark.parametrize("language", FOREIGN)
def test_other_languages_are_told_in_one_line(language: str) -> None:
    assert not any(map(is_english, FOREIGN[language]))
    warning = language_warning("mine", FOREIGN[language])
    assert warning is not None
    assert "100% of its sentences do not look English" in warning
    assert "\n" not in warning


def test_english_is_not() -> None:
    assert all(map(is_english, ENGLISH))
    assert language_warning("mine", ENGLISH) is None
    assert language_warning("mine", ()) is None
    mixed = (*ENGLISH[:3], *FOREIGN["German"][:2])
    assert language_warning("mine", mixed) is None


def test_the_book_is_english() -> None:
    texts = [habit.text for entry in book().entries for habit in entry.habits]
    assert foreign_share(texts) < 0.05
