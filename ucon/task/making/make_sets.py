"""Makes and checks whole sets of episodes in several processes; the result does not depend on how many."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from itertools import islice
from pathlib import Path
from typing import Any, TypeVar

from ucon.core.errors import EpisodeError, UconError
from ucon.core.files import canonical_json, write_atomic
from ucon.core.pool import Pool
from ucon.core.untrusted.plain_file import read_plain
from ucon.core.untrusted.strict_json import JsonError, parse_json
from ucon.habits.book import book
from ucon.habits.splits import Split
from ucon.habits.types import HabitDataset
from ucon.sim.cache import load_house
from ucon.sim.render import RasterRenderer
from ucon.sim.state import SceneState
from ucon.task.begin import begun_search
from ucon.task.check import check_home
from ucon.task.episode import Episode
from ucon.task.making.sampler import EpisodeSampler
from ucon.task.making.set_plans import Order
from ucon.task.robot.rig import RobotRig
from ucon.task.rules import PAPER, TaskRules, task_rules
from ucon.task.search import Search

T = TypeVar("T")
R = TypeVar("R")
#: Added to the seed of an order for which no episode could be sampled.
RETRY_SEED_STEP = 1 << 32
#: Lengths that differ by less count as equal, metres.
_SAME_M = 1e-6
#: Largest journal that is read, bytes.
_MAX_JOURNAL = 1 << 30


def make_episodes(
    orders: Sequence[Order],
    dataset: HabitDataset | None = None,
    *,
    task: str = PAPER.name,
    context: bool = False,
    even: bool = False,
    workers: int = 2,
    progress: Callable[[int, int], None] | None = None,
    journal: Path | None = None,
) -> list[Episode]:
    """Sample an episode for every order.

    Args:
        orders: what to sample.
        dataset: the habits; the habit book by default.
        task: rule set under which episodes must be solvable.
        context: whether episodes state their context.
        even: see :class:`ucon.task.making.sampler.EpisodeSampler`.
        workers: processes.
        progress: called with (done, total).
        journal: file to which episodes are appended as they are made; a repeated call does not make them again.

    Returns:
        Episodes in the order of ``orders``.

    Raises:
        EpisodeError: no seed satisfies an order.
    """
    done = [] if journal is None else _noted(journal, orders, (dataset or book()).sha256)
    with _mapping(workers, dataset, task, context, even) as over:
        return _collect(over(_sample, orders[len(done) :]), done, len(orders), progress, journal)


def hosted_orders(
    orders: Iterable[Order],
    dataset: HabitDataset,
    *,
    limit: int | None = None,
    context: bool = False,
    workers: int = 2,
    left_out: Callable[[str], None],
) -> list[Order]:
    """The orders whose home can hold one of their targets; a user's small habit book fits few homes.

    Args:
        orders: the orders of a set.
        dataset: the habits.
        limit: most orders to return, the first ones; None: all.
        context: whether the episodes state their context.
        workers: processes that check the homes.
        left_out: called with one line for each home and group of orders that is left out.
    """
    planned = list(orders)
    homes = dict.fromkeys((order.scene, order.part) for order in planned)
    with _mapping(workers, dataset, PAPER.name, context) as over:
        return list(islice(_hosted(planned, over(_targets, homes), dataset.name, left_out), limit))


def _hosted(
    orders: Iterable[Order], looked: Iterator[tuple[str, ...]], name: str, left_out: Callable[[str], None]
) -> Iterator[Order]:
    """The orders that can be met; ``looked``: what each home can hold, in the order in which homes first occur."""
    held, said = dict[tuple[str, Split | None], tuple[str, ...]](), set[str]()
    for order in orders:
        home = (order.scene, order.part)
        if home not in held:
            held[home] = next(looked)
        if held[home] and (order.targets is None or not set(order.targets).isdisjoint(held[home])):
            yield order
            continue
        line = f"{order.scene}, {order.split}: left out, no target of dataset '{name}' can be placed there"
        if line not in said:
            said.add(line)
            left_out(line)


@contextmanager
def _mapping(workers: int, *begin: Any) -> Iterator[Callable[[Callable[[T], R], Iterable[T]], Iterator[R]]]:
    """A ``map`` over that many processes, or in this one; each process begins with ``_begin(*begin)``."""
    if workers <= 1:
        _begin(*begin)
        yield map
        return
    with Pool(workers, _begin, begin) as pool:
        yield pool.map


def _collect(
    results: Iterable[Episode],
    done: list[Episode],
    total: int,
    progress: Callable[[int, int], None] | None,
    journal: Path | None,
) -> list[Episode]:
    """Append the results to ``done`` and to the journal, and report progress."""
    with journal.open("a", encoding="utf-8") if journal else nullcontext() as notes:
        for episode in results:
            done.append(episode)
            if notes:
                notes.write(canonical_json(episode.to_json()) + "\n")
                notes.flush()
            if progress:
                progress(len(done), total)
    return done


def _noted(journal: Path, orders: Sequence[Order], habits_hash: str) -> list[Episode]:
    """The leading episodes of a journal that match the orders; the rest of the journal is removed."""
    found: list[Episode] = []
    raw = read_plain(journal, _MAX_JOURNAL) if journal.is_file() else b""
    for order, line in zip(orders, raw[: raw.rfind(b"\n") + 1].split(b"\n"), strict=False):
        try:
            episode = Episode.from_json(parse_json(line))
            same = (episode.id, episode.seed % RETRY_SEED_STEP, episode.habits_hash)
            if same != (order.id, order.seed, habits_hash) or load_house(episode.scene).spec.hash != episode.home_hash:
                break
        except (JsonError, UconError):
            break
        found.append(episode)
    write_atomic(journal, "".join(canonical_json(episode.to_json()) + "\n" for episode in found))
    return found


def _begin(dataset: HabitDataset | None, task: str, context: bool, even: bool = False) -> None:
    """Make this process's sampler; a worker is sent the dataset once, not with every order."""
    global _sampler
    _sampler = EpisodeSampler(dataset or book(), rules=task_rules(task), context=context, even=even)


_sampler: EpisodeSampler | None = None


def _targets(home: tuple[str, Split | None]) -> tuple[str, ...]:
    """Categories that an episode can place in a home, given as (name, part of its household)."""
    if _sampler is None:
        raise RuntimeError("a worker without a sampler")
    return _sampler.target_categories(*home)


def _sample(order: Order) -> Episode:
    """The episode of an order; up to four seeds are tried."""
    if _sampler is None:
        raise RuntimeError("a worker without a sampler")
    last = ""
    for again in range(4):
        try:
            seed = order.seed + again * RETRY_SEED_STEP
            return _sampler.sample(
                order.scene, seed, targets=order.targets, part=order.part, split=order.split, episode_id=order.id
            )
        except EpisodeError as error:
            last = str(error)
    raise EpisodeError(f"{order.id}: {last}")


def verify_episode(episode: Episode) -> str:
    """Execute an episode's stored solution.

    Returns:
        "" if it succeeds with the stored path length, else what is wrong.
    """
    try:
        house = load_house(episode.scene)
        rules = task_rules(episode.task)
        check_home(episode, house)
    except UconError as error:
        return str(error)
    world = SceneState(house, episode.arrangement)
    eyes = RasterRenderer(fov_deg=rules.fov_deg, counting_fov_deg=rules.fov_deg)
    eyes.load(house, episode.arrangement)
    search = begun_search(episode, world, eyes, rules, RobotRig.exact() if rules.continuous else None)
    if search.target_in_reach():
        return "the target is in reach at the start"
    return _walk(search, episode, rules.max_steps)


def _walk(search: Search, episode: Episode, max_steps: int) -> str:
    """Execute the solution; "" or what is wrong."""
    moved_m, least_m = 0.0, search.metres_to_near(search.target)
    if len(episode.solution) > max_steps:
        return f"the solution has {len(episode.solution)} steps, expected at most {max_steps}"
    for number, digit in enumerate(episode.solution):
        before = search.xy
        outcome = search.step(int(digit))
        moved_m += math.dist(before, search.xy)
        if outcome.collision:
            return f"the solution is blocked at step {number}"
        if outcome.done:
            if not outcome.success:
                return "the solution's Done fails"
            return _wrong_length(moved_m, least_m, episode, search.rules)
    return "the solution does not end in Done"


def _wrong_length(walked_m: float, least_m: float, episode: Episode, rules: TaskRules) -> str:
    """Check the recorded length of the shortest path; "" or what is wrong.

    Args:
        walked_m: length of the solution, which on the grid is a shortest one.
        least_m: straight-line metres from the start to within reach of the target.
        episode: has the recorded length.
        rules: of the episode.
    """
    recorded_m = episode.shortest_path_m
    if not rules.continuous:
        same = abs(walked_m - recorded_m) <= _SAME_M
        return "" if same else f"the solution is {walked_m} m long, recorded {recorded_m} m"
    if not least_m - _SAME_M <= recorded_m <= walked_m + _SAME_M:
        return f"a shortest path of {recorded_m} m, expected {least_m:.3f} to {walked_m:.3f} m"
    return ""
