"""Are the values of a configuration of the kinds that what it builds was written for?

Hydra hands anything to anyone: ``lr=x`` would be a traceback from within, or worse, no error at all.
"""

from __future__ import annotations

import inspect
import sys
from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any, Final

from ucon.configuration.kinds import ANYTHING, Kind, is_part, kind_of, whole
from ucon.core.errors import ConfigError, brief

#: What is narrower than its annotation, by the name that it has everywhere: random generators take no negative seed.
_NARROWER: Final[Mapping[str, Kind]] = {"seed": whole(0)}


def check_arguments(config: Any) -> None:
    """Refuse values that the constructors named by ``_target_``, at any depth, do not take.

    Judged by annotations; an argument without one is left to the constructor. So is a target that does not exist, or
    an argument that it does not know.

    Raises:
        ConfigError: naming the constructor, its argument and what is expected.
    """
    if not is_part(config):
        raise ConfigError(f"{brief(config)}: expected a part with a _target_; see the files in configs/")
    for target, arguments in _described(config):
        for name, (kind, default) in arguments_of(target).items():
            if name in arguments and arguments[name] is not default and not kind.takes(arguments[name]):
                owner = target.rsplit(".", 1)[-1]
                raise ConfigError(
                    f"{owner}.{name}={brief(arguments[name])}: expected {kind.expected}; see its file in configs/"
                )


@cache
def arguments_of(target: str) -> dict[str, tuple[Kind, Any]]:
    """By name, the kinds and defaults of the arguments of a constructor that are annotated.

    A constructor with ``**options`` hands them on: to the class that its ``options_of`` names, or to its base.
    """
    from hydra.utils import get_object

    try:
        found = get_object(target)
        made_by = [found]
        if inspect.isclass(found):
            made_by = list(_handed_on(found))
        out: dict[str, tuple[Kind, Any]] = {}
        for one in made_by:
            parameters = inspect.signature(one).parameters.values()
            for parameter in parameters:
                kind = kind_of(parameter.annotation, vars(sys.modules[one.__module__]))
                known = out.get(parameter.name, (ANYTHING,))[0] is not ANYTHING
                if kind is None or known or parameter.kind is parameter.VAR_KEYWORD:
                    continue  # a base knows more only of what is passed on unseen
                out[parameter.name] = (_NARROWER.get(parameter.name, kind), parameter.default)
            if not any(parameter.kind is parameter.VAR_KEYWORD for parameter in parameters):
                break
    except Exception:  # not importable, or not to be called: building it says so
        return {}
    return out


def _handed_on(found: type) -> Iterator[type]:
    """Who takes the arguments of a class: it, whose options it takes, its bases, whose options they take."""
    for one in inspect.getmro(found):
        own = vars(one)
        if "__init__" in own:
            yield one
        if "options_of" in own:
            yield own["options_of"]


def _described(node: Any) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Everything with a ``_target_``."""
    if isinstance(node, Mapping):
        if isinstance(target := node.get("_target_"), str):
            yield target, {str(k): v for k, v in node.items()}
        for value in node.values():
            yield from _described(value)
    elif isinstance(node, list | tuple):
        for value in node:
            yield from _described(value)
