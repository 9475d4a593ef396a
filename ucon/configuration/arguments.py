"""Checks that the values of a configuration have the types that the constructors expect.

Hydra passes any value to any constructor: ``lr=x`` would give a traceback from inside, or no error at all.
"""

from __future__ import annotations

import inspect
import sys
from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any, Final

from ucon.configuration.kinds import ANYTHING, Kind, is_part, kind_of, whole
from ucon.core.errors import ConfigError, brief

#: Arguments, by name, that are more restricted than their annotation: random generators take no negative seed.
_NARROWER: Final[Mapping[str, Kind]] = {"seed": whole(0)}


def check_arguments(config: Any) -> None:
    """Refuse values that the constructors named by ``_target_``, at any depth, do not take.

    Types are those of the annotations. Arguments without annotation, unknown arguments and unknown targets are left to
    the constructor.

    Args:
        config: a mapping with ``_target_``, as plain data.

    Raises:
        ConfigError: naming the constructor, its argument and what is expected.
    """
    if not is_part(config):
        raise ConfigError(f"{brief(config)}: expected a part with a _target_; see the files in configs/")
    for target, arguments in _parts_in(config):
        for name, (kind, default) in arguments_of(target).items():
            if name in arguments and arguments[name] is not default and not kind.takes(arguments[name]):
                owner = target.rsplit(".", 1)[-1]
                raise ConfigError(
                    f"{owner}.{name}={brief(arguments[name])}: expected {kind.expected}; see its file in configs/"
                )


@cache
def arguments_of(target: str) -> dict[str, tuple[Kind, Any]]:
    """Kinds and defaults of a constructor's annotated arguments, by name.

    Arguments passed on as ``**options`` are looked up in the class that ``options_of`` names, or in the base class.

    Args:
        target: dotted name, as in ``_target_``.

    Returns:
        Empty where the target cannot be imported; building it gives the error.
    """
    from hydra.utils import get_object

    try:
        found = get_object(target)
        made_by = [found]
        if inspect.isclass(found):
            made_by = list(_classes_with_arguments(found))
        out: dict[str, tuple[Kind, Any]] = {}
        for one in made_by:
            parameters = inspect.signature(one).parameters.values()
            for parameter in parameters:
                kind = kind_of(parameter.annotation, vars(sys.modules[one.__module__]))
                known = out.get(parameter.name, (ANYTHING,))[0] is not ANYTHING
                if kind is None or known or parameter.kind is parameter.VAR_KEYWORD:
                    continue  # the first class that annotates an argument decides
                out[parameter.name] = (_NARROWER.get(parameter.name, kind), parameter.default)
            passes_on = any(parameter.kind is parameter.VAR_KEYWORD for parameter in parameters)
            if not passes_on and (not inspect.isclass(found) or issubclass(found, one)):
                break  # an options class takes no further arguments, but its owner's bases do
    except Exception:  # not importable or not callable: building it gives the error
        return {}
    return out


def _classes_with_arguments(found: type) -> Iterator[type]:
    """Classes whose arguments a class takes: itself, its options class, then those of its bases."""
    for one in inspect.getmro(found):
        own = vars(one)
        if "__init__" in own:
            yield one
        if "options_of" in own:
            yield own["options_of"]


def _parts_in(node: Any) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """All mappings with a ``_target_``, at any depth: the target and the mapping."""
    if isinstance(node, Mapping):
        if isinstance(target := node.get("_target_"), str):
            yield target, {str(k): v for k, v in node.items()}
        for value in node.values():
            yield from _parts_in(value)
    elif isinstance(node, list | tuple):
        for value in node:
            yield from _parts_in(value)
