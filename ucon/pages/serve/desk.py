"""What the pages of one server share: where they write, and which habits and runs they show."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from ucon.core.errors import ConfigError, brief
from ucon.habits import HabitDataset

_NAME: Final = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,39}")


@dataclass(frozen=True)
class Desk:
    """Folders and habits of a server."""

    out: Path
    """Folder for what is played and answered."""
    folders: tuple[Path, ...]
    """Where runs are looked for."""
    dataset: HabitDataset
    """The habits of the pages Habits, Homes and Study; episodes are played with their own habits."""
    homes: Mapping[str, Path] = field(default_factory=dict)
    """Home files whose searches can be played, by the names of their sets."""


def is_name(value: object) -> bool:
    """Whether something can be a name that becomes part of a path.

    Args:
        value: as it was given.
    """
    return isinstance(value, str) and _NAME.fullmatch(value) is not None


def checked_name(value: object, what: str) -> str:
    """Check a name that becomes part of a path.

    Args:
        value: as it was given.
        what: what the name is of, for the error.

    Raises:
        ConfigError: anything but letters, digits, hyphens and underscores.
    """
    if not isinstance(value, str) or not is_name(value):
        raise ConfigError(
            f"{what} '{brief(value)}': expected 1 to 40 of the letters a to z, digits, - and _, such as initials"
        )
    return value
