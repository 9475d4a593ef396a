"""Which constructors ``configs/`` names at which place: all that a stored configuration may have built there.

A place is a dotted name, such as ``env.detector``. Every file under ``configs/`` says what may stand where, by its
package and by the interpolations in it: ``env.detector: ${detector}`` permits at ``env.detector`` whatever a file of
``configs/detector/`` names, and by ``learner.env.config: ${env}`` at ``learner.env.config.detector`` too. So a new
agent or detector, which is a file in ``configs/``, needs no mention anywhere else.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Final

import yaml

import ucon
from ucon.core.errors import DataError

#: The clone's, beside the package; a wheel has none.
CONFIGS: Final = Path(ucon.__file__).resolve().parents[1] / "configs"

Place = tuple[str, ...]
ROOT: Final[frozenset[Place]] = frozenset({()})

_PACKAGE: Final = re.compile(r"^#\s*@package\s+(\S+)", re.MULTILINE)
_TAKEN: Final = re.compile(r"\$\{(?:oc\.select:)?([\w.]+)(?:,[^${}]*)?\}")


@dataclass(frozen=True)
class Call:
    """A constructor and how Hydra is told to call it: ``_partial_``, ``_recursive_``, all keys with a leading ``_``."""

    target: str
    manner: tuple[tuple[str, str], ...]

    @classmethod
    def of(cls, node: Mapping[Any, Any]) -> Call | None:
        """The call that a node of a configuration is; None where it is none.

        Values count by their ``repr``, since a stranger's may be anything.
        """
        manner = {str(name): repr(value) for name, value in node.items() if str(name).startswith("_")}
        if not manner:
            return None
        manner.pop("_target_", None)
        return cls(str(node.get("_target_")), tuple(sorted(manner.items())))


@dataclass(frozen=True)
class PermittedConstructors:
    """What stands where in ``configs/``."""

    calls: Mapping[Place, frozenset[Call]]
    """By place, what is built there."""
    taken: Mapping[Place, frozenset[Place]]
    """By place, the places whose content it takes over."""

    def within(self, above: Iterable[Place], name: str) -> frozenset[Place]:
        """All names of the entry ``name`` of a node that has the names ``above``: its own, and those it takes over."""
        found: set[Place] = set()
        waiting = [(*place, name) for place in above]
        while waiting:
            if (place := waiting.pop()) not in found:
                found.add(place)
                waiting += self.taken.get(place, ())
        return frozenset(found)

    def permitted(self, names: Iterable[Place]) -> frozenset[Call]:
        """What may be built at a node that has these names."""
        return frozenset(call for name in names for call in self.calls.get(name, ()))


@cache
def places(configs: Path = CONFIGS) -> PermittedConstructors:
    """The places of all files under ``configs``.

    Raises:
        DataError: there are none, or one cannot be read.
    """
    files = sorted(configs.rglob("*.yaml"))
    if not files:
        raise DataError(f"{configs}: no configurations, which say what a stored run may build; use a clone of UcON")
    calls: defaultdict[Place, set[Call]] = defaultdict(set)
    taken: defaultdict[Place, set[Place]] = defaultdict(set)
    for file in files:
        text = file.read_text(encoding="utf-8")
        try:
            content = yaml.safe_load(text)
        except yaml.YAMLError:
            raise DataError(f"{file}: not YAML; mend it") from None
        if isinstance(content, dict):
            for place, source in _placed(content.pop("defaults", [])):
                taken[place].add(source)
            content.pop("hydra", None)  # of the command line alone
            _collect(content, _package(text, file.parent.relative_to(configs)), calls, taken)
    return PermittedConstructors(
        {place: frozenset(found) for place, found in calls.items()},
        {place: frozenset(found) for place, found in taken.items()},
    )


def _package(text: str, group: Path) -> Place:
    """Where a file's content goes: its group, unless it says otherwise."""
    said = _PACKAGE.search(text)
    if said is None:
        return group.parts
    return () if said[1] == "_global_" else tuple(said[1].split("."))


def _placed(defaults: Any) -> Iterable[tuple[Place, Place]]:
    """Entries of a defaults list that put a group elsewhere: ``/agent/habit_policy@learner.demonstrator.agent``."""
    for entry in defaults if isinstance(defaults, list) else ():
        path, _, package = (entry if isinstance(entry, str) else next(iter(entry))).partition("@")
        if package and package != "_global_":
            group = path.removeprefix("override ").strip("/").split("/")
            yield tuple(package.split(".")), tuple(group[:-1] if isinstance(entry, str) else group)


def _collect(
    node: Any, place: Place, calls: defaultdict[Place, set[Call]], taken: defaultdict[Place, set[Place]]
) -> None:
    """Enter what ``node`` builds and takes over at ``place``, at any depth."""
    if isinstance(node, Mapping):
        if (call := Call.of(node)) is not None:
            calls[place].add(call)
        for name, inner in node.items():
            _collect(inner, (*place, str(name)), calls, taken)
    elif isinstance(node, str) and (whole := _TAKEN.fullmatch(node)):
        taken[place].add(tuple(whole[1].split(".")))
