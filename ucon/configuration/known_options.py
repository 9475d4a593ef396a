"""Kinds and ranges of the options of ``eval.yaml`` and ``train.yaml`` that are not arguments of a constructor.

Arguments of constructors are checked by their annotations (:mod:`ucon.configuration.arguments`). A test requires that
every option of both files is checked in one of the two ways.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from ucon.configuration.kinds import (
    ANYTHING,
    NOTHING,
    PART,
    PLACE,
    SECONDS,
    SWITCH,
    TEXT,
    Kind,
    either,
    is_part,
    one_of,
    whole,
)
from ucon.configuration.near_options import unknown_option
from ucon.core.errors import ConfigError, brief

#: Highest number of threads; torch fails on far larger ones.
MOST_THREADS: Final = 1024

EVALUATION: Final[Mapping[str, Kind]] = {
    "episodes": TEXT,
    "limit": either([whole(1), NOTHING]),
    "every": whole(1),
    "out": PLACE,
    "runner": PART,
    "workers": either([whole(0), one_of("auto")]),
    "worker_timeout_s": either([SECONDS, NOTHING]),
    "batch": whole(1),
    "seed": whole(0),
    "pictures": whole(0),
    "progress": SWITCH,
    "knowledge_base": TEXT,
    "habit_level.name": TEXT,
    "habit_level.top_p": whole(1),
    "task.name": TEXT,
    "task.context": SWITCH,
    "agent": PART,
    "detector": PART,
    "habits": PART,
    "language": PART,
    "memory": either([PART, NOTHING]),
    "retriever": PART,
    "env": PART,
    "env.detector": PART,
    "env.source": PART,
}

TRAINING: Final[Mapping[str, Kind]] = {
    "out": PLACE,
    "resume": either([TEXT, NOTHING]),
    "runner": PART,
    "seed": whole(0),
    "threads": whole(1, MOST_THREADS),
    "progress": SWITCH,
    "wandb": either([Kind("false", lambda value: value is False), NOTHING, one_of("offline", "online")]),
    "tensorboard": SWITCH,
    "training.steps": whole(1),
    "training.validate_every": whole(1),
    "training.save_every": whole(1),
    "training.keep": whole(1),
    "training.extended": ANYTHING,  # of runs that were extended; checked by Plan
    "agent": either([PART, NOTHING]),
    "collector": PART,
    "detector": PART,
    "habits": PART,
    "language": PART,
    "retriever": PART,
    "learner": PART,
    "env": PART,
    "search": PART,
}


def check_options(config: Mapping[str, Any], kinds: Mapping[str, Kind]) -> None:
    """Refuse values of the wrong kind, and unknown options.

    Missing options are accepted: older runs have fewer.

    Args:
        config: resolved, as plain data.
        kinds: :data:`EVALUATION` or :data:`TRAINING`.

    Raises:
        ConfigError: naming the option and what is expected.
    """
    for name, value in _leaves(config, kinds):
        kind = kinds.get(name)
        if kind is None:
            raise ConfigError(unknown_option(name, kinds))
        if not kind.takes(value):
            raise ConfigError(f"{name}={brief(value)}: expected {kind.expected}")


def _leaves(config: Mapping[str, Any], kinds: Mapping[str, Kind]) -> list[tuple[str, Any]]:
    """Options with their values: those within groups without ``_target_``, and parts with their listed options."""
    out: list[tuple[str, Any]] = []
    for name, value in config.items():
        groups = {known.partition(".")[2] for known in kinds if known.startswith(f"{name}.")}
        if name in kinds:
            out.append((str(name), value))
            out += [(f"{name}.{inner}", value[inner]) for inner in groups if is_part(value) and inner in value]
        elif groups and isinstance(value, Mapping):
            out += [(f"{name}.{inner}", content) for inner, content in value.items()]
        else:
            out.append((str(name), value))
    return out
