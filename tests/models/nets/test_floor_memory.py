"""The map memory by hand: what a step writes, the paths, and what poses would show. The agent looks along i."""

from __future__ import annotations

import copy

import numpy as np
import pytest
import torch

from models.nets.end_to_end import memory_kernels, way_kernels
from models.nets.end_to_end.ego_kernels import BLOCKED, EXPLORED, OPAQUE, SEEN_FLOOR
from models.nets.end_to_end.ego_view import ASIDE, BEHIND, COLUMNS, ROWS
from models.nets.end_to_end.floor_memory import (
    BLOCKS,
    HALF,
    N_TRACKS,
    OUTLOOK,
    REACH,
    SIZE,
    TOTALS,
    MemoryStep,
    Outlook,
    State,
    initial_maps,
    kept_counts,
    layers,
    outlook,
    track_belief,
    write,
)
from ucon.perception.views.space_kernels import RAY_AREA, RAY_CELL, RAYS
from ucon.task.actions import Action

#: Categories of these tests: a table, and a cupboard with doors; the last row is for names outside the catalogue.
TABLE, CUPBOARD = 0, 1
BELIEF = torch.tensor([[[0.4, 0.0, 0.1, 0.1], [0.1, 0.3, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0]]])
OPENABLE = torch.tensor([False, True, False])
#: The agent's block.
HERE = REACH // 2


def cell(ahead: int, left: int = 0) -> int:
    """Number of a cell of the patch."""
    return (ahead + BEHIND) * COLUMNS + ASIDE + left


def step(
    *pairs: tuple[int, int, int], pose: tuple[int, int, int] = (0, 0, 0), collision: bool = False, floor: int = 0,
    opened: tuple[int, ...] = (), look: int = 0, target: int = -1, tall: tuple[int, ...] = (),
) -> MemoryStep:  # fmt: skip
    """``pairs``: cell of the patch, track and category seen there; ``floor``: number of rows of floor seen ahead."""
    patch = torch.zeros(1, ROWS, COLUMNS, dtype=torch.uint8)
    looks = torch.zeros(1, ROWS, COLUMNS, dtype=torch.uint8)
    patch[0, BEHIND + 1 : BEHIND + 1 + floor] = EXPLORED | SEEN_FLOOR
    looks[0, BEHIND + 1 : BEHIND + 1 + floor] = look
    for at in tall:
        patch.view(-1)[at] |= EXPLORED | BLOCKED | OPAQUE
    n = max(len(pairs), 1)
    return MemoryStep(
        pose=torch.tensor([[*pose, 0]]),
        collision=torch.tensor([collision]),
        patch=patch,
        look=looks,
        pair_cell=torch.tensor([[at for at, _, _ in pairs] or [-1]], dtype=torch.int16),
        pair_row=torch.arange(n, dtype=torch.int16)[None],
        tracks=torch.tensor([[track for _, track, _ in pairs] or [-1]], dtype=torch.int16),
        ids=torch.tensor([[kind for _, _, kind in pairs] or [-1]], dtype=torch.int16),
        is_target=torch.tensor([[kind == target for _, _, kind in pairs] or [False]]),
        just_opened=torch.tensor([[track in opened for _, track, _ in pairs] or [False]]),
    )


def written(*steps: MemoryStep) -> State:
    state = initial_maps(1, torch.device("cpu"))
    for one in steps:
        write(state, one, BELIEF, OPENABLE)
    return state


def seen_from(state: State, pose: tuple[int, int, int] = (0, 0, 0), reach_m: float = 3.0) -> Outlook:
    mass = track_belief(state, BELIEF, OPENABLE)
    return outlook(state, mass, torch.tensor([[*pose, 0]]), torch.tensor([reach_m]))


def counted(found: Outlook, name: str) -> torch.Tensor:
    return found.counts[0, OUTLOOK.index(name)]


@pytest.mark.parametrize(("heading", "at"), [(0, (3, 0)), (1, (0, 3)), (2, (-3, 0)), (3, (0, -3))])
def test_what_lies_ahead_is_written_where_it_looks(heading: int, at: tuple[int, int]) -> None:
    state = written(step((cell(3), 7, TABLE), pose=(0, 0, heading)))
    assert (state["who"] == 7).nonzero().tolist() == [[0, 0, HALF + at[0], HALF + at[1]]]
    state = written(step((cell(3, 2), 7, TABLE), pose=(0, 0, heading)))
    aside = ((0, 2), (-2, 0), (0, -2), (2, 0))[heading]
    assert (state["who"] == 7).nonzero().tolist() == [[0, 0, HALF + at[0] + aside[0], HALF + at[1] + aside[1]]]


def test_where_it_stands_is_explored_and_counted_by_heading() -> None:
    state = written(step(), step(), step(pose=(0, 0, 3)))
    assert (state["flags"][0] & EXPLORED).nonzero().tolist() == [[HALF, HALF]]
    assert state["visits"][0, :, HALF, HALF].tolist() == [2, 0, 0, 1]
    assert int(state["visits"].sum()) == 3
    often = written(*[step()] * 300)
    assert int(often["visits"][0, 0, HALF, HALF]) == 255, "as much as there is room for"


def test_a_bump_blocks_the_cell_ahead() -> None:
    blocked = written(step(pose=(0, 0, 1), collision=True))["flags"][0] & BLOCKED
    assert blocked.nonzero().tolist() == [[HALF, HALF + 1]]
    assert not (written(step())["flags"] & BLOCKED).any()


def test_a_cell_keeps_the_two_things_with_the_most_belief() -> None:
    other = 2  # a category without belief
    state = written(step((cell(3), 5, other), (cell(3), 6, TABLE)), step((cell(3), 7, CUPBOARD)))
    assert sorted(state["who"][0, :, HALF + 3, HALF].tolist()) == [6, 7]
    assert [int(state["extent"][0, track]) for track in (5, 6, 7)] == [0, 1, 1]
    again = written(step((cell(3), 6, TABLE), (cell(3), 7, CUPBOARD)), step((cell(3), 5, other)))
    assert sorted(again["who"][0, :, HALF + 3, HALF].tolist()) == [6, 7], "a weaker one later changes nothing"
    assert not (written(step((-1, 7, TABLE)))["who"] >= 0).any(), "a pair that is none"


def test_belief_of_a_category_is_divided_among_its_things() -> None:
    one = track_belief(written(step((cell(3), 4, TABLE))), BELIEF, OPENABLE)
    assert one[0, 4].tolist() == pytest.approx([0.4, 0.2, 0.0, 0.0]), "beside and under are one"
    two = track_belief(written(step((cell(3), 4, TABLE), (cell(5), 9, TABLE))), BELIEF, OPENABLE)
    assert two[0, 4].tolist() == two[0, 9].tolist() == pytest.approx([0.2, 0.1, 0.0, 0.0])
    assert float(two.sum()) == pytest.approx(0.6)


def test_what_is_behind_doors_is_so_until_they_are_opened() -> None:
    shut = written(step((cell(3), 4, CUPBOARD)))
    assert track_belief(shut, BELIEF, OPENABLE)[0, 4].tolist() == pytest.approx([0.1, 0.0, 0.0, 0.3])
    open_ = written(step((cell(3), 4, CUPBOARD)), step((cell(3), 4, CUPBOARD), opened=(4,)))
    assert track_belief(open_, BELIEF, OPENABLE)[0, 4].tolist() == pytest.approx([0.1, 0.0, 0.3, 0.0])
    assert (open_["flags"][0] & memory_kernels.OPENED).nonzero().tolist() == [[HALF + 3, HALF]]


def test_ways_by_hand() -> None:
    """A corridor along the second axis (heading 1), while the agent looks along the first."""
    flags = np.full((1, SIZE, SIZE), BLOCKED | EXPLORED, np.uint8)
    flags[0, HALF, HALF : HALF + 4] = EXPLORED
    steps, first, _ = ways(flags, (0, 0, 0))
    assert (steps[0, HERE, HERE], first[0, HERE, HERE]) == (0, way_kernels.STAY)
    assert (steps[1, HERE, HERE + 1], first[1, HERE, HERE + 1]) == (1 + 2, Action.ROTATE_LEFT)
    assert (steps[3, HERE, HERE], first[3, HERE, HERE]) == (1, Action.ROTATE_RIGHT)
    assert steps[0, HERE + 2, HERE + 2] == way_kernels.FAR
    assert (way_kernels.FAR, Action.MOVE_AHEAD, Action.ROTATE_RIGHT, Action.ROTATE_LEFT) == (255, 0, 1, 2)


def ways(flags: np.ndarray, pose: tuple[int, int, int]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    steps, first = (np.zeros((1, 4, BLOCKS, BLOCKS), np.uint8) for _ in range(2))
    which = np.zeros((1, BLOCKS, BLOCKS), np.uint8)
    way_kernels.find_ways(flags, np.array([[*pose, 0]], np.int32), REACH, steps, first, which)
    return steps[0], first[0], which[0]


@pytest.mark.parametrize("heading", [0, 1, 3])
def test_ways_against_plain_search(heading: int) -> None:
    draw = np.random.default_rng(heading)
    flags = np.full((1, SIZE, SIZE), BLOCKED, np.uint8)
    near = slice(HALF - 6, HALF + 7)
    flags[0, near, near] = np.where(draw.random((13, 13)) > 0.3, 0, BLOCKED)
    flags[0, HALF, HALF] = BLOCKED | memory_kernels.VISITED  # it can stand where it stood before
    steps, _, which = ways(flags, (0, 0, heading))
    told = {(HALF, HALF, heading): 0}
    edge = list(told)
    for i, j, h in edge:
        di, dj = ((1, 0), (0, 1), (-1, 0), (0, -1))[h]
        for new in ((i + di, j + dj, h), (i, j, (h + 1) % 4), (i, j, (h + 3) % 4)):
            free = new[:2] == (HALF, HALF) or not flags[0, new[0], new[1]] & BLOCKED
            if new not in told and free:
                told[new] = told[i, j, h] + 1
                edge.append(new)
    assert len(told) > 100
    for a in range(BLOCKS):
        for b in range(BLOCKS):
            i, j = HALF - REACH + 2 * a, HALF - REACH + 2 * b
            cells = [(i + (k >> 1), j + (k & 1)) for k in range(4)]
            each = [sum(told.get((*at, h), way_kernels.FAR) for h in range(4)) for at in cells]
            assert which[a, b] == int(np.argmin(each)), "the cell that is reached soonest stands for its block"
            expected = [told.get((*cells[which[a, b]], h), way_kernels.FAR) for h in range(4)]
            assert steps[:, a, b].tolist() == expected


def test_belief_counts_where_it_shows_until_it_was_looked_at() -> None:
    """Six cells ahead stands a table; nothing is known behind it."""
    state = written(step((cell(6), 4, TABLE), floor=8))
    found = seen_from(state)
    assert counted(found, "on")[:, HERE, HERE].tolist() == pytest.approx([0.4, 0.0, 0.0, 0.0]), "ahead alone"
    assert counted(found, "beside")[0, HERE, HERE] == pytest.approx(0.2)
    assert counted(found, "on")[2, HERE + 4, HERE] == pytest.approx(0.4), "from the other side by looking back"
    assert counted(seen_from(state, reach_m=1.2), "on")[0, HERE, HERE] == 0, "too far away to see the target"
    looked = seen_from(written(step((cell(6), 4, TABLE), floor=8, look=255)))
    assert counted(looked, "on")[0, HERE, HERE] == 0
    assert counted(looked, "used")[0, HERE, HERE] == pytest.approx(0.6)


def test_a_thing_of_many_cells_counts_once() -> None:
    wide = [(cell(6, left), 4, TABLE) for left in (-1, 0, 1)]
    found = counted(seen_from(written(step(*wide, floor=8))), "on")
    assert found[0, HERE, HERE] == pytest.approx(0.4)


def test_what_is_tall_hides_what_is_behind() -> None:
    wall = tuple(cell(3, left) for left in range(-12, 13))
    hidden = seen_from(written(step((cell(6), 4, TABLE), floor=8, tall=wall)))
    assert counted(hidden, "on")[0, HERE, HERE] == 0
    assert counted(hidden, "on")[2, HERE + 4, HERE] == pytest.approx(0.4), "but not from behind"


def test_doors_count_within_reach() -> None:
    state = written(step((cell(3), 4, CUPBOARD), (cell(4), 4, CUPBOARD), floor=8))
    found = counted(seen_from(state), "closed")
    assert found[0, HERE, HERE] == pytest.approx(0.3), "once, however many cells it has"
    assert found[2, HERE, HERE] == 0
    assert found[0, HERE - 2, HERE] == 0, "seven cells away"


def one_by_one(  # noqa: C901 (the definition, cell by cell)
    maps: dict[str, np.ndarray], share: np.ndarray, at: tuple[int, int], sight: int, enough: int
) -> np.ndarray:
    """Counts of a node by heading, (8, 4), reading every cell of every ray separately."""
    out = np.zeros((8, 4))
    for h in range(4):
        cells, containers, best = set(), set(), 0.0
        for ray in range(RAYS):
            if ((ray + RAYS // 8) % RAYS) // (RAYS // 4) != h:
                continue
            trust, deep = 1.0, 0
            for k in range(22):
                i, j = (int(c) for c in np.array(at) + RAY_CELL[ray, k])
                within = 0 <= i < SIZE and 0 <= j < SIZE
                bits = int(maps["flags"][i, j]) if within else 0
                if not bits & EXPLORED:
                    if not bits & OPAQUE:
                        out[5, h] += RAY_AREA[ray, k] * trust
                        trust, deep = trust * 0.8825, deep + 1
                elif (i, j) not in cells:
                    cells.add((i, j))
                    fresh = maps["look"][i, j] < enough
                    out[6, h] += 0.0625 * (k < sight and fresh)
                    for track in maps["who"][:, i, j]:
                        if track < 0:
                            continue
                        if k < sight and fresh:
                            out[:3, h] += share[track, :3]
                        elif k < sight:
                            out[3, h] += share[track, :3].sum()
                        if k < 4 and track not in containers:
                            containers.add(track)
                            out[4, h] += share[track, 3] * maps["extent"][track]
                    if bits & memory_kernels.TARGET:
                        best = max(best, 1.0 if k < 4 else 2.0 / (k + 1))
                if bits & OPAQUE:
                    for beyond in range(k + 1, min(k + 3, 22)):
                        i, j = (int(c) for c in np.array(at) + RAY_CELL[ray, beyond])
                        within = 0 <= i < SIZE and 0 <= j < SIZE
                        if within and maps["flags"][i, j] & memory_kernels.TARGET:
                            best = max(best, 1.0 if beyond < 4 else 2.0 / (beyond + 1))
                            break
                if bits & OPAQUE or deep >= 12:
                    break
        out[7, h] = best
    return out


@pytest.mark.parametrize("reach_m", [1.0, 3.0, 5.0])
@pytest.mark.parametrize("pose", [(0, 0), (HALF - 2, 3), (-HALF + 1, -HALF + 3), (40, HALF - 4)], ids=str)
def test_poses_show_what_the_definition_says(pose: tuple[int, int], reach_m: float) -> None:
    """Random maps, also at their edges, with so many poses that the marks of counted cells wrap around."""
    draw = np.random.default_rng(5)
    bits = np.array([0, EXPLORED, EXPLORED, EXPLORED, EXPLORED | OPAQUE, OPAQUE], np.uint8)
    maps = {
        "flags": draw.choice(bits, (SIZE, SIZE), p=(0.2, 0.25, 0.25, 0.2, 0.05, 0.05))
        | np.uint8(memory_kernels.TARGET) * (draw.random((SIZE, SIZE)) < 0.02),
        "look": draw.integers(0, 256, (SIZE, SIZE)).astype(np.uint8),
        "who": np.where(draw.random((2, SIZE, SIZE)) < 0.2, draw.integers(0, 40, (2, SIZE, SIZE)), -1).astype(np.int16),
        "extent": np.zeros(N_TRACKS, np.int32),
    }
    maps["extent"][:40] = draw.integers(1, 30, 40)
    batch = 20  # copies of one map: 20 * 4 * about 1,600 marks
    state = initial_maps(batch, torch.device("cpu"))
    for name, values in maps.items():
        state[name][:] = torch.from_numpy(values)
    mass = torch.from_numpy(draw.random((1, N_TRACKS, 4), np.float32)).expand(batch, -1, -1)
    at = torch.tensor([[*pose, 0, 0]]).expand(batch, -1)
    found = outlook(state, mass, at, torch.full((batch,), reach_m))
    assert torch.equal(found.counts[0], found.counts[-1])
    share = (mass[0] / state["extent"][0].clamp(min=1)[:, None]).numpy()
    there = (found.steps[0, 0] != way_kernels.FAR).nonzero().tolist()
    checked = 0
    for a, c in (there[int(k)] for k in draw.choice(len(there), 30, replace=False)):
        which = int(found.cell[0, a, c])
        i, j = (pose[n] + HALF - REACH + 2 * block + bit for n, block, bit in ((0, a, which >> 1), (1, c, which & 1)))
        around = [
            maps["flags"][u, v]
            for u, v in ((i, j), (i - 1, j), (i + 1, j), (i, j - 1), (i, j + 1))
            if 0 < i < SIZE - 1 and 0 < j < SIZE - 1
        ]
        if not any(int(flag) & EXPLORED for flag in around):
            continue
        wanted = one_by_one(maps, share, (i, j), int(reach_m * 4), int(255 * np.exp(-reach_m / 2)))
        assert found.counts[0, :8, :, a, c].numpy() == pytest.approx(wanted, rel=1e-4, abs=1e-5)
        checked += 1
    assert checked > 5


def test_what_is_kept_changes_nothing_whatever_maps_come_next() -> None:
    draw = np.random.default_rng(7)
    state, kept = initial_maps(2, torch.device("cpu")), kept_counts()
    mass = torch.zeros(2, N_TRACKS, 4)
    used = 0
    for turn in range(40):
        where = draw.integers(HALF - 30, HALF + 30, (2, 3, 2))
        for b, cells in enumerate(where):  # a few cells of each map
            for i, j in cells:
                state["flags"][b, i, j] = int(
                    draw.choice([EXPLORED, EXPLORED | OPAQUE, EXPLORED | memory_kernels.TARGET])
                )
                state["look"][b, i, j] = int(draw.integers(256))
                state["who"][b, int(draw.integers(2)), i, j] = int(draw.integers(-1, 9))
        if turn % 4 == 0:
            mass[:, int(draw.integers(9))] = torch.from_numpy(draw.random(4, np.float32))
            state["extent"][:, :9] = torch.from_numpy(draw.integers(1, 20, 9).astype(np.int32))
        if turn == 20:  # the rows get each other's episodes
            state, mass = {name: tensor.flip(0) for name, tensor in state.items()}, mass.flip(0)
        pose = torch.tensor([[turn // 3 - 8, 2, turn % 4, 0], [5, -turn, 1, 0]])
        reach = torch.tensor([3.0, 3.0 if turn < 30 else 2.0])
        before = [one.copy() for one in kept.of(2)[:2]] if turn else None
        found = outlook(state, mass, pose, reach, kept=kept)
        assert torch.equal(found.counts, outlook(state, mass, pose, reach).counts), turn
        used += before is not None and bool((before[0] & kept.of(2)[0]).any())
    assert used > 30
    pose, reach = torch.tensor([[0, 0, 0, 0]] * 2), torch.full((2,), 3.0)
    outlook(state, mass, pose, reach, kept=kept)
    kept.of(2)[1][:] = 7.0
    again = outlook(state, mass, pose, reach, kept=kept)
    assert set(again.counts[:, 0].unique().tolist()) == {0.0, 7.0}, "what is kept is what is told"
    copied = copy.deepcopy(kept)
    assert not copied.of(2)[0].any()
    kind, given = kept.__reduce__()  # as when it is sent to workers
    assert not kind(*given).of(1)[0].any()


def test_a_pose_that_it_was_in_for_long_shows_nothing_more() -> None:
    state = written(*[step((cell(3), 4, CUPBOARD), floor=8)] * 8)
    mass, at = track_belief(state, BELIEF, OPENABLE), (torch.tensor([[0, 0, 0, 0]]), torch.tensor([3.0]))
    patient, impatient = outlook(state, mass, *at, patience=9), outlook(state, mass, *at, patience=8)
    here = (OUTLOOK.index("closed"), 0, HERE, HERE)
    assert float(patient.counts[0][here]) > 0
    assert torch.equal(patient.counts, outlook(state, mass, *at).counts)
    lost = (patient.counts != impatient.counts)[0].nonzero()
    assert set(lost[:, 1].tolist()) == {0}, "only where it looked"
    assert {(a, c) for _, _, a, c in lost.tolist()} == {here[2:]}
    assert float(impatient.counts[0][here]) == 0
    assert torch.equal(counted(patient, "been"), counted(impatient, "been"))


def test_space_beyond_what_is_explored() -> None:
    found = counted(seen_from(written(step(floor=8))), "space")
    assert found[0, HERE + 3, HERE] > 1.0
    blank = counted(seen_from(written(step(floor=8, tall=tuple(cell(8, k) for k in range(-40, 41))))), "space")
    assert blank[0, HERE + 3, HERE] < 0.5 * found[0, HERE + 3, HERE]


def test_a_target_in_a_shelf_shows_from_in_front() -> None:
    """It shows through the tall front of the shelf, but not if it lies deeper than a shelf."""
    front = tuple(cell(5, left) for left in range(-2, 3))
    shelf = seen_from(written(step((cell(6), 4, TABLE), floor=8, target=TABLE, tall=front)))
    assert counted(shelf, "target")[0, HERE + 1, HERE] == 1.0
    deeper = seen_from(written(step((cell(8), 4, TABLE), floor=8, target=TABLE, tall=front)))
    assert not counted(deeper, "target")[0, : HERE + 2, HERE].any()


def test_the_target_and_where_it_was() -> None:
    state = written(step((cell(6), 4, TABLE), floor=8, target=TABLE), step(pose=(0, 0, 0)))
    found = seen_from(state)
    target = counted(found, "target")
    assert target[0, HERE + 1, HERE] == 1.0
    assert 0 < target[0, HERE, HERE] < 1.0
    assert target[2, HERE, HERE] == 0.0
    assert counted(found, "been")[:, HERE, HERE].tolist() == [0.5, 0, 0, 0]
    assert counted(found, "around")[:, HERE, HERE].tolist() == [0.5] * 4


def test_sums_over_the_map() -> None:
    state = written(step((cell(6), 4, TABLE), floor=2))
    found = dict(zip(TOTALS, seen_from(state).totals[0].tolist(), strict=True))
    assert found["explored"] == pytest.approx((2 * COLUMNS + 1) / 16)
    assert found["thin"] == found["explored"], "nothing was seen closely"
    assert found["fresh"] == 0, "the table's cell is not explored"
    known = dict(zip(TOTALS, seen_from(written(step((cell(2), 4, TABLE), floor=2))).totals[0].tolist(), strict=True))
    assert known["fresh"] == pytest.approx(0.6)


def test_at_the_edge_of_the_map_nothing_is_written_beyond_it() -> None:
    far = HALF - 2
    state = written(step((cell(6), 4, TABLE), floor=8, pose=(far, far, 0), collision=True))
    assert not (state["who"] >= 0).any()
    found = seen_from(state, (far, far, 0))
    assert torch.isfinite(found.counts).all()
    assert written(step(pose=(10 * SIZE, 0, 0)))["visits"].sum() == 1, "farther off it stands at the edge"


def test_tracks_beyond_the_table_are_left_out() -> None:
    state = written(step((cell(3), N_TRACKS, TABLE)))
    assert not (state["who"] >= 0).any()
    assert not (state["kind"] >= 0).any()


def test_layers_for_drawing() -> None:
    state = written(step((cell(3), 4, TABLE), (cell(5), 9, CUPBOARD), floor=8))
    drawn = layers(state, track_belief(state, BELIEF, OPENABLE))
    assert drawn["most"].max() == drawn["most"][HALF + 3, HALF] == 255
    assert drawn["most"][HALF + 5, HALF] == int(255 * np.sqrt(0.4 / 0.6))
    assert drawn["visited"].nonzero()[0].tolist() == [HALF]
