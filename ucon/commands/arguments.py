"""Are the numbers, texts and switches of a configuration of the kinds that what it builds was written for?

Hydra hands anything to anyone: ``lr=x`` would be a traceback from within, or worse, no error at all.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Iterator, Mapping
from typing import Any, Final

from ucon.core.errors import ConfigError, DataError, brief

#: By the annotation of an argument: types of values that it takes, and how they are called.
_KINDS: Final[Mapping[str, tuple[tuple[type, ...], str]]] = {
    "int": ((int,), "a whole number"),
    "float": ((int, float), "a number"),
    "bool": ((bool,), "true or false"),
    "str": ((str,), "a text"),
    "None": ((type(None),), "null"),
}

_OURS: Final = ("ucon.", "models.")


def check_arguments(config: Any) -> None:
    """Refuse values that the constructors named by ``_target_``, at any depth, do not take.

    Judged by annotations that consist of int, float, bool, str and None; others are left to the constructors. So is a
    target that does not exist, or an argument that it does not know.

    Raises:
        ConfigError: naming the constructor, its argument and what is expected.
    """
    for target, arguments in _described(config):
        for parameter in _parameters(target):
            if parameter.name in arguments and arguments[parameter.name] is not parameter.default:
                owner = target.rsplit(".", 1)[-1]
                _check(f"{owner}.{parameter.name}", arguments[parameter.name], parameter.annotation)


def check_targets(config: Any, where: str) -> None:
    """Refuse a run's stored configuration that would call anything but what is UcON's or in ``models``, at any depth.

    Folders of runs are passed on, and a ``_target_`` is a call. Interpolations could hide one; no run's configuration
    has any, since it is stored resolved.

    Args:
        config: what is stored.
        where: names its file.

    Raises:
        DataError: naming the key.
    """
    for key, value in _entries(config):
        if key.rpartition(".")[2] == "_target_" and not _is_ours(value):
            raise DataError(
                f"{where}: {key}={brief(value)}: what a folder names is built from ucon and models only; "
                "where you trust it, give it on the command line of a new run"
            )
        if isinstance(value, str) and "${" in value:
            raise DataError(f"{where}: {key}={brief(value)}: a stored run has no interpolations; write its value")


def _entries(node: Any, prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Dotted names of all entries, and what they hold."""
    inner = enumerate(node) if isinstance(node, list | tuple) else node.items() if isinstance(node, Mapping) else ()
    for name, value in inner:
        yield f"{prefix}{name}", value
        yield from _entries(value, f"{prefix}{name}.")


def _is_ours(target: Any) -> bool:
    """Named under our packages and made there: a name may lead on through what a module of ours has imported."""
    from hydra.utils import get_object

    if not isinstance(target, str) or not target.startswith(_OURS):
        return False
    try:
        found = get_object(target)
    except Exception:  # not importable: building it says so
        return True
    return f"{getattr(found, '__module__', '')}.".startswith(_OURS)


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


def _parameters(target: str) -> list[inspect.Parameter]:
    """Those whose annotation is a text, as it is where annotations are not evaluated."""
    from hydra.utils import get_object

    try:
        parameters = inspect.signature(get_object(target)).parameters.values()
    except Exception:  # not importable, or not to be called: building it says so
        return []
    return [parameter for parameter in parameters if isinstance(parameter.annotation, str)]


def _check(name: str, value: Any, annotation: str) -> None:
    words = [word.strip() for word in annotation.split("|")]
    if any(word not in _KINDS for word in words):
        return
    taken = {kind for word in words for kind in _KINDS[word][0]}
    if type(value) not in taken or (isinstance(value, float) and math.isnan(value)):
        expected = " or ".join(_KINDS[word][1] for word in words)
        raise ConfigError(f"{name}={brief(value)}: expected {expected}; see its file in configs/")
