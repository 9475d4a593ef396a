"""Names that stored configurations may have, and what they are called now.

Runs are kept for years, and code moves. A configuration that was stored before a move or a removal is read as if it had
been written today; whatever reads one (:mod:`ucon.commands.stored`) does so by this table alone.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from ucon.core.errors import DataError, brief

#: Constructors that moved: from where, and where to.
MOVED: Final[Mapping[str, str]] = {}

#: Arguments that are gone, by the constructor's name of today: the value that did nothing.
GONE: Final[Mapping[str, Mapping[str, Any]]] = {
    "ucon.perception.reading.ReadHabits": {"follow": 0.0},
    "ucon.learning.ppo.PPOLearner": {"expert": None},
    "ucon.envs.waypoint.search_env.UcONSearchEnv": {"expert": False},
}


def in_todays_names(node: Any, where: str) -> Any:
    """A stored configuration as it would be written today, at any depth.

    Args:
        node: plain data.
        where: names its file.

    Raises:
        DataError: it uses an argument that is gone.
    """
    if isinstance(node, list | tuple):
        return [in_todays_names(inner, where) for inner in node]
    if not isinstance(node, Mapping):
        return node
    out = {name: in_todays_names(inner, where) for name, inner in node.items()}
    target = out.get("_target_")
    if not isinstance(target, str):
        return out
    target = out["_target_"] = MOVED.get(target, target)
    for name, nothing in GONE.get(target, {}).items():
        if name in out and out[name] != nothing:
            raise DataError(
                f"{where}: {name}={brief(out[name])} of {target} is no longer there, and its value did something; "
                "play the run by the commit in its summary.json"
            )
        out.pop(name, None)
    return out
