"""The memory of a robot that keeps the map of its home."""

from __future__ import annotations

from typing import Any

from ucon.memory.protocol import Info, Observation
from ucon.perception.mapping.body import Body
from ucon.perception.mapping.semantic_map import SemanticMap


class MapMemory:
    """Keeps the map of the home: rooms, furniture, and where things were last seen."""

    name = "map"

    def __init__(self) -> None:
        """Start without a home."""
        self.map: SemanticMap | None = None

    def begin(self, info: Info) -> dict[str, Any]:
        """The info for the agent's reset, with the map as ``kept_map``; see :class:`ucon.memory.protocol.Memory`."""
        target = str(info["target"])
        if self.map is None:
            self.map = SemanticMap(Body.of(info), info.get("detector_errors"), target)
        else:
            self.map.search_again(target)
        return {**info, "kept_map": self.map}

    def look(self, observation: Observation, info: Info) -> None:
        """Nothing to do: the agent enters its frames in the map."""

    def end(self) -> None:
        """Nothing to do."""
