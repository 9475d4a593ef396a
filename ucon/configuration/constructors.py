"""Which constructors ``configs/`` names at which place: all that a stored configuration may build there.

A place is a dotted name, such as ``env.detector``. Each file under ``configs/`` says, by its package and its
interpolations, what may stand where: ``env.detector: ${detector}`` permits at ``env.detector`` everything that files in
``configs/detector/`` name, and by ``learner.env.config: ${env}`` at ``learner.env.config.detector`` too. So a new agent
or detector, which is a file in ``configs/``, needs no entry anywhere else.
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

#: Folder of the configurations, next to the package in a clone; a wheel has none.
CONFIGS: Final = Path(ucon.__file__).resolve().parents[1] / "configs"

Place = tuple[str, ...]
ROOT: Final[frozenset[Place]] = frozenset({()})

_PACKAGE: Final = re.compile(r"^#\s*@package\s+(\S+)", re.MULTILINE)
_TAKEN: Final = re.compile(r"\$\{(?:oc\.select:)?([\w.]+)(?:,[^${}]*)?\}")


@dataclass(frozen=True)
class Call:
    """A constructor and how Hydra is told to call it.

    The latter are all keys with a leading ``_`` besides ``_target_``, such as ``_partial_`` and ``_recursive_``.
    """

    target: str
    manner: tuple[tuple[str, str], ...]

    @classmethod
    def of(cls, node: Mapping[Any, Any]) -> Call | None:
        """The call that a node of a configuration describes; None where it describes none.

        Values are compared by their ``repr``, since untrusted ones may be of any type.
        """
        manner = {str(name): repr(value) for name, value in node.items() if str(name).startswith("_")}
        if not manner:
            return None
        manner.pop("_target_", None)
        return cls(str(node.get("_target_")), tuple(sorted(manner.items())))


@dataclass(frozen=True)
class PermittedConstructors:
    """What may be built at which place."""

    calls: Mapping[Place, frozenset[Call]]
    """Permitted calls by place."""
    taken: Mapping[Place, frozenset[Place]]
    """Places whose content is also permitted at a place, by interpolation."""

    def within(self, above: Iterable[Place], name: str) -> frozenset[Place]:
        """All places of the entry ``name`` of a node: its own, and those that it takes over by interpolation.

        Args:
            above: all places of the node.
            name: key of the entry.
        """
        found: set[Place] = set()
        waiting = [(*place, name) for place in above]
        while waiting:
            if (place := waiting.pop()) not in found:
                found.add(place)
                waiting += self.taken.get(place, ())
        return frozenset(found)

    def permitted(self, names: Iterable[Place]) -> frozenset[Call]:
        """Calls that are permitted at a node with these places."""
        return frozenset(call for name in names for call in self.calls.get(name, ()))


@cache
def places(configs: Path = CONFIGS) -> PermittedConstructors:
    """Permitted constructors by all files under ``configs``.

    Args:
        configs: folder with YAML files.

    Raises:
        DataError: there are none, or one cannot be read.
    """
    files = sorted(configs.rglob("*.yaml"))
    if not files:
        raise DataError(f"{configs}: no configurations there to say what a stored run may build; use a clone of UcON")
    calls: defaultdict[Place, set[Call]] = defaultdict(set)
    taken: defaultdict[Place, set[Place]] = defaultdict(set)
    for file in files:
        text = file.read_text(encoding="utf-8")
        try:
            content = yaml.safe_load(text)
        except yaml.YAMLError:
            raise DataError(f"{file}: not YAML; fix it") from None
        if isinstance(content, dict):
            for place, source in _placed(content.pop("defaults", [])):
                taken[place].add(source)
            content.pop("hydra", None)  # settings of the command line, which build nothing of a run
            _collect(content, _package(text, file.parent.relative_to(configs)), calls, taken)
    return PermittedConstructors(
        {place: frozenset(found) for place, found in calls.items()},
        {place: frozenset(found) for place, found in taken.items()},
    )


def _package(text: str, group: Path) -> Place:
    """Place of a file's content: its group, or what ``@package`` says."""
    said = _PACKAGE.search(text)
    if said is None:
        return group.parts
    return () if said[1] == "_global_" else tuple(said[1].split("."))


def _placed(defaults: Any) -> Iterable[tuple[Place, Place]]:
    """Entries of a defaults list that put a group elsewhere.

    Such as ``/agent/habit_policy@learner.demonstrator.agent``.
    """
    for entry in defaults if isinstance(defaults, list) else ():
        path, _, package = (entry if isinstance(entry, str) else next(iter(entry))).partition("@")
        if package and package != "_global_":
            group = path.removeprefix("override ").strip("/").split("/")
            yield tuple(package.split(".")), tuple(group[:-1] if isinstance(entry, str) else group)


def _collect(
    node: Any, place: Place, calls: defaultdict[Place, set[Call]], taken: defaultdict[Place, set[Place]]
) -> None:
    """Add what ``node`` builds and takes over at ``place``, at any depth."""
    if isinstance(node, Mapping):
        if (call := Call.of(node)) is not None:
            calls[place].add(call)
        for name, inner in node.items():
            _collect(inner, (*place, str(name)), calls, taken)
    elif isinstance(node, str) and (whole := _TAKEN.fullmatch(node)):
        taken[place].add(tuple(whole[1].split(".")))
