"""The configuration of a finished run, checked and completed so that the run can be played again."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path
from typing import Any

#: Options that older configurations lack, with the values that applied then.
_DEFAULTS_OF_OLDER_RUNS = {"limit": None, "every": 1, "batch": 1, "seed": 0, "worker_timeout_s": 3600.0}
#: Options that a configuration must have, and their types; otherwise the error would come in the middle of a run.
_NEEDED: Mapping[str, type] = {
    "episodes": str,
    "agent._target_": str,
    "env._target_": str,
    "env.detector._target_": str,
    "env.source._target_": str,
    "habit_level.name": str,
    "task.name": str,
    "task.context": bool,
}


def add_places(parser: argparse.ArgumentParser) -> None:
    """Add the options ``--path`` and ``--set`` to a command."""
    from ucon.configuration.stored import add_said

    parser.add_argument(
        "--path",
        action="append",
        default=[],
        metavar="OLD=NEW",
        help="path NEW here for what the configuration calls OLD (runs/head1=FOLDER, PATH=FOLDER); may be repeated",
    )
    add_said(parser)


def places_in(args: argparse.Namespace) -> dict[str, str]:
    """New paths by old ones, as given with ``--path``.

    Raises:
        ConfigError: a word that is not OLD=NEW.
    """
    return dict(_place(word) for word in args.path)


def configuration_of(folder: Path, places: Mapping[str, str], said: Mapping[str, Any]) -> dict[str, Any]:
    """The configuration of a run, in today's names and with paths as they are here.

    Args:
        folder: of the run.
        places: new paths by old ones.
        said: values from the command line that a stored configuration must not decide.

    Raises:
        DataError: there is none, it lacks something, or it would build what it must not.
        ConfigError: a value has to be given on the command line, or ``limit`` and ``every`` are out of range.
    """
    from ucon.configuration.known_options import EVALUATION, check_options
    from ucon.configuration.stored import checked
    from ucon.core.errors import DataError
    from ucon.evaluation.kept.finished import read_config
    from ucon.evaluation.kept.seal import CONFIG

    where, config = folder / CONFIG, {**_DEFAULTS_OF_OLDER_RUNS, **_with_paths(read_config(folder), places)}
    if missing := [name for name, kind in _NEEDED.items() if not isinstance(_at(config, name), kind)]:
        raise DataError(f"{where}: no usable {', '.join(missing)} in it; restore it or evaluate again")
    # The folder must not decide where the run is played again, or where a memory is written.
    config.pop("runner", None)
    if isinstance(memory := config.get("memory"), dict) and "keep" in memory:
        memory["keep"] = None
    allowed: dict[str, Any] = checked(config, str(where), ("agent", "env"), said, "--set ")
    check_options({name: allowed[name] for name in ("limit", "every")}, EVALUATION)
    return allowed


def _at(config: Any, name: str) -> Any:
    """Value of a dotted name; None where there is none."""
    for part in name.split("."):
        config = config.get(part) if isinstance(config, dict) else None
    return config


def _with_paths(value: Any, places: Mapping[str, str]) -> Any:
    """A configuration with its paths replaced."""
    if isinstance(value, dict):
        return {name: _with_paths(inner, places) for name, inner in value.items()}
    if isinstance(value, list):
        return [_with_paths(inner, places) for inner in value]
    if isinstance(value, str):
        for old, new in places.items():
            if value == old or value.startswith(f"{old}/"):
                return new + value[len(old) :]
    return value


def bad(option: str, value: str, expected: str) -> Exception:
    """The error about a value of a command-line option.

    Args:
        option: name of the option.
        value: as given.
        expected: in words.
    """
    from ucon.core.errors import ConfigError

    return ConfigError(f"{option} {value}: expected {expected}")


def _place(word: str) -> tuple[str, str]:
    old, sign, new = word.partition("=")
    if not (old and sign and new):
        raise bad("--path", word, "OLD=NEW")
    return old.rstrip("/"), str(Path(new).expanduser())
