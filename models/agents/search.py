"""The searching controller that ``frontier`` and ``belief`` share: of all views, that of the most gain for its cost."""

from __future__ import annotations

from ucon.perception.belief.protocol import Expecting
from ucon.perception.drawing.map_picture import Image
from ucon.perception.views.viewpoints import Costs
from ucon.search.searcher import Searcher
from ucon.task.agent import Info, Observation


class SearchController:
    """Searches one home for one target."""

    def __init__(self, info: Info, expecting: Expecting, costs: Costs | None = None) -> None:
        self.searcher = Searcher(info, expecting, costs)

    def act(self, observation: Observation, info: Info) -> int:
        """The next action."""
        action = self.searcher.look(observation, info)
        if action is None:
            action = self.searcher.choose(self.searcher.decision().best)
        return int(action)

    def picture(self) -> Image:
        """What it thinks; see :func:`ucon.search.picture.draw_search`."""
        from ucon.search.picture import draw_search

        return draw_search(self.searcher)
