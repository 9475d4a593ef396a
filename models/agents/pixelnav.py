"""``pixelnav``: asks a language model which of four views to enter, and walks to a pixel in it (Cai et al., ICRA 2024).

In each round it turns through all headings and asks. ``inputs="labels"`` lists what the detector saw in each view (the
paper's planner; variant 2 of the UcON paper). ``inputs="images"`` shows the four views as one picture with their angles
(the released planner; variant 1). In the chosen view, the goal pixel is the target if the view shows it, else the
middle of the largest patch of floor. On arrival it says Done if the view had shown the target, and asks again
otherwise. Nothing is remembered, and nothing seen on the way changes the plan (unless ``interrupt_on_sight``).

Differences from the paper and its code, and their reasons:
- Four views at 90 degrees instead of twelve at 30: the task's turns.
- Views without a reachable node in sight at 1 to 5 m are left out of the question; PixelNav's first rule leaves out
  views without floor to walk on.
- Labels of the detector in use instead of Grounding DINO and SAM.
- Walking uses the planner that all agents share instead of the learned pixel policy, as in the UcON paper; the goal is
  the reachable node in view nearest to the goal pixel, at most 5 m away.
- It opens containers on arrival, which PixelNav cannot (``opens``).
- Answers are one of the listed angles without a reason, so that small models can be used.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, get_args

import cv2
import numpy as np
from numpy.typing import NDArray

from models.agents.asking import AskingAgent, listed
from ucon.core.errors import ConfigError, unknown_name
from ucon.language.choice import LanguageModel, Option, Question, sees_images
from ucon.language.phrases import phrase
from ucon.perception.mapping.semantic_map import SemanticMap
from ucon.perception.views.candidates import Candidate
from ucon.search import Decision, Manner, Strategy, Views
from ucon.task.agent import Info

Inputs = Literal["labels", "images"]
_GAP_PX = 10
_RED = (220, 30, 30)


class PixelNavAgent(AskingAgent):
    """Chooses a view, then walks to a pixel in it."""

    name = "pixelnav"

    def __init__(
        self,
        language: LanguageModel,
        *,
        inputs: Inputs = "labels",
        reach_m: float = 5.0,
        interrupt_on_sight: bool = False,
        opens: bool = True,
        temperature: float = 0.0,
        seed: int = 0,
        prompt: str = "",
    ) -> None:
        """Set up the agent; :class:`models.agents.asking.AskingAgent` has the rest.

        Args:
            language: the language model.
            inputs: ``labels`` or ``images``: how the views are described.
            reach_m: largest distance of a goal, in metres.
            interrupt_on_sight: approach the target as soon as it is seen, not only where its view was chosen.
            opens: open a closed container on arrival.
            temperature: of the choice, where the model gives scores.
            seed: of random choices.
            prompt: name of the prompt's file; by default the one for ``inputs``.

        Raises:
            ConfigError: unknown inputs, or images for a model that reads none.
        """
        if inputs not in get_args(Inputs):
            raise ConfigError(unknown_name("inputs of agent pixelnav", inputs, get_args(Inputs)))
        if inputs == "images" and not sees_images(language):
            raise ConfigError(
                f"agent pixelnav_images sends pictures, but {language.name} sees none; choose language=vision_lm or "
                "chat_api, or agent=pixelnav, which describes the view"
            )
        manner = Manner(opens=opens, interrupt="always" if interrupt_on_sight else "chosen")
        super().__init__(language, prompt or f"pixelnav_{inputs}", manner, seed, temperature)
        self._inputs, self._reach_m = inputs, reach_m
        if inputs == "images":
            self.name = "pixelnav_images"

    def strategy(self, info: Info) -> Strategy:
        """Candidates of an episode: those of the four views that show floor to walk on."""
        return Views("floor", most_m=self._reach_m, images=self._inputs == "images")

    def questions(self, decision: Decision, slot: int) -> list[Question]:
        """One question about the views, as labels or as a picture.

        Args:
            decision: has the views as candidates.
            slot: of the decision.
        """
        target, habits, system = self._constant_prompt[slot]
        weights, known = self._habit_weights[slot], decision.known
        options = tuple(
            Option(str(angle_of(known, c.view.heading)), tuple(phrase(name) for name, _ in c.things))
            for c in decision.candidates
        )
        lines = [_line(known, candidate) for candidate in decision.candidates]

        def told(order: Sequence[int]) -> str:
            names = ", ".join(options[k].name for k in order)
            return self.situation(target=target, views="\n".join(lines[k] for k in order), options=names)

        situation = told(range(len(options)))
        if self._inputs == "images":
            images = (mosaic(decision),)
            return [Question(target, habits, options, system, situation, images=images, weights=weights)]
        cloze = self.cloze(target=target)
        return [Question(target, habits, options, system, situation, cloze, listed=told, weights=weights)]


def angle_of(known: SemanticMap, heading: int) -> int:
    """Degrees to turn right from where the agent looks to a heading, such as 0, 90, 180 or 270."""
    n = known.body.headings
    return 360 // n * ((known.view.heading - heading) % n)


def _line(known: SemanticMap, candidate: Candidate) -> str:
    return f"{angle_of(known, candidate.view.heading)}: {listed(candidate.things)}; floor for {candidate.free_m:.1f} m"


def mosaic(decision: Decision) -> NDArray[np.uint8]:
    """All views in one picture, in two rows with gaps of 10 pixels, each with its angle in red.

    Returns:
        (2 H + 10, n W + 10 (n - 1), 3) uint8 for 2 n headings.

    Raises:
        ConfigError: the environment gives no images.
    """
    known = decision.known
    tiles = {angle_of(known, s.view.heading): s.rgb for s in decision.sightings if s.rgb is not None}
    if not tiles:
        raise ConfigError("agent pixelnav with inputs=images needs images: set env.observe=pixels")
    height, width = next(iter(tiles.values())).shape[:2]
    a_row = known.body.headings // 2
    out = np.full((2 * height + _GAP_PX, a_row * (width + _GAP_PX) - _GAP_PX, 3), 255, np.uint8)
    for angle, rgb in tiles.items():
        row, column = divmod(angle * known.body.headings // 360, a_row)
        tile = rgb.copy()  # do not draw into the observation
        size = height / 160
        place = (round(6 * size), round(24 * size))
        cv2.putText(tile, str(angle), place, cv2.FONT_HERSHEY_SIMPLEX, 0.7 * size, _RED, max(1, round(2 * size)))
        y, x = row * (height + _GAP_PX), column * (width + _GAP_PX)
        out[y : y + height, x : x + width] = tile
    return out
