"""What a person is shown in a step: an agent's observation and info, and a map made from these alone."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Sequence
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from ucon.perception.drawing.map_picture import draw_map
from ucon.perception.mapping.semantic_map import SemanticMap
from ucon.task.actions import NO_ACTION, Action, decoded_action
from ucon.task.agent import Info, Observation

#: Pixels of a cell of the map of what was seen.
_CELL_PX: Final = 12


class Sights:
    """Turns the observations of one episode into what the page shows; also remembers what was seen.

    Attributes:
        target: what is searched for, in words.
        habits: sentences that were given.
        context: sentence about time and asker, where the episode states them.
    """

    def __init__(self, info: Info) -> None:
        """Begin an episode.

        Args:
            info: of the environment's reset.
        """
        self.episode = str(info["episode"])
        self.target = str(info["target"]).replace("_", " ")
        self.habits: tuple[str, ...] = tuple(info["habits"])
        self.context: str | None = info["context"]
        self._category = str(info["target"])
        self._map = SemanticMap.of(info)
        self._pitch = 0.0

    def see(self, observation: Observation, info: Info) -> str:
        """Add a frame to what was seen.

        Args:
            observation: of the reset or the last step.
            info: of the same.

        Returns:
            What the last action did, in words; "" at the start.
        """
        before, self._pitch = self._pitch, float(observation["pose"][3])
        self._map.update(observation, info)
        action = decoded_action(observation["last_action"])
        if action == NO_ACTION:
            return ""
        if action == Action.MOVE_AHEAD:
            return "Blocked: something is in the way." if observation["collision"][0] else "Moved 0.25 m ahead."
        if action in (Action.LOOK_UP, Action.LOOK_DOWN):
            way = "up" if action == Action.LOOK_UP else "down"
            moved = abs(self._pitch - before) > 1e-6
            return f"Looked {way}." if moved else f"Cannot look further {way}."
        if action == Action.OPEN:
            opened = [self._map.category[track].replace("_", " ") for track in info["opened"]]
            return f"Opened: {', '.join(opened)}." if opened else "Nothing to open in view within 1 m."
        return {Action.ROTATE_LEFT: "Turned left.", Action.ROTATE_RIGHT: "Turned right."}.get(Action(action), "")

    def shown(self, observation: Observation) -> dict[str, Any]:
        """The current view as the page shows it.

        Args:
            observation: the last one.

        Returns:
            ``picture`` and ``map`` as data URLs, ``pitch_deg``, and ``things`` in view, nearest
            first: ``name``, ``metres``, ``target``, ``opened``.
        """
        return {
            "picture": _png(observation["rgb"]),
            "map": _png(draw_map(self._map, target=self._category, names=True, cell_px=_CELL_PX)),
            "pitch_deg": round(float(np.degrees(self._pitch))),
            "things": self._things(),
        }

    def _things(self) -> list[dict[str, Any]]:
        known, here = self._map, self._map.view.xy
        tracks: Sequence[int] = np.flatnonzero(known.pixels[: known.n_tracks]).tolist()
        found = [
            {
                "name": known.category[track].replace("_", " "),
                "metres": round(known.gap_m(track, here), 2),
                "target": known.category[track] == self._category,
                "opened": bool(known.opened[track]),
            }
            for track in tracks
            if not known.kind[track] and known.seen(track)
        ]
        return sorted(found, key=lambda thing: (thing["metres"], thing["name"]))


def _png(image: NDArray[np.uint8]) -> str:
    """A picture (H, W, 3), RGB, as the data URL of a PNG, without loss."""
    _, data = cv2.imencode(".png", cv2.cvtColor(image, cv2.COLOR_RGB2BGR))
    return f"data:image/png;base64,{b64encode(data.tobytes()).decode()}"
