"""Where the untrained policy goes: towards the poses with the highest worth, by the shortest path."""

from __future__ import annotations

import math

import pytest
import torch

from models.nets.end_to_end.floor_memory import BLOCKS, OUTLOOK, REACH, TOTALS, Outlook
from models.nets.end_to_end.places_to_go import PlacesToGo, Ways, aimed_at, divergence
from models.nets.end_to_end.way_kernels import FAR
from tests.models.nets.test_floor_memory import HERE, step, ways, written

NOWHERE = torch.full((1, 3), -1)


def outlook_of(counts: dict[tuple[str, int, int, int], float], heading: int = 0, reach: int = BLOCKS) -> Outlook:
    """Free floor within ``reach`` blocks, with counts by name, heading, and block relative to the agent's."""
    steps, first, cell = (torch.from_numpy(part) for part in ways(written(step())["flags"].numpy(), (0, 0, heading)))
    steps = steps.clone()
    a = torch.arange(BLOCKS) - HERE
    steps[:, (a.abs()[:, None] > reach) | (a.abs()[None] > reach)] = FAR
    found = torch.zeros(1, len(OUTLOOK), 4, BLOCKS, BLOCKS)
    for (name, h, i, j), value in counts.items():
        found[0, OUTLOOK.index(name), h, HERE + i, HERE + j] = value
    return Outlook(found, steps[None], first[None], cell[None], torch.zeros(1, len(TOTALS)), torch.zeros(1, 8))


def go(seen: Outlook, heading: int = 0, aim: torch.Tensor = NOWHERE) -> Ways:
    with torch.no_grad(), torch.random.fork_rng():
        torch.manual_seed(0)
        places = PlacesToGo(3, sharpness=3.0)
        return places(seen, torch.zeros(1, 1, 3), aim, torch.tensor([[[0, 0, heading, 0]]]))


@pytest.mark.parametrize(
    ("at", "action"), [((0, 4, 0), 0), ((1, 0, 4), 2), ((3, 0, -4), 1)], ids=["ahead", "left", "right"]
)
def test_it_goes_to_what_is_worth_it(at: tuple[int, int, int], action: int) -> None:
    found = go(outlook_of({("target", *at): 1.0}))
    assert int(found.log_p[0, 0].argmax()) == action
    assert float(found.log_p[0, 0].exp().sum()) == pytest.approx(1.0, abs=1e-4)
    h, i, j = at
    assert int(found.log_goal[0, 0].argmax()) == (h * BLOCKS + HERE + i) * BLOCKS + HERE + j


def test_poses_that_show_nothing_are_scored_as_all_others() -> None:
    draw, places = torch.Generator().manual_seed(3), PlacesToGo(3, sharpness=3.0)
    shown = torch.rand(1, len(OUTLOOK), 4, BLOCKS, BLOCKS, generator=draw)
    seen = outlook_of({}, reach=9)._replace(counts=shown * (torch.rand(1, 1, 4, BLOCKS, BLOCKS, generator=draw) < 0.2))
    given = torch.randn(1, 3, generator=draw)
    counts, steps = seen.counts[0].flatten(1).T, seen.steps[0].flatten()
    one_by_one = places._score_of(counts, steps.float(), given, torch.zeros(len(steps), dtype=torch.long))
    wanted = torch.where(steps != FAR, one_by_one, -1e4)
    found = places._scores(seen, given)[0]
    assert 0 < int((counts == 0).all(1).sum()) < len(steps)
    assert torch.allclose(found, wanted, rtol=1e-5, atol=1e-5)
    for one in (found, wanted):
        places.zero_grad()
        one.clamp(min=-30).square().sum().backward(retain_graph=True)
        one.grads = [weight.grad.clone() for weight in places.parameters() if weight.grad is not None]
    assert all(torch.allclose(a, b, rtol=1e-4, atol=1e-3) for a, b in zip(found.grads, wanted.grads, strict=True))


def test_the_nearer_of_two_alike_is_better() -> None:
    found = go(outlook_of({("on", 0, 2, 0): 0.5, ("on", 1, 0, 8): 0.5}))
    assert int(found.log_p[0, 0].argmax()) == 0


def test_headings_are_alike() -> None:
    """The same thing on the same side gives the same choice, whatever the agent's heading on the map."""
    first = go(outlook_of({("closed", 0, 6, 0): 0.5})).log_p
    for heading, (i, j) in ((1, (0, 6)), (2, (-6, 0)), (3, (0, -6))):
        found = go(outlook_of({("closed", heading, i, j): 0.5}, heading), heading)
        assert found.log_p == pytest.approx(first, abs=0.1), "blocks are of two cells: half a step is lost"


def test_where_there_is_no_way_it_does_not_go() -> None:
    found = go(outlook_of({("target", 0, 4, 0): 1.0}, reach=2))
    assert float(found.log_goal[0, 0, 0, HERE + 4, HERE]) < -1000


def test_where_it_was_is_worth_less() -> None:
    plain = {("on", 0, 2, 0): 0.5, ("on", 1, 0, 2): 0.5}
    fresh, stale = go(outlook_of(plain)), go(outlook_of({**plain, ("been", 0, 2, 0): 4.0}))
    assert float(stale.log_p[0, 0, 0]) < float(fresh.log_p[0, 0, 0]) - 1


def test_it_is_loyal_to_where_it_is_going() -> None:
    """Of two nearly equal places, the one chosen before stays chosen; an aim outside the window changes nothing."""
    two = {("on", 0, 3, 0): 0.50, ("on", 0, 3, 2): 0.98}
    seen = outlook_of(two)
    a, b = (torch.tensor([[2 * i, 2 * j, 0]]) for i, j in ((3, 0), (3, 2)))
    kept = [go(seen, aim=aim).aim for aim in (a, b)]
    assert not torch.equal(*kept)
    gain = go(seen, aim=a).log_goal - go(seen).log_goal
    odds = float(gain[0, 0, 0, HERE + 3, HERE] - gain[0, 0, 0, HERE + 3, HERE + 2])
    assert odds == pytest.approx(3.0 * math.log(1.25), abs=1e-4)
    away = go(seen, aim=torch.tensor([[200, 200, 0]]))
    assert torch.equal(away.log_goal, go(seen).log_goal), "out of the window"


def test_the_aim_is_in_the_frame_of_the_start() -> None:
    cell = torch.zeros(1, BLOCKS, BLOCKS, dtype=torch.uint8)
    cell[0, HERE + 3, HERE - 2] = 2  # second row, first column
    flat = torch.zeros(1, 4 * BLOCKS * BLOCKS)
    flat[0, (3 * BLOCKS + HERE + 3) * BLOCKS + HERE - 2] = 1.0
    assert aimed_at(flat, torch.tensor([[10, -20, 1, 0]]), cell).tolist() == [[10 + 6 + 1, -20 - 4, 3]]


def label(*views: tuple[int, int, int, int]) -> torch.Tensor:
    out = torch.zeros(1, 8, 4, dtype=torch.int16)
    for k, view in enumerate(views):
        out[0, k] = torch.tensor(view, dtype=torch.int16)
    return out


@pytest.mark.parametrize("heading", range(4))
def test_divergence_from_an_expert_that_likes_one_view(heading: int) -> None:
    """The policy's probability of the pose six cells ahead and two to the left, turned left once."""
    log_goal = torch.log_softmax(torch.randn(1, 4 * BLOCKS * BLOCKS), 1).view(1, 4, BLOCKS, BLOCKS)
    i, j = ((3, 1), (-1, 3), (-3, -1), (1, -3))[heading]
    told = divergence(log_goal, label((6, 2, 1, 10_000)), torch.tensor([[5, 7, heading, 0]]), 3.0)
    expected = -log_goal[0, (heading + 1) % 4, HERE + i, HERE + j]
    assert float(told[0]) == pytest.approx(float(expected), abs=1e-5)


def test_divergence_of_equal_minds_is_nothing() -> None:
    weight = torch.tensor([1.0, 0.5]) ** 3
    p = torch.full((1, 4, BLOCKS, BLOCKS), 1e-12)
    p[0, 0, HERE + 1, HERE], p[0, 0, HERE, HERE + 2] = (weight / weight.sum()).tolist()
    views = label((2, 0, 0, 10_000), (0, 4, 0, 5_000), (1, 4, 0, 4_000))
    assert float(divergence(p.log(), views, torch.zeros(1, 4), 3.0)) == pytest.approx(0.0, abs=1e-4), (
        "views of one block count once, by the best"
    )


def test_nothing_is_learned_where_the_expert_says_nothing() -> None:
    log_goal = torch.randn(1, 4, BLOCKS, BLOCKS, requires_grad=True)
    for nothing in (label(), label((2 * REACH, 0, 0, 10_000))):
        told = divergence(log_goal, nothing, torch.zeros(1, 4), 3.0)
        assert float(told.detach()) == 0.0
        assert not torch.autograd.grad(told.sum(), log_goal)[0].any()
