"""Values of the wrong kind are refused, and the argument named, before anything is built."""

import pytest

from ucon.configuration.arguments import check_arguments
from ucon.core.errors import ConfigError


class Made:
    def __init__(self, n: "int", share: "float | None" = 0.5, on: "bool" = True, name: "str" = None):  # noqa: RUF013
        pass


MADE = f"{__name__}.Made"


@pytest.mark.parametrize(
    "arguments",
    [
        {"n": 1},
        {"n": 1, "share": None},
        {"n": 1, "share": 2},
        {"n": 1, "name": None},
        {"n": 1, "unknown": "is left"},
    ],
)
def test_what_it_takes(arguments):
    check_arguments({"_target_": MADE, **arguments})


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"n": "x"}, r"Made\.n=x: expected a whole number"),
        ({"n": 1.5}, "expected a whole number"),
        ({"n": True}, "expected a whole number"),
        ({"n": None}, "expected a whole number"),
        ({"n": 1, "share": "x"}, "expected a number or null"),
        ({"n": 1, "share": float("nan")}, "expected a number or null"),
        ({"n": 1, "on": 1}, "expected true or false"),
        ({"n": 1, "name": 3}, "expected a text"),
    ],
)
def test_what_it_does_not_take(arguments, message):
    node = {"_target_": MADE, **arguments}
    for config in (node, {"_target_": "builtins.dict", "deep": [{"in": node}]}):
        with pytest.raises(ConfigError, match=message):
            check_arguments(config)


def test_what_does_not_exist_is_left_to_who_builds_it():
    check_arguments({"_target_": "no.such.Thing", "n": "x"})
    check_arguments({"_target_": "builtins.print", "n": "x"})
