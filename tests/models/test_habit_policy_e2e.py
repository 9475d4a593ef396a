"""The end-to-end habit policy: shapes, memory, habits, limits."""

from __future__ import annotations

import time

import numpy as np
import pytest
import torch

from models import habit_policy_e2e
from models.habit_policy_e2e import HabitPolicyE2E, bent_on
from models.nets.belief.head_reader import default_head_reader
from models.nets.end_to_end.ego_kernels import BLOCKED, EXPLORED, SEEN_FLOOR
from models.nets.end_to_end.ego_view import ASIDE, BEHIND, N_PAIRS, N_THINGS
from models.nets.end_to_end.floor_memory import HALF, OUTLOOK, outlook, track_belief
from models.nets.end_to_end.memory_kernels import VISITED
from models.nets.end_to_end.reasons import reasons
from ucon.core.errors import ConfigError
from ucon.envs.ucon_env import UcONEnv
from ucon.perception.mapping.semantic_map import SemanticMap
from ucon.task.actions import Action
from ucon.task.sets import load_episodes

LEVELS = ("none", "full", "gt", "retrieval")
WALK = (0, 0, 2, 0, 0, 4, 1, 0, 0, 3, 1, 0, 0, 5, 0, 1)


@pytest.fixture(scope="module")
def policy() -> HabitPolicyE2E:
    return random_policy()


def random_policy(**options) -> HabitPolicyE2E:
    """A policy as if trained a little, since the last layer starts at zero."""
    made = HabitPolicyE2E(**options).eval()
    with torch.no_grad(), torch.random.fork_rng():
        torch.manual_seed(0)
        torch.nn.init.normal_(made.choose[-1].weight, std=0.1)
    return made


@pytest.fixture(scope="module")
def walks() -> dict[str, tuple[dict, list[tuple[dict, dict]]]]:
    """Info at reset and (observation, info) of each step, at each level."""
    out = {}
    for level in LEVELS:
        env = UcONEnv("mini", habit_level=level, detector=True)
        obs, first = env.reset(options={"episode": 1})
        steps = [(obs, first)]
        for action in WALK:
            obs, _, _, _, info = env.step(action)
            steps.append((obs, info))
        env.close()
        out[level] = (first, steps)
    return out


def tensors(arrays) -> dict[str, torch.Tensor]:
    return {name: torch.as_tensor(np.array(array)) for name, array in arrays.items()}


def episode(policy, walk) -> tuple[dict[str, torch.Tensor], dict[str, torch.Tensor]]:
    """Frames (T, 1, ...) and context (1, ...)."""
    frames = [tensors(policy.frame(o, i)) for o, i in walk[1]]
    stacked = {name: torch.stack([f[name] for f in frames])[:, None] for name in frames[0]}
    return stacked, {name: t[None] for name, t in tensors(policy.context(walk[0])).items()}


@pytest.mark.parametrize("level", LEVELS)
def test_every_level_gives_logits_and_the_same_shapes(policy, walks, level):
    frames, context = episode(policy, walks[level])
    reference = episode(policy, walks["none"])
    assert {k: v.shape for k, v in frames.items()} == {k: v.shape for k, v in reference[0].items()}
    assert {k: (v.shape, v.dtype) for k, v in context.items()} == {
        k: (v.shape, v.dtype) for k, v in reference[1].items()
    }
    out = policy(frames, context, policy.initial_state(1))
    assert out.logits.shape == (len(WALK) + 1, 1, 7)
    assert out.value.shape == (len(WALK) + 1, 1)
    assert torch.isfinite(out.logits).all()


def test_done_is_held_back_until_the_target_is_near(policy):
    """Along a stored solution it is held back wherever the target is not in view, and not at the end."""
    episode_ = load_episodes("mini")[1]
    env = UcONEnv([episode_], habit_level="none", detector=True)
    obs, first = env.reset(options={"episode": episode_})
    steps, in_view = [(obs, first)], [episode_.target_category in first["detections"].category]
    for action in map(int, episode_.solution[:-1]):
        obs, _, _, _, info = env.step(action)
        steps.append((obs, info))
        in_view.append(episode_.target_category in info["detections"].category)
    frames, context = episode(policy, (first, steps))
    with torch.no_grad():
        done = policy(frames, context, policy.initial_state(1)).logits[:, 0, Action.DONE]
    held = (done < -5).tolist()
    assert not held[-1]
    assert all(held[t] for t, seen in enumerate(in_view) if not seen)
    assert 0 < sum(in_view) < len(in_view)


def test_done_where_the_target_is_not_near_cannot_be_learned(policy, walks):
    """Solutions that end a little too far away must not teach to stop anywhere: no gradient, and constant odds."""
    frames, context = episode(policy, walks["gt"])
    logits = policy(frames, context, policy.initial_state(1)).logits
    held = logits[..., Action.DONE] < logits[..., : Action.DONE].logsumexp(-1) - 14
    assert held.any()
    loss = -logits.log_softmax(-1)[held][:, Action.DONE]
    assert torch.allclose(loss, torch.full_like(loss, 15.0), atol=1e-3)
    gradients = torch.autograd.grad(loss.sum(), list(policy.parameters()), allow_unused=True)
    assert all(g is None or g.abs().max() < 1e-3 for g in gradients)


def test_frames_do_not_depend_on_the_habits(policy, walks):
    ours, others = (episode(policy, walks[level])[0] for level in ("none", "gt"))
    assert all(torch.equal(ours[name], others[name]) for name in ours)


def test_t_steps_are_t_single_steps(policy, walks):
    frames, context = episode(policy, walks["retrieval"])
    with torch.no_grad():
        whole = policy(frames, context, policy.initial_state(1))
        state, logits = policy.initial_state(1), []
        for t in range(len(frames["pose"])):
            out = policy({name: frame[t : t + 1] for name, frame in frames.items()}, context, state)
            state = out.state
            logits.append(out.logits)
    assert torch.allclose(torch.cat(logits), whole.logits, atol=1e-4)
    assert state.keys() == whole.state.keys() == policy.initial_state(1).keys()
    exact = [name for name, tensor in state.items() if not tensor.is_floating_point()]
    assert {*exact} >= {"flags", "look", "visits", "who", "kind", "extent", "opened", "aim"}
    assert all(torch.equal(state[name], whole.state[name]) for name in exact)


def test_a_batch_is_its_parts_and_leaves_the_given_state_alone(policy, walks):
    parts = [episode(policy, walks[level]) for level in ("none", "gt")]
    frames = {name: torch.cat([p[0][name] for p in parts], 1) for name in parts[0][0]}
    context = {name: torch.cat([p[1][name] for p in parts]) for name in parts[0][1]}
    state = policy.initial_state(2)
    with torch.no_grad():
        both = policy(frames, context, state).logits
        alone = torch.cat([policy(*part, policy.initial_state(1)).logits for part in parts], 1)
    assert torch.allclose(both, alone, atol=1e-4)
    assert all(torch.equal(tensor, policy.initial_state(2)[name]) for name, tensor in state.items())


def test_memory_matters(policy, walks):
    frames, context = episode(policy, walks["gt"])
    last = {name: frame[-1:] for name, frame in frames.items()}
    with torch.no_grad():
        kept = policy({name: frame[:-1] for name, frame in frames.items()}, context, policy.initial_state(1)).state
        assert not torch.allclose(
            policy(last, context, kept).logits, policy(last, context, policy.initial_state(1)).logits, atol=1e-3
        )


def test_habits_change_what_it_does(policy, walks):
    with torch.no_grad():
        logits = {k: policy(*episode(policy, walks[k]), policy.initial_state(1)).logits for k in LEVELS}
    assert float((logits["none"] - logits["retrieval"]).abs().max()) > 1e-3
    assert float((logits["gt"] - logits["full"]).abs().max()) > 1e-3


@pytest.mark.parametrize("level", ["full", "gt"])
def test_the_order_of_habits_does_not(policy, walks, level):
    first, steps = walks[level]
    mixed = {**first, "habits": tuple(np.random.default_rng(0).permutation(first["habits"]).tolist())}
    ours, others = (tensors(policy.context(info)) for info in (first, mixed))
    for name in ours:
        assert torch.allclose(ours[name].float(), others[name].float(), atol=2e-3), name
    assert len(steps) == len(WALK) + 1


def test_gradients_reach_every_parameter(walks):
    torch.manual_seed(0)
    policy = HabitPolicyE2E()
    torch.nn.init.normal_(policy.choose[-1].weight, std=0.1)
    frames, context = episode(policy, walks["retrieval"])
    out = policy(frames, context, policy.initial_state(1))
    (torch.logsumexp(out.logits * torch.arange(7), -1).sum() + out.value.square().sum()).backward()
    missing = [n for n, p in policy.named_parameters() if p.grad is None or not bool(p.grad.abs().sum() > 0)]
    assert not missing


@pytest.mark.timed
def test_it_is_small_and_fast(policy, walks):
    assert sum(p.numel() for p in policy.parameters()) <= 8_000_000
    frames, context = episode(policy, walks["full"])
    state, spent = policy.initial_state(1), []
    with torch.inference_mode():
        for t, (obs, info) in enumerate(walks["full"][1]):
            start = time.process_time()
            policy.frame(obs, info)
            state = policy({n: f[t : t + 1] for n, f in frames.items()}, context, state).state
            spent.append(time.process_time() - start)
    assert float(np.median(spent)) <= 0.030


@pytest.mark.parametrize("given", [True, False])
@pytest.mark.parametrize("switch", ["rgb", "plan", "attend"])
def test_what_an_ablation_takes_away_matters_no_more(walks, switch, given):
    policy = random_policy(**{switch: given})
    assert policy.arguments[switch] is given
    frames, context = episode(policy, walks["gt"])
    with torch.no_grad():
        before = policy(frames, context, policy.initial_state(1)).logits
        if switch == "rgb":
            frames["image"] = 255 - frames["image"]
        elif switch == "plan":
            policy.places.overhead += 1.0
        else:
            told = {**walks["gt"][0], "habits": tuple(reversed(walks["none"][0]["habits"] or ("Nothing is said.",)))}
            other = {name: t[None] for name, t in tensors(policy.context(told)).items()}
            context["habit_features"] = other["habit_features"]
        after = policy(frames, context, policy.initial_state(1)).logits
    assert torch.isfinite(before).all()
    assert torch.equal(before, after) is not given


def test_without_the_head_the_fitted_reader_reads(walks):
    ours, fitted = HabitPolicyE2E(), HabitPolicyE2E(head=False)
    assert ours.fingerprint() != fitted.fingerprint()
    beliefs = [policy.context(walks["gt"][0])["belief"] for policy in (ours, fitted)]
    assert not np.array_equal(*beliefs)


def test_what_is_covered_is_not_in_view(policy, walks):
    """Box detectors list tracks whose pixels are all covered by others; these have no place and are left out."""
    obs, info = walks["none"][1][0]
    found = info["detections"]
    covered = int(found.track.max()) + 1
    listed = {
        "track": np.append(found.track, covered),
        "category": [*found.category, info["target"]],
        "pixels": np.append(found.pixels, 50),
    }
    before, after = (policy.frame(obs, {**info, "detections": d}) for d in (found, listed))
    assert all(np.array_equal(before[name], after[name]) for name in before)


@pytest.mark.parametrize(
    ("image_px", "said"), [(60, "multiple of 16"), (0, "multiple of 16"), (256, "128 x 128 pixels")]
)
def test_sizes_that_do_not_fit_are_named(walks, image_px, said):
    with pytest.raises(ConfigError, match=rf"agent\.policy\.image_px={image_px}: .*{said}"):
        HabitPolicyE2E(image_px=image_px).frame(*walks["none"][1][0])


def test_needs_pixels(policy, walks):
    obs, info = walks["none"][1][0]
    with pytest.raises(ConfigError, match=r"env\.observe=pixels"):
        policy.frame({k: v for k, v in obs.items() if k != "rgb"}, info)


def test_memory_agrees_with_the_semantic_map(policy, walks):
    """Two independent implementations put the same frames into a map."""
    frames, context = episode(policy, walks["none"])
    state = policy(frames, context, policy.initial_state(1)).state
    flags = state["flags"][0].numpy()
    known = SemanticMap()
    for obs, info in walks["none"][1]:
        known.update(obs, info)
    near = slice(HALF - 15, HALF + 16)
    for bit, truth in ((SEEN_FLOOR, known.floor), (EXPLORED, known.explored), (BLOCKED, known.blocked)):
        ours, theirs = flags[near, near] & bit > 0, truth[near, near] > 0
        agree = (ours & theirs).sum() / max((ours | theirs).sum(), 1)
        assert agree > 0.95, (bit, agree)
    assert np.array_equal(flags & VISITED > 0, known.visited > 0)


def test_patch_is_the_frame_alone(policy, walks):
    obs, info = walks["none"][1][3]
    frame = policy.frame(obs, info)
    again = policy.frame(obs, info)
    assert all(np.array_equal(frame[name], again[name]) for name in frame)
    flags = frame["patch"]
    assert flags[BEHIND + 2, ASIDE] & (EXPLORED | SEEN_FLOOR | BLOCKED)
    assert frame["thing_ids"].shape == (N_THINGS,)
    assert frame["pair_cell"].shape == (N_PAIRS,)
    assert sum(array.nbytes for array in frame.values()) < 25_000


def test_it_does_not_matter_how_far_it_has_come(policy, walks):
    """25 m from the start the map's edge cuts off the window, but the agent is still in its centre."""
    frames, context = episode(policy, walks["gt"])
    shifted = {name: tensor.clone() for name, tensor in frames.items()}
    shifted["pose"][..., 0] += 100
    shifted["pose"][..., 1] -= 100
    (here, inside), (there, inside_there) = (
        policy.think(f, context, policy.initial_state(1)) for f in (frames, shifted)
    )
    assert torch.equal(here.logits, there.logits)
    assert torch.equal(inside.ways.log_goal, inside_there.ways.log_goal)


def test_augmentation_turns_the_map_and_nothing_else(policy, walks):
    frames, context = episode(policy, walks["gt"])
    seen = set()
    for seed in range(8):
        turned = policy.augment(frames, torch.Generator().manual_seed(seed))
        assert all(torch.equal(turned[name], frames[name]) for name in frames if name != "pose")
        quarters = int(turned["pose"][0, 0, 2] - frames["pose"][0, 0, 2]) % 4
        seen.add(quarters)
        ours, plain = (policy(f, context, policy.initial_state(1)).state["flags"] for f in (turned, frames))
        assert torch.equal(ours, torch.rot90(plain, quarters, (1, 2)))
    assert len(seen) > 1


def test_initial_weights_do_not_depend_on_what_was_loaded_before():
    """The belief head is loaded once per process, and loading it draws random numbers."""
    default_head_reader.cache_clear()
    first, second = HabitPolicyE2E().state_dict(), HabitPolicyE2E().state_dict()
    assert all(torch.equal(first[name], second[name]) for name in first)


def test_what_an_expert_thinks_of_views_is_told_in_nats(policy, walks):
    frames, context = episode(policy, walks["gt"])
    assert policy(frames, context, policy.initial_state(1)).views is None
    views = torch.zeros(len(WALK) + 1, 1, 4, 4, dtype=torch.int16)
    views[3, 0, 0] = torch.tensor([0, 0, 0, 10_000])
    told = policy({**frames, "views": views}, context, policy.initial_state(1)).views
    assert told.shape == (len(WALK) + 1, 1)
    assert told.nonzero().tolist() == [[3, 0]]
    told.sum().backward()
    assert float(policy.places.worths[-1].bias.grad.abs().sum()) > 0


@pytest.mark.parametrize("value", [0, -1.0, True, 101, "3"])
@pytest.mark.parametrize("name", ["sharpness", "trust"])
def test_a_factor_that_does_not_fit_is_named(name, value):
    with pytest.raises(ConfigError, match=rf"agent\.policy\.{name}=.*above 0, at most 100"):
        HabitPolicyE2E(**{name: value})


@pytest.mark.parametrize(
    ("up_m", "away_m", "look", "left"),
    [
        (0.5, 0.9, 0, {Action.LOOK_UP}),
        (0.5, 0.9, 1, set()),
        (-0.5, 0.9, 1, {Action.LOOK_DOWN}),
        (0.5, 2.0, 0, {Action.LOOK_UP, Action.LOOK_DOWN}),
    ],
)
def test_who_saw_the_target_opens_nothing_and_looks_to_its_height(up_m, away_m, look, left):
    logits, pose = torch.zeros(1, 1, 7), torch.tensor([[[0, 0, 0, look]]])
    remembered = torch.tensor([[[1.0, away_m, 0.0, up_m, away_m]]]) / torch.tensor([1.0, 4, 4, 4, 4])
    hidden, shown = torch.tensor([[False]]), torch.tensor([[True]])
    kept = {action for action in Action if bent_on(logits, remembered, pose, hidden)[0, 0, action] == 0}
    looks = {Action.LOOK_UP, Action.LOOK_DOWN}
    assert kept == set(Action) - looks - {Action.OPEN} | left
    assert {action for action in Action if bent_on(logits, remembered, pose, shown)[0, 0, action] == 0} == {*Action} - {
        Action.OPEN
    }, "while it shows it may look around"
    assert torch.equal(bent_on(logits, torch.zeros(1, 1, 5), pose, hidden), logits), "not seen yet"


def test_in_play_what_was_looked_at_closely_counts_for_nothing(walks, monkeypatch):
    made = []
    monkeypatch.setattr(habit_policy_e2e, "outlook", lambda *given: made.append(outlook(*given)) or made[-1])
    acting = random_policy()
    for policy in (acting, random_policy().train()):
        frames, context = episode(policy, walks["gt"])
        with torch.no_grad():
            policy(frames, context, policy.initial_state(1))
    play, learning = (
        torch.stack([one.counts for one in part]) for part in (made[: len(made) // 2], made[len(made) // 2 :])
    )
    assert not play[:, :, OUTLOOK.index("used")].any()
    assert learning[:, :, OUTLOOK.index("used")].any()
    assert play[:, :, OUTLOOK.index("on")].any()


def test_in_play_the_plan_counts_more(walks):
    """The plan's log-probabilities are multiplied by ``trust`` in evaluation mode only."""
    trusting, plain = random_policy(trust=3.0), random_policy(trust=1.0)
    frames, context = episode(plain, walks["gt"])
    with torch.no_grad():
        moves = [policy(frames, context, policy.initial_state(1)).logits[..., :3] for policy in (trusting, plain)]
        log_p = plain.think(frames, context, plain.initial_state(1))[1].ways.log_p[..., :3]
        assert torch.allclose(moves[0] - moves[1], 2.0 * plain.plan_weight[:3] * log_p, atol=1e-4)
        learning = [policy.train()(frames, context, policy.initial_state(1)).logits for policy in (trusting, plain)]
    assert torch.equal(*learning)


def test_reasons_name_place_and_habit(walks):
    policy, (first, _) = random_policy(head=False), walks["gt"]
    frames, context = episode(policy, walks["gt"])
    with torch.no_grad():
        out, inside = policy.think(frames, context, policy.initial_state(1))
    belief = torch.nn.functional.pad(context["belief"].float(), (0, 0, 0, 1))
    believed = track_belief({**out.state}, belief, policy.things.openable)
    why = reasons(policy.reader, first, frames, context, out.state, believed, inside, out.logits[-1, 0])
    assert abs(sum(why.actions) - 1) < 1e-4
    assert abs(float(why.goals.sum()) - 1) < 1e-3
    assert why.habits
    assert all(text in first["habits"] for text, _ in why.habits)
    assert why.habits[0][0] in why.table()
    assert why.belief[0][2] >= why.belief[-1][2]
    assert 1 >= why.habits[0][1] >= why.habits[-1][1] > 0
