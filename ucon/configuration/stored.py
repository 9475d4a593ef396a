"""What a stored configuration may build. Runs' folders are passed on, so their configurations are not trusted.

``replay``, ``cases`` and ``train.py resume=`` build objects from a configuration in a folder. At each place it may name
only what ``configs/`` names there. Values that reach beyond this process (programs, servers, downloads) are never taken
from it: they have to be given again on the command line. Classes list such arguments in ``from_command_line``.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from ucon.configuration.constructors import ROOT, Call, Place, places
from ucon.configuration.old_names import in_todays_names
from ucon.core.errors import ConfigError, DataError, brief


def add_said(parser: argparse.ArgumentParser) -> None:
    """Add the option ``--set`` to a command, for values that a folder must not decide."""
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="OPTION=VALUE",
        help="a program, server or download that a run's folder must not choose, such as detector.python=FILE; may be "
        "repeated",
    )


def said_in(args: argparse.Namespace) -> dict[str, Any]:
    """Values given with ``--set``, by option.

    Raises:
        ConfigError: a word that is not OPTION=VALUE, or an option that the folder does decide.
    """
    said: dict[str, Any] = {}
    for word in args.set:
        name, sign, value = word.partition("=")
        if not (name and sign):
            raise ConfigError(f"--set {word}: expected OPTION=VALUE")
        if not has_to_be_said(name):
            raise ConfigError(
                f"--set {word}: expected an option that a stored run must not choose, such as detector.python; "
                "all others are taken as stored"
            )
        said[name] = {"true": True, "false": False}.get(value, value)
    return said


def checked(config: Mapping[str, Any], where: str, built: Sequence[str], said: Mapping[str, Any], how: str) -> Any:
    """A stored configuration in today's names, checked, with the values from the command line.

    Args:
        config: as stored, plain data; not trusted.
        where: names its file, for errors.
        built: names of the parts that are going to be built; only these get values from the command line.
        said: values from the command line, by the names that a new run has for them (``detector.python``).
        how: how such a value is given on the command line, such as ``--set ``.

    Raises:
        DataError: naming a key that builds what it must not, or holds an interpolation.
        ConfigError: naming options that have to be given again.
    """
    config = in_todays_names(config, where)
    _check_calls(config, where)
    needed: dict[str, Any] = {}
    out = {
        name: _with_values(said, needed, config[name], places().within(ROOT, name)) for name in config if name in built
    }
    if needed:
        told = " ".join(f"{how}{name}={brief(value)}" for name, value in sorted(needed.items()))
        raise ConfigError(
            f"{where}: programs, servers and downloads are not taken from a folder; if you trust it, give {told}"
        )
    return {**config, **out}


def has_to_be_said(option: str) -> bool:
    """Whether an option, by the name that a new run has for it, must be given on the command line."""
    *place, name = option.split(".")
    return any(name in _restricted_arguments(call.target) for call in places().calls.get(tuple(place), ()))


def _with_values(said: Mapping[str, Any], needed: dict[str, Any], node: Any, names: frozenset[Place]) -> Any:
    """``node`` with values from the command line; required ones that are missing are added to ``needed``."""
    if isinstance(node, list | tuple):
        return [_with_values(said, needed, inner, places().within(names, str(k))) for k, inner in enumerate(node)]
    if not isinstance(node, Mapping):
        return node
    out = {name: _with_values(said, needed, inner, places().within(names, str(name))) for name, inner in node.items()}
    target = node.get("_target_")
    for name in _restricted_arguments(target):
        option = ".".join((*_own_place(names, target), name))
        if option in said:
            out[name] = said[option]
        elif node.get(name):
            needed[option] = node[name]
    return out


def _own_place(names: frozenset[Place], target: Any) -> Place:
    """The place of a node under which ``configs/`` itself describes such a part."""
    calls = places().calls
    return min(name for name in names if any(call.target == target for call in calls.get(name, ())))


def _check_calls(config: Any, where: str) -> None:
    """Refuse calls that ``configs/`` does not make at their place, and interpolations, at any depth.

    Interpolations could hide a call; stored configurations are resolved and have none.
    """
    known = places()
    for key, node, names in _nodes(config, (), ROOT):
        if isinstance(node, str) and "${" in node:
            raise DataError(
                f"{where}: {_dotted(key)}={brief(node)}: a stored run has no interpolations; write its value"
            )
        if not isinstance(node, Mapping) or (call := Call.of(node)) is None:
            continue
        permitted = known.permitted(names)
        if call in permitted and isinstance(node.get("_target_"), str):
            continue
        if call.target in {one.target for one in permitted}:
            told = ", ".join(f"{name}: {value}" for name, value in call.manner) or "nothing else"
            problem = f"{_dotted(key)} is called with {brief(told)}, which configs/ never does"
        else:
            problem = f"{_dotted((*key, '_target_'))}={brief(call.target)}: nothing in configs/ builds that there"
        raise DataError(
            f"{where}: {problem}; a stored run builds only what configs/ builds; if you trust it, add a file there"
        )


def _nodes(node: Any, key: Place, names: frozenset[Place]) -> Iterator[tuple[Place, Any, frozenset[Place]]]:
    """All nodes at any depth: keys that lead there, the node, and all its places."""
    yield key, node, names
    inner = enumerate(node) if isinstance(node, list | tuple) else node.items() if isinstance(node, Mapping) else ()
    for name, value in inner:
        yield from _nodes(value, (*key, str(name)), places().within(names, str(name)))


def _dotted(key: Place) -> str:
    return ".".join(key) or "the configuration"


def _restricted_arguments(target: Any) -> Sequence[str]:
    """Arguments of a constructor that reach beyond this process."""
    if not isinstance(target, str):
        return ()
    from hydra.utils import get_object

    try:
        found = get_object(target)
    except Exception:  # building it gives the error
        return ()
    return tuple(getattr(found, "from_command_line", ()))
