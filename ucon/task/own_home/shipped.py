"""Shipped homes by name: the three of the real-robot setting, and two cases in them.

The paper tested in three real environments, two of them homes of 30 and 90 m2, with habits written by hand, and shows
two searches: for the book at the foot of the bed, and for the newspaper behind the laptop. Its homes and sentences are
not public; these are different ones of the same sizes.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Final

_DATA: Final = Path(__file__).parent / "data"


@dataclass(frozen=True)
class Case:
    """One search of a shipped home.

    Attributes:
        home: name of the home.
        target: category to be found.
        day: seed of the episode.
        expected: what a robot that reads the habit does, in words.
    """

    home: str
    target: str
    day: int
    expected: str


#: The file of each home, by name.
HOMES: Final = {name: _DATA / f"{name}.yaml" for name in ("robot_flat", "robot_house", "robot_office")}
#: Cases by name; their days were chosen so that they show the expected behaviour.
CASES: Final = {
    "case_book": Case(
        "robot_house",
        "paperback_book",
        1,
        "goes to the bed and looks at its foot, although books are usually on the shelf",
    ),
    "case_newspaper": Case(
        "robot_house",
        "newspaper",
        0,
        "goes through the hall into the study and round the desk, since the screen hides what lies behind it",
    ),
}


def is_shipped(name: object) -> bool:
    """Whether a name is that of a shipped home or case."""
    return str(name) in HOMES or str(name) in CASES


def home_path(name: str | Path) -> Path:
    """The file of a home.

    Args:
        name: name of a shipped home or case, or a file.
    """
    home = CASES[str(name)].home if str(name) in CASES else str(name)
    return HOMES.get(home) or Path(name).expanduser()
