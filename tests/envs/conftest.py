"""A few stored episodes for tests of environments."""

from __future__ import annotations

import pytest

from ucon.task.episode import Episode
from ucon.task.sets import load_episodes


@pytest.fixture(scope="session")
def episodes() -> tuple[Episode, ...]:
    """Every fifth episode of the mini set: both kinds of homes, targets in the open and in containers."""
    return load_episodes("mini")[::5]
