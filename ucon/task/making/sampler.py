"""Sampling episodes: draw categories, put one object of each where a habit says, choose a target and a start.

Sampling needs PyBullet, in which placed objects settle; replaying a stored episode does not.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from ucon.core.errors import EpisodeError, PlacementError
from ucon.core.rng import stream
from ucon.habits.contexts import Context
from ucon.habits.splits import Split
from ucon.habits.types import HabitDataset
from ucon.objects.model import Relation
from ucon.sim.arrangement import Arrangement
from ucon.sim.cache import load_house
from ucon.sim.house import House
from ucon.sim.placement import import_anchor, importable, place
from ucon.sim.placement.spot import ANYWHERE, Spot
from ucon.sim.render import RasterRenderer
from ucon.sim.state import SceneState
from ucon.task.episode import Episode
from ucon.task.making.draft import Draft, anchor_instances, instances_of, replacement, room_of
from ucon.task.making.living import Drawn, Living, any_placement, drawn_context, living_in, placement_now
from ucon.task.making.starts import drawn_start
from ucon.task.rules import PAPER, TaskRules

#: What a user states about an object's place besides relation and anchor, by category, relation and anchor.
Spots = Mapping[tuple[str, Relation, str], Spot]


class EpisodeSampler:
    """Samples episodes of one habit dataset."""

    def __init__(
        self,
        dataset: HabitDataset,
        *,
        k: int = 20,
        rules: TaskRules = PAPER,
        context: bool = False,
        spots: Spots | None = None,
        even: bool = False,
    ) -> None:
        """Choose dataset and rules.

        Args:
            dataset: the habits.
            k: number of categories that an episode places.
            rules: rule set under which the episode must be solvable.
            context: whether episodes state day, hour, season, occasion and asker, and placements follow them.
            spots: the spots of some placements; other objects may be anywhere that fits their relation and anchor.
            even: draw contexts so that each place of the target is used equally often, however rare its condition.
        """
        self.dataset, self.k, self.rules, self.context, self.even = dataset, k, rules, context, even
        self.spots: Spots = spots or {}
        self._eyes = RasterRenderer(fov_deg=rules.fov_deg, counting_fov_deg=rules.fov_deg)
        self._living: dict[tuple[str, Split | None], Living] = {}

    def sample(
        self,
        scene: str,
        seed: int,
        *,
        targets: Iterable[str] | None = None,
        part: Split | None = None,
        split: str = "",
        episode_id: str = "",
    ) -> Episode:
        """Sample one episode; the same arguments give the same episode.

        Args:
            scene: name of a home.
            seed: any integer.
            targets: categories that may be the target (default: all); at least one of them is placed.
            part: draw the household from the entries that this part may use (default: from all).
            split: label to store.
            episode_id: label to store; default ``scene/seed``.

        Raises:
            EpisodeError: nothing can be placed or found in this home.
        """
        house = load_house(scene)
        living = self._household(house, part)
        wanted = None if targets is None else {name for name in targets if name in living}
        if not living or wanted == set():
            kind = "wanted category" if living else "category"
            raise EpisodeError(f"{scene}: no {kind} of dataset '{self.dataset.name}' can be placed there")
        for attempt in range(8):
            episode = self._attempt(house, scene, seed, attempt, living, wanted)
            if episode is not None:
                label = episode_id or f"{scene}/{seed}"
                return Episode.from_json(replace(episode, id=label, split=split).to_json())
        raise EpisodeError(f"{scene}, seed {seed}: no solvable episode in 8 attempts; use another seed")

    def day(self, scene: str, seed: int, targets: Sequence[str]) -> tuple[list[Episode], list[str]]:
        """One arrangement of k categories, and an episode for each target that can be found in it.

        Args:
            scene: name of a home.
            seed: any integer.
            targets: categories to be found.

        Returns:
            The episodes in the order of their targets, with ids ``scene/target/seed``; and the placements that failed,
            as text.
        """
        house = load_house(scene)
        living = self._household(house, None)
        rng = stream(seed, "day", scene)
        order = [str(name) for name in rng.permutation(sorted(living))]
        draft, placed = self._place_all(house, order, living, None, rng)
        episodes = []
        for target in targets:
            of_target = stream(seed, "day", scene, target)
            episode = self._finish(house, scene, seed, draft, placed, living, {target}, of_target)
            if episode is not None:
                named = replace(episode, id=f"{scene}/{target}/{seed}")
                episodes.append(Episode.from_json(named.to_json()))
        return episodes, draft.failures

    def target_categories(self, scene: str, part: Split | None = None) -> tuple[str, ...]:
        """Categories that an episode in this home can place, in alphabetical order.

        Args:
            scene: name of a home.
            part: draw the household from the entries that this part may use; None: from all.
        """
        return tuple(sorted(self._household(load_house(scene), part)))

    def _household(self, house: House, part: Split | None) -> Living:
        """The household of a home; computed once."""
        key = (house.spec.name, part)
        if key not in self._living:
            self._living[key] = living_in(house, self.dataset, part)
        return self._living[key]

    def _attempt(
        self,
        house: House,
        scene: str,
        seed: int,
        attempt: int,
        living: Living,
        wanted: set[str] | None,
    ) -> Episode | None:
        """One attempt at an episode; None where nothing could be placed or found."""
        rng = stream(seed, "episode", scene, attempt)
        order = [str(name) for name in rng.permutation(sorted(living))]
        if wanted is not None:  # one wanted category comes first, so that it is among the sampled ones
            first = sorted(wanted)[int(rng.integers(len(wanted)))]
            order.remove(first)
            order.insert(0, first)
        context = drawn_context(living, order[: self.k], order[0], rng, even=self.even) if self.context else None
        draft, chosen = self._place_all(house, order, living, context, rng)
        if not draft.objects:
            return None
        if context is not None:  # the asker is a user of the first category, so that is the target
            wanted = {order[0]}
        episode = self._finish(house, scene, seed, draft, chosen, living, wanted, rng)
        return None if episode is None else replace(episode, context=context)

    def _place_all(
        self,
        house: House,
        order: Sequence[str],
        living: Living,
        context: Context | None,
        rng: np.random.Generator,
    ) -> tuple[Draft, list[str]]:
        """Place k categories, anchors first. A category that cannot be placed is replaced by the next one."""
        waiting = list(order)
        chosen, waiting = waiting[: self.k], waiting[self.k :]
        draft = Draft(house, Arrangement(removed=instances_of(house, chosen)))
        placed: list[str] = []
        queue = self._dependency_order(chosen, living, context, rng)
        while queue:
            name, options = queue.pop(0)
            if self._place_one(house, name, options, draft, set(chosen), rng):
                placed.append(name)
                continue
            chosen.remove(name)
            other = replacement(house, waiting, draft)
            if other is not None:
                waiting.remove(other)
                chosen.append(other)
                draft.remove(instances_of(house, [other]))
                queue += self._dependency_order([other], living, context, rng)
        return draft, placed

    def _dependency_order(
        self, names: Sequence[str], living: Living, context: Context | None, rng: np.random.Generator
    ) -> list[tuple[str, list[Drawn]]]:
        """Categories with their placements in random order; a category comes after the anchors it needs."""
        options = {
            name: any_placement(living, name, rng) if context is None else placement_now(living, name, context, rng)
            for name in names
        }
        ordered: list[tuple[str, list[Drawn]]] = [(name, []) for name in names if not options[name]]
        left = [name for name in names if options[name]]
        while left:
            ready = [n for n in left if options[n][0].anchor not in left or options[n][0].anchor == n]
            if not ready:  # a cycle: its first member takes its next placement
                options[left[0]] = options[left[0]][1:] + options[left[0]][:1]
                ready = left[:1]
            for name in ready:
                ordered.append((name, options[name]))
                left.remove(name)
        return ordered

    def _place_one(
        self, house: House, name: str, options: list[Drawn], draft: Draft, chosen: set[str], rng: np.random.Generator
    ) -> bool:
        """Place an object by the first of its placements that works, and return whether one did."""
        for drawn in options:
            if drawn.anchor == name:
                continue
            try:
                self._realise(house, name, drawn, draft, chosen, rng)
            except PlacementError as error:
                draft.failures.append(f"{name} {drawn.relation} {drawn.anchor}: {error}")
                continue
            return True
        return False

    def _realise(
        self, house: House, name: str, drawn: Drawn, draft: Draft, chosen: set[str], rng: np.random.Generator
    ) -> None:
        """Place an object at an instance of its anchor; the anchor is added where the home lacks it."""
        saved = (draft.arrangement, list(draft.origins))
        spot = self.spots.get((name, drawn.relation, drawn.anchor), ANYWHERE)
        anchors = anchor_instances(house, draft, drawn.anchor)
        if spot.room is not None:
            anchors = [k for k in anchors if room_of(house, draft, k) == spot.room]
            if not anchors:
                raise PlacementError(f"no {drawn.anchor} in that room")
        if not anchors:
            if drawn.anchor in chosen or not importable(drawn.anchor):
                raise PlacementError(f"no {drawn.anchor} in this arrangement")
            draft.add(import_anchor(house, draft.arrangement, drawn.anchor, rng), ("", -1))
            anchors = [house.n_instances + len(draft.objects) - 1]
        reason = ""
        for instance in rng.permutation(anchors)[:4]:
            try:
                placed = place(house, draft.arrangement, name, drawn.relation, int(instance), rng, spot)
            except PlacementError as error:
                reason = str(error)
                continue
            draft.add(placed, (drawn.entry, drawn.index))
            return
        draft.arrangement, draft.origins = saved
        raise PlacementError(reason or "no instance of the anchor takes it")

    def _finish(
        self,
        house: House,
        scene: str,
        seed: int,
        draft: Draft,
        placed: list[str],
        living: Living,
        wanted: set[str] | None,
        rng: np.random.Generator,
    ) -> Episode | None:
        """Choose a target that can be found, and a start."""
        arrangement = draft.arrangement
        world = SceneState(house, arrangement)
        self._eyes.load(house, arrangement)
        candidates = [k for k, origin in enumerate(draft.origins) if origin[0]]
        if wanted is not None:
            candidates = [k for k in candidates if draft.objects[k].category in wanted]
        for target in rng.permutation(candidates)[:4] if candidates else ():
            found = drawn_start(world, self._eyes, house.n_instances + int(target), self.rules, rng)
            if found is None:
                continue
            entries = tuple(h.entry.id for name in sorted(placed) for h in living[name])
            by_category = {draft.objects[k].category: draft.origins[k][0] for k in range(len(draft.objects))}
            return Episode(
                id="",
                scene=scene,
                home_hash=house.spec.hash,
                habits=self.dataset.name,
                habits_hash=self.dataset.sha256,
                task=self.rules.name,
                seed=seed,
                split="",
                arrangement=arrangement,
                target=int(target),
                placed_by=tuple(draft.origins),
                entries=entries,
                task_entries=tuple(by_category[name] for name in sorted(placed)),
                start=found.start,
                shortest_path_m=found.shortest_path_m,
                solution=found.solution.digits,
            )
        return None
