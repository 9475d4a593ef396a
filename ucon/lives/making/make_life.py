"""Makes one life from an order: chooses the household's things, fixes their places, simulates the people.

Making a life needs PyBullet, in which placed objects settle; playing a stored life does not.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ucon.core.errors import EpisodeError
from ucon.core.rng import stream
from ucon.habits.splits import Split
from ucon.habits.types import HabitDataset
from ucon.lives.life import Life, Possession
from ucon.lives.making.days import Days, drawn_calendar, lived
from ucon.lives.making.places import PlaceMaker, Settled
from ucon.lives.making.possessions import Owned, candidates, chosen, wanted_anchors
from ucon.lives.timeline import Timeline
from ucon.sim.cache import load_house
from ucon.sim.house import House
from ucon.sim.paths import components
from ucon.sim.render import RasterRenderer
from ucon.sim.state import SceneState
from ucon.task.episode import Start
from ucon.task.rules import PAPER, TaskRules
from ucon.task.solve import Solver

#: Number of possessions of a life, and the fewest that are enough.
POSSESSIONS, LEAST_POSSESSIONS = 40, 20
#: Most anchors that are added to a home.
MOST_FIXED = 12
#: Share of the possessions whose habits change, and the days from which the day of the change is drawn.
CHANGING, CHANGE_DAYS = 0.25, (6, 7, 8, 9)
USERS_P = (0.3, 0.4, 0.3)


@dataclass(frozen=True)
class LifeOrder:
    """What to make.

    Attributes:
        id: id of the life.
        scene: name of its home.
        seed: seed of all choices.
        split: label of its group.
        targets: categories that may be asked for.
        part: part of the habits whose entries the household may use.
        days: length of the life.
        changes: whether the habits of some possessions change.
    """

    id: str
    scene: str
    seed: int
    split: str
    targets: tuple[str, ...]
    part: Split
    days: int
    changes: bool


def make_life(order: LifeOrder, dataset: HabitDataset, rules: TaskRules = PAPER) -> Life:
    """Make a life; the same arguments give the same life.

    Args:
        order: what to make.
        dataset: the habits.
        rules: rules under which every request can be met.

    Raises:
        EpisodeError: the home cannot hold enough possessions, or hardly anything can be found there.
    """
    house, seed = load_house(order.scene), order.seed
    rng = stream(seed, "life", order.scene)
    users = 1 + int(rng.choice(len(USERS_P), p=USERS_P))
    things, maker = _settled(house, order, dataset, users, rng)
    occasions = sorted({name for thing in things for name in thing.owned.occasions})
    calendar = drawn_calendar(order.days, occasions, stream(seed, "life", "calendar"))
    possessions = tuple(_possession(thing) for thing in things)
    life = Life(
        id=order.id,
        scene=order.scene,
        home_hash=house.spec.hash,
        habits=dataset.name,
        habits_hash=dataset.sha256,
        task=rules.name,
        seed=seed,
        split=order.split,
        days=order.days,
        users=users,
        first_weekday=calendar.first_weekday,
        season=calendar.season,
        occasions=calendar.occasions,
        change_day=int(rng.choice(CHANGE_DAYS)) if any(one.later for one in possessions) else None,
        removed=maker.arrangement.removed,
        fixed=maker.fixed,
        fixed_blocked=tuple(sorted({cell for placed in maker.fixed for cell in maker.blocked(placed)})),
        dock=_dock(house, maker, rng),
        possessions=possessions,
        at_first=(0,) * len(possessions),
        moves=(),
        requests=(),
    )
    life = lived(life, dataset)
    wanted = [k for k, one in enumerate(possessions) if one.category in order.targets]
    life = replace(life, requests=Days(life, dataset).requests(wanted, Findable(life, house, rules)))
    return Life.from_json(life.to_json(), where=f"life {life.id}")


class Findable:
    """Whether a possession can be found at a time, by rendering every pose near it; results are cached."""

    def __init__(self, life: Life, house: House, rules: TaskRules) -> None:
        """Take a life with its moves."""
        self._timeline, self._house, self._rules = Timeline(life), house, rules
        self._eyes = RasterRenderer(fov_deg=rules.fov_deg, counting_fov_deg=rules.fov_deg)
        self._known: dict[tuple[int, int], bool] = {}

    def __call__(self, possession: int, time: int) -> bool:
        """Whether a possession can be found at a time from the dock."""
        key = (possession, time)
        if key not in self._known:
            life, arrangement = self._timeline.life, self._timeline.arrangement(time)
            world = SceneState(self._house, arrangement)
            self._eyes.load(self._house, arrangement)
            target = self._house.n_instances + len(life.fixed) + possession
            solver = Solver(world, self._eyes, target, self._rules)
            self._known[key] = bool(solver.field()[life.dock.i, life.dock.j] >= 0)
        return self._known[key]


def _settled(
    house: House, order: LifeOrder, dataset: HabitDataset, users: int, rng: np.random.Generator
) -> tuple[list[Settled], PlaceMaker]:
    """Possessions with enough places; those with too few are replaced by others, once."""
    found = candidates(house, dataset, order.part, users, set(order.targets), rng)
    owned, spare = chosen(found, POSSESSIONS)
    groups = owned, spare[: POSSESSIONS // 2]
    maker = PlaceMaker(house, [one.category for group in groups for one in group], rng)
    maker.add_anchors(wanted_anchors(owned), MOST_FIXED)
    done: list[Settled] = []
    changing = round(CHANGING * POSSESSIONS) if order.changes else 0
    for group in groups:
        things = _changing(group[: POSSESSIONS - len(done)], changing, rng)
        maker.settle(things)
        maker.drop([thing for thing in things if not thing.complete])
        done += [thing for thing in things if thing.complete]
        changing -= sum(thing.changes for thing in things if thing.complete)
        if len(done) == POSSESSIONS:
            break
    if len(done) < LEAST_POSSESSIONS:
        raise EpisodeError(f"{order.scene}: places for {len(done)} possessions, expected {LEAST_POSSESSIONS}")
    return done, maker


def _changing(group: Sequence[Owned], count: int, rng: np.random.Generator) -> list[Settled]:
    """The things, with a random ``count`` of them marked to change."""
    able = [k for k, one in enumerate(group) if one.to_change()]
    picked = {able[int(k)] for k in rng.permutation(len(able))[:count]}
    return [
        Settled(one.to_change() or one, changes=True) if k in picked else Settled(one) for k, one in enumerate(group)
    ]


def _possession(thing: Settled) -> Possession:
    entries = tuple(host.entry.id for host in thing.owned.hosts)
    later = tuple(host.entry.id for host in thing.later_hosts)
    return Possession(thing.owned.category, entries, later, (*thing.kept, *thing.later, *thing.stray))


def _dock(house: House, maker: PlaceMaker, rng: np.random.Generator) -> Start:
    """A random node of the connected floor that nothing ever blocks."""
    free = SceneState(house, maker.arrangement).free
    nodes = np.argwhere((components(free) == 0) & free)
    i, j = (int(v) for v in nodes[int(rng.integers(len(nodes)))])
    return Start(i, j, int(rng.integers(4)))
