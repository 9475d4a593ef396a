"""The memory of a robot that keeps the map of its home."""

from __future__ import annotations

from typing import Any

from ucon.core.errors import ConfigError
from ucon.lives.request_record import BelievedPlace
from ucon.memory.protocol import Info, Observation
from ucon.perception.mapping.body import Body
from ucon.perception.mapping.semantic_map import SemanticMap
from ucon.task.actions import Action


class MapMemory:
    """Keeps the map of the home: rooms, furniture, and where things were last seen."""

    name, uses_habits = "map", False
    believed: tuple[BelievedPlace, ...] | None = None

    def __init__(self) -> None:
        """Start without a home."""
        self.map: SemanticMap | None = None

    def patrol(self, observation: Observation, info: Info) -> int:
        """End the patrol at once, since a map alone gives no reason to look."""
        return int(Action.DONE)

    def begin(self, info: Info) -> dict[str, Any]:
        """The info for the agent's reset, with the map as ``kept_map``; see :class:`ucon.memory.protocol.Memory`."""
        target = str(info["target"])
        if self.map is None:
            self.map = SemanticMap(Body.of(info), info.get("detector_errors"), target, kept=True)
        else:
            self.map.search_again(target)
        return {**info, "kept_map": self.map}

    def look(self, observation: Observation, info: Info) -> None:
        """Check that the agent enters its frames into the map.

        Raises:
            ConfigError: the agent keeps no map.
        """
        if self.map is None or not self.map.views:
            raise ConfigError(f"memory of {self.name}: this agent keeps no map; leave memory= out")

    def act(self, action: int, observation: Observation) -> int:
        """The agent's action, unchanged."""
        return action

    def end(self) -> None:
        """Do nothing."""
