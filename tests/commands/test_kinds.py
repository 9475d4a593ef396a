"""Values of every kind for every option of ``configs/``: accepted if of the right kind, else refused by name."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Literal

import pytest

from tests.commands.stored import composed, each, stored
from ucon.configuration.arguments import arguments_of, check_arguments
from ucon.configuration.kinds import ANYTHING, NOTHING, SWITCH, TEXT, kind_of, one_of, whole
from ucon.configuration.known_options import EVALUATION, TRAINING, check_options
from ucon.configuration.wiring import Factory
from ucon.core.errors import UconError

Mode = Literal["a", "b"]
NAMES = {"Mode": Mode, "Path": Path}
TEXTS = [
    "",
    "x",
    "no",
    "off",
    "true",
    "1",
    "a" * 255,
    "a" * 300,
    "a\0b",
    "a\nb",
    "/".join(["a" * 200] * 30),
    "..",
    "é" * 200,
]
NUMBERS = [0, 1, -1, 2**62, 2**63, -(2**63), 10**400, 0.0, 1.5, -0.5, 1e300, math.nan, math.inf, -math.inf]
OTHERS: list[Any] = [True, False, None, [], ["x"], [1.0], [[]], {}, {"a": 1.0}, {"_target_": "os.system"}, {1: 2}]
VALUES: list[Any] = [*TEXTS, *NUMBERS, *OTHERS]
USABLE_TEXTS = ["", "x", "no", "off", "true", "1", "a" * 255, ".."]


def taken(annotation: Any) -> list[Any]:
    kind = kind_of(annotation, NAMES)
    assert kind is not None
    return [value for value in VALUES if kind.takes(value)]


def same(found: list[Any], expected: list[Any]) -> bool:
    return [repr(value) for value in found] == [repr(value) for value in expected]


@pytest.mark.parametrize(
    ("annotation", "expected"),
    [
        ("bool", [True, False]),
        ("int", [0, 1, -1, 2**62]),
        ("float", [0, 1, -1, 2**62, 0.0, 1.5, -0.5, 1e300]),
        ("str", USABLE_TEXTS),
        ("str | Path", USABLE_TEXTS),
        ("None", [None]),
        ("bool | None", [True, False, None]),
        ("'bool'", [True, False]),
        ("Optional[bool]", [True, False, None]),
        ("Mode | None", [None]),
        ("Literal['no', 1]", ["no", 1]),
        ("Sequence[float]", [[], [1.0]]),
        ("list[str]", [[], ["x"]]),
        ("tuple[float]", [[1.0]]),
        ("tuple[float, ...]", [[], [1.0]]),
        ("tuple[float, float]", []),
        ("Sequence[Sequence[str]]", [[], [[]]]),
        ("Mapping[str, float]", [{}, {"a": 1.0}]),
        ("Mapping[str, float] | None", [None, {}, {"a": 1.0}]),
        ("HabitDataset", [{"_target_": "os.system"}]),
        ("Callable[[], Any] | None", [None, {"_target_": "os.system"}]),
        ("collections.abc.Sequence[str]", [[], ["x"]]),
        (bool, [True, False]),
        (bool | None, [True, False, None]),
        (Mode, []),
        (Path, USABLE_TEXTS),
        (Factory, [{"_target_": "os.system"}]),
    ],
)
def test_what_a_kind_takes(annotation: Any, expected: list[Any]) -> None:
    assert same(taken(annotation), expected)


@pytest.mark.parametrize("annotation", ["int |", "1 + 1", "Sequence[1]"])
def test_what_nobody_can_tell(annotation: str) -> None:
    assert kind_of(annotation, {}) is None


def test_bounds_and_names() -> None:
    assert [value for value in (-1, 0, 3, 4) if whole(0, 3).takes(value)] == [0, 3]
    assert whole(0, 3).expected == "a whole number from 0 to 3"
    assert whole(1).expected == "a whole number from 1 up"
    assert not one_of(1).takes(True)
    assert one_of("auto").takes("auto")


def refusal(do: Callable[..., Any], *arguments: Any) -> str | None:
    """The message to the user if something is refused, else None; any other exception is a bug."""
    try:
        do(*arguments)
    except UconError as error:
        return str(error)
    return None


def leaves(node: Any, place: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Values that are not mappings, with their places."""
    if isinstance(node, dict) and node:
        for name, inner in node.items():
            yield from leaves(inner, (*place, name))
    elif not place[-1].startswith("_"):  # names with _ are Hydra's own
        yield place, node


def alike(value: Any, other: Any) -> bool:
    """Whether ``other`` may replace ``value``, judged by its type and not by the annotation."""
    if value is None or other is None:
        return True  # an option that is null in a file may have a value, and vice versa
    if isinstance(value, bool) or isinstance(other, bool):
        return type(value) is type(other)
    if isinstance(value, float):
        return (type(other) in (int, float) and abs(other) < 2**63) or (type(other) is float and math.isfinite(other))
    if isinstance(value, int):
        return (type(other) is int and abs(other) < 2**63) or other == "auto"
    if isinstance(value, str):
        return other in USABLE_TEXTS or (value == "auto" and type(other) is int)
    return type(value) is type(other)


def replaced(config: dict[str, Any], place: tuple[str, ...], value: Any) -> dict[str, Any]:
    """The configuration with another value at a place; only the mappings on the path to it are copied."""
    if not place:
        return value
    return config | {place[0]: replaced(config[place[0]], place[1:], value)}


def check(root: str, config: dict[str, Any]) -> None:
    """Check a configuration as a run does before it builds anything."""
    check_options(config, EVALUATION if root == "eval" else TRAINING)
    for part in BUILT[root]:
        if config.get(part) is not None or part not in ("memory", "runner"):  # older runs have neither
            check_arguments(config[part])


@pytest.mark.parametrize("root", ["eval", "train"])
def test_every_option_of_every_file_is_of_a_kind(root: str) -> None:
    """Goes through all files: any replacement for a value is refused in one line, or is of the same type."""
    seen: set[str] = set()
    for name, config in stored().items():
        if ("learner" in config) != (root == "train"):
            continue
        check(root, config)
        for place, value in leaves(config):
            option = "->".join((str(_owner(config, place)), place[-1]))
            if option in seen or (len(place) > 1 and place[0] in {*PARTS, *sum(BUILT.values(), ())} - set(BUILT[root])):
                continue  # a part is checked only where it is built
            seen.add(option)
            for other in VALUES:
                if alike(value, other):
                    continue
                told = refusal(check, root, replaced(config, place, other))
                assert told is not None, f"{name}: {'.'.join(place)}={other!r} in place of {value!r} is taken"
                assert "\n" not in told
    assert len(seen) > 50


#: Groups that are built at once.
BUILT = {"eval": ("agent", "env", "memory", "runner"), "train": ("learner", "runner")}
#: Top-level groups that are built where they are used.
PARTS = ("collector", "detector", "habits", "language", "retriever", "search")


def _owner(config: Any, place: tuple[str, ...]) -> str:
    """The constructor that gets the argument at a place; the group's name if there is none."""
    owner = place[0]
    for name in place[:-1]:
        config = config[name]
        owner = config.get("_target_", owner)
    return owner


def test_every_argument_of_configs_has_a_kind() -> None:
    for target, (place, node) in each().items():
        known = arguments_of(target)
        for name in node:
            if not name.startswith("_") and not (target.endswith("Factory") and name == "config"):
                assert name in known, f"{target}.{name} ({'.'.join(place)}) has no annotation that a kind is known of"
                assert known[name][0] is not ANYTHING, f"{target}.{name}: Any"


HEAVY = ("Learner",)
"""Constructors that take seconds."""
BUILDABLE: list[Any] = [-1, 0, -0.5, 2**62, 1e300, -1e300, "", "x", "..", "/dev/null", [], ["x"], [1.0], {}, {"a": 1.0}]


@pytest.mark.slow
def test_what_is_of_the_right_kind_is_built_or_refused_in_a_line() -> None:
    _build_each(lambda target: not target.endswith(HEAVY))


@pytest.mark.slow
def test_learners_too() -> None:
    _build_each(lambda target: target.endswith(HEAVY))


def _build_each(wanted: Any) -> None:
    for target, (_, node) in each().items():
        if not wanted(target):
            continue
        for name, (kind, _) in arguments_of(target).items():
            if isinstance(node.get(name), dict):
                continue
            for value in (*BUILDABLE, None, True, False):
                if kind.takes(value):
                    told = refusal(Factory(copy.deepcopy(node) | {name: value})) or ""
                    listed = "faults, the first" in told.partition("\n")[0]  # all faults of a folder, one per line
                    assert listed or "\n" not in told, (target, name, value)


def test_what_says_nothing_of_itself_is_as_it_was() -> None:
    config = composed("eval")
    del config["every"]
    check_options(config, EVALUATION)  # older runs have fewer options
    assert NOTHING.takes(None)
    assert SWITCH.takes(False)
    assert not TEXT.takes(None)
