"""The second hop, by arithmetic."""

import pytest

from ucon.retrieval.compose import compose

BELIEFS = {
    "tray": {"table": 0.5, "shelf": 0.5},
    "book": {"cup": 0.8, "desk": 0.2},
    "cup": {"book": 0.6, "sink": 0.4},
    "void": {},
}


def ask(names):
    return [BELIEFS[name] for name in names]


def test_mass_goes_on_to_where_the_anchor_is():
    found = compose("tea", {"tray": 0.6, "table": 0.1, "fridge": 0.3}, {"tray"}, ask)
    assert found == pytest.approx({"table": 0.4, "shelf": 0.3, "fridge": 0.3})


def test_cycles_end():
    found = compose("pen", {"book": 1.0}, BELIEFS, ask)
    assert found == pytest.approx({"desk": 0.2, "sink": 0.8})
    assert sum(found.values()) == pytest.approx(1)


def test_the_target_is_never_followed():
    assert compose("cup", {"book": 1.0}, BELIEFS, ask) == pytest.approx({"desk": 1.0})


def test_depth_ends_it():
    chain = {f"a{i}": {f"a{i + 1}": 1.0} for i in range(9)}
    beliefs = lambda names: [chain[name] for name in names]  # noqa: E731
    assert compose("t", {"a0": 1.0}, chain, beliefs) == {"a3": 1.0}
    assert compose("t", {"a0": 1.0}, chain, beliefs, depth=0) == {"a0": 1.0}


def test_what_nobody_can_tell_stays():
    assert compose("t", {"void": 1.0}, BELIEFS, ask) == {"void": 1.0}


def test_asked_once_a_hop_and_not_for_crumbs():
    asked = []

    def beliefs(names):
        asked.append(list(names))
        return ask(names)

    compose("t", {"tray": 0.5, "book": 0.49, "cup": 0.001}, BELIEFS, beliefs)
    assert asked == [["tray", "book"], ["cup"]]


def test_where_a_thing_cannot_be_is_not_named():
    """A place of probability 0 is none: it gets no mass, and is not listed with 0 either."""
    beliefs = lambda names: [{"table": 0.4, "shelf": 0.0, "desk": 0.1}]  # noqa: E731
    found = compose("tea", {"tray": 1.0}, {"tray"}, beliefs)
    assert found == pytest.approx({"table": 0.8, "desk": 0.2})
    nowhere = lambda names: [{"shelf": 0.0}]  # noqa: E731
    assert compose("tea", {"tray": 1.0}, {"tray"}, nowhere) == {"tray": 1.0}


def test_the_least_mass_is_still_asked_for():
    """``least`` itself is enough, anything below is not."""
    asked = []

    def beliefs(names):
        asked.append(list(names))
        return [{"table": 1.0} for _ in names]

    compose("tea", {"tray": 0.25, "book": 0.2499}, {"tray", "book"}, beliefs, least=0.25)
    assert asked == [["tray"]]
