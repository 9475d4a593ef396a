"""The end-to-end habit policy: frames, detections and habits in, one of the seven actions out.

It consists of an RGB-D encoder, detections as tokens that attend to the habits, a belief over anchors, a map memory and
an LSTM. The map is part of the recurrent state: fixed rules write it and count what the poses around the agent would
show. A mixture over places to go to (:mod:`models.nets.end_to_end.places_to_go`) gives action preferences by shortest
paths over what was seen; nothing that the agent has not seen enters. Done is suppressed unless a target is seen nearby,
Open unless something that can be opened is.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from models.nets.belief.head_reader import default_head_reader
from models.nets.end_to_end.advice import Advisor
from models.nets.end_to_end.ego_view import THING_FEATURES
from models.nets.end_to_end.floor_memory import (
    ENDLESS,
    N_TRACKS,
    OUTLOOK,
    TOTALS,
    MemoryStep,
    Outlook,
    initial_maps,
    kept_counts,
    layers,
    outlook,
    track_belief,
    write,
)
from models.nets.end_to_end.frames_of_reference import from_here, target_at, turned
from models.nets.end_to_end.inside import PolicyTrace
from models.nets.end_to_end.one_frame import one_frame
from models.nets.end_to_end.places_to_go import PlacesToGo, Ways, divergence
from models.nets.end_to_end.read_habits import SUMMARY_FEATURES, read_habits, words
from models.nets.end_to_end.things_in_view import N_CUES, Seen, ThingsInView
from models.nets.policy_defaults import N_ACTIONS, PolicyModule, lstm_state, run_lstm
from models.nets.sizes import MOST, check_sizes
from models.nets.vision.clip_eye import ClipEye
from models.nets.vision.eye import Eye
from ucon.core.errors import ConfigError, brief
from ucon.core.fingerprint import fingerprint_of
from ucon.core.rng import derived_seed
from ucon.language.encoder import DIM
from ucon.learning.policies.action_policy import Arrays, PolicyOutputs, Tensors
from ucon.learning.run.network_files import MAX_HABITS
from ucon.readers.anchor_reader import default_reader
from ucon.readers.protocol import Reader
from ucon.search.thoughts import Thoughts
from ucon.task.actions import Action

if TYPE_CHECKING:
    from models.nets.end_to_end.reasons import Reasons

_MAX_STEPS = 300.0
#: In play, a pose counts as showing nothing more once the agent has spent this many steps in it: by then it has looked
#: up and down there, and opened what can be opened. Without this limit it stays where it believes in what it cannot
#: reach. In play, what was looked at closely counts for nothing either, or else the agent circles in a room that it has
#: seen. While it learns from labels nothing is left out, since the expert may know better.
_PATIENCE = 4
_N_LOOKS = 5
#: Log odds of Done where the target is not near, and of Open where nothing can be opened, whatever the network says.
#: Subtracting a constant from a logit does not work: some solutions end farther away, so training raised the logit of
#: Done until it made up for constants of 10 and of 30.
_NEVER = -15.0
#: Number of features, besides the summary of the habits, on which the worth of places depends: sight range, step,
#: whether the target was seen, and sums over the map.
_GLOBALS = 3 + len(TOTALS)
#: Units of the sums over the map (square metres, square metres, belief) before logarithms are taken.
_TOTALS_UNIT = (10.0, 10.0, 0.1)
#: Arrays of a frame that the map memory is written from, and the parts of the state that hold the memory.
_WRITTEN = ("pose", "status", "patch", "look", "thing_ids", "thing_tracks", "pair_cell", "pair_row")
_MAPS = ("flags", "look", "visits", "who", "kind", "extent", "opened")
#: Angle by which a look turns the camera; distance from a remembered target within which looks only go to its height.
_LOOK_RAD, _CLOSE_M = math.pi / 6, 1.5
_N_STATUS = _N_LOOKS + 8 + 2 + 5 + 8 + len(SUMMARY_FEATURES)


class HabitPolicyE2E(PolicyModule):
    """Recurrent policy over the seven actions that reads habits (see the module)."""

    architecture = "habit_policy_e2e"
    uses_habits = True
    learns_views = True
    max_habits = MAX_HABITS

    totals_unit: Tensor

    def __init__(
        self,
        reader: Reader | None = None,
        *,
        head: bool = True,
        image_px: int = 64,
        width: int = 64,
        hidden: int = 256,
        rgb: bool = True,
        plan: bool = True,
        attend: bool = True,
        scores: bool = False,
        advisor: Advisor | None = None,
        clip: ClipEye | None = None,
        sharpness: float = 3.0,
        trust: float = 4.0,
        seed: int = 0,
    ) -> None:
        """Build the network with random weights.

        Args:
            reader: reads the habits; by default the shipped one that ``head`` selects.
            head: True: the belief head reads the habits. False: the fitted anchor reader does (ablation).
            image_px: side of the image that the visual encoder reads; divides the camera's, a multiple of 16.
            width: of tokens.
            hidden: size of the LSTM's state.
            rgb: False blanks the image (ablation).
            plan: False leaves out the places to go to (ablation).
            attend: False masks the habits in attention, which leaves the belief (ablation).
            scores: retrieval scores as a feature of habits.
            advisor: a language model's choice among anchors as a feature of things.
            clip: a frozen CLIP image encoder in addition to the learned one.
            sharpness: factor of the scores of places to go to; the higher, the more the best one dominates.
            trust: in play, factor of the log-probabilities of moves by the places to go to; 1 while it learns from
                labels. The mixture favours a move only slightly at one step, but this adds up over many.
            seed: of the weights.

        Raises:
            ConfigError: a size that does not fit.
        """
        super().__init__()
        if type(image_px) is not int or not 16 <= image_px <= MOST or image_px % 16:
            raise ConfigError(f"agent.policy.image_px={brief(image_px)}: must be a multiple of 16, from 16 to {MOST}")
        for name, value in (("sharpness", sharpness), ("trust", trust)):
            if type(value) not in (int, float) or not 0 < value <= 100:
                raise ConfigError(f"agent.policy.{name}={brief(value)}: must be above 0, at most 100")
        check_sizes("agent.policy", width=width, hidden=hidden)
        self._reader, self._head = reader, head
        self._arguments = {"image_px": image_px, "width": width, "hidden": hidden}
        self._arguments |= {"rgb": rgb, "plan": plan, "attend": attend, "scores": scores}
        self._advisor, self._clip, self._kept = advisor, clip, kept_counts()
        self._sharpness, self._trust = float(sharpness), float(trust)
        self._rgb, self._plan, self._attend, self._scores, self._image_px = rgb, plan, attend, scores, image_px
        known = tuple(self.reader.known)  # loading it draws random numbers, the first time
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(derived_seed(seed, self.architecture))
            self._build(width, hidden, known)

    def _build(self, width: int, hidden: int, known: tuple[str, ...]) -> None:
        self.eye = Eye(self._image_px, 2 * width)
        self.things = ThingsInView(width, known, DIM)
        self.places = PlacesToGo(len(SUMMARY_FEATURES) + _GLOBALS, self._sharpness)
        facts = N_CUES + _N_STATUS + 4
        looks = 2 * width + (0 if self._clip is None else self._clip.dim)
        self.join = nn.Sequential(nn.Linear(looks + 3 * width + facts, hidden), nn.ReLU())
        self.lstm = nn.LSTM(hidden, hidden)
        last = nn.Linear(hidden, N_ACTIONS)
        nn.init.normal_(last.weight, std=0.01)  # small, so that at first the places to go to decide
        self.choose = nn.Sequential(nn.Linear(hidden + facts, hidden), nn.ReLU(), last)
        self.plan_weight = nn.Parameter(torch.tensor([1.0, 1.0, 1.0, 0.25, 0.25, 0.25, 0.25]))
        self.judge = nn.Sequential(nn.Linear(hidden + facts, hidden // 2), nn.ReLU(), nn.Linear(hidden // 2, 1))
        self.register_buffer("totals_unit", torch.tensor(_TOTALS_UNIT), persistent=False)

    @property
    def reader(self) -> Reader:
        """Reader of the habits: the one given, or the shipped one."""
        if self._reader is not None:
            return self._reader
        return default_head_reader() if self._head else default_reader()  # cached per process, so copies stay small

    @property
    def arguments(self) -> Mapping[str, Any]:
        """Plain values that its weights depend on: sizes, ablations, and names of advisor and CLIP."""
        named = {"advisor": self._advisor, "clip": self._clip}
        return self._arguments | {name: None if part is None else part.name for name, part in named.items()}

    def check(self) -> None:
        """Raise a one-line error where weights of the advisor or of CLIP are missing."""
        for part in (self._advisor, self._clip):
            if part is not None:
                part.check()

    def fingerprint(self) -> str | None:
        """Hashes of advisor, CLIP and reader; None where some weights are missing."""
        parts = [part.fingerprint() for part in (self._advisor, self._clip) if part is not None]
        parts.append(str(fingerprint_of(self.reader)))
        return None if None in parts else " ".join(part for part in parts if part)

    def context(self, info: Mapping[str, Any]) -> Arrays:
        """Arrays of :func:`models.nets.end_to_end.read_habits.read_habits`, and ``advice`` (n + 1,) float16.

        ``advice`` is the advisor's probability of each category, relative to the best one; 0 without an advisor.
        """
        arrays = read_habits(self.reader, info, scores=self._scores)
        if not self._attend:
            arrays["habit_features"] = np.zeros_like(arrays["habit_features"])
        number, advised = words().number, np.zeros(len(words().number) + 1, np.float16)
        if self._advisor is not None:
            known = [name for name in self.reader.known if name in number]
            p = self._advisor.advice(info, known)
            advised[[number[name] for name in known]] = p / p.max()
        return arrays | {"advice": advised}

    def frame(self, observation: Mapping[str, Any], info: Mapping[str, Any]) -> Arrays:
        """Arrays of one step; see :func:`models.nets.end_to_end.one_frame.one_frame`."""
        return one_frame(observation, info, self._image_px, with_rgb=self._clip is not None)

    def features(self, frames: Tensors) -> Tensors:
        """With CLIP: ``clip`` (..., dim) float16 in place of ``rgb``; else the frames unchanged."""
        if self._clip is None or "clip" in frames:
            return frames
        rgb = frames["rgb"]
        vectors = self._clip.vectors(rgb.reshape(-1, *rgb.shape[-3:])).unflatten(0, rgb.shape[:-3])
        return {name: tensor for name, tensor in frames.items() if name != "rgb"} | {"clip": vectors}

    def augment(self, frames: Tensors, generator: torch.Generator) -> Tensors:
        """Turn each episode by a random number of quarter turns: the map's axes are those of the start pose."""
        quarters = torch.randint(4, (frames["pose"].shape[1],), generator=generator).to(frames["pose"].device)
        return {**frames, "pose": turned(frames["pose"], quarters)}

    def initial_state(self, batch: int) -> Tensors:
        """Recurrent state at the start: empty maps, no target seen, nowhere to go, LSTM states of 0."""
        device = self.device
        return {
            **initial_maps(batch, device),
            **lstm_state(batch, self.lstm),
            "target_at": torch.zeros(batch, 4, device=device),
            "aim": torch.full((batch, 3), -1, device=device),
        }

    def forward(self, frames: Tensors, context: Tensors, state: Tensors) -> PolicyOutputs:
        """Read T steps of B episodes; shapes as in :class:`ucon.learning.policies.action_policy.ActionPolicy`."""
        return self.think(frames, context, state)[0]

    def think(self, frames: Tensors, context: Tensors, state: Tensors) -> tuple[PolicyOutputs, PolicyTrace]:
        """As :meth:`forward`, but also returns the intermediate results that explain the action.

        Args:
            frames: (T, B, ...) by name.
            context: (B, ...) by name.
            state: recurrent state before the first step, (B, ...) by name.
        """
        frames, given = self.features(frames), dict(context)
        things, mass = frames["things"].float(), self._masses(frames["thing_ids"], given)
        new, opened, seen_from, remembered = self._remember(frames, things, given, state)
        status = self._status(frames, given, seen_from, remembered)
        image = frames["image"].flatten(0, 1)
        sight = self.eye(image if self._rgb else torch.zeros_like(image)).unflatten(0, frames["pose"].shape[:2])
        if "clip" in frames:
            sight = torch.cat([sight, frames["clip"].float()], -1)
        seen = self.things(frames["thing_ids"].long(), things, opened, mass, given)
        ways = self._ways(frames, seen_from, status, given, state["aim"])
        log_p = ways.log_p if self._plan else torch.zeros_like(ways.log_p)
        facts = torch.cat([seen.cues, status, log_p / 4], -1)
        joined = self.join(torch.cat([sight, seen.summary, facts], -1))
        hidden, memory = run_lstm(self.lstm, joined, state)
        thought = torch.cat([hidden, facts], -1)
        planned = torch.cat([log_p[..., :3], log_p[..., 3:].expand(*log_p.shape[:-1], 4)], -1)
        trust = 1.0 if self.training else self._trust
        logits = _possible(self.choose(thought) + trust * self.plan_weight * planned, seen)
        if not self.training:
            logits = bent_on(logits, remembered, frames["pose"], seen.in_view)
        value = self.judge(thought).squeeze(-1)
        outputs = PolicyOutputs(
            logits.float(), value.float(), {**new, **memory, "aim": ways.aim}, views=self._apart(ways, frames)
        )
        return outputs, PolicyTrace(seen, ways)

    def picture(
        self, info: Mapping[str, Any], frames: Tensors, context: Tensors, state: Tensors
    ) -> NDArray[np.uint8] | None:
        """Picture of the last step of one episode, drawn by :mod:`models.nets.end_to_end.draw_reasons`.

        Args:
            info: of the episode's reset.
            frames: (1, 1, ...) by name.
            context: (1, ...) by name.
            state: recurrent state before the step, (1, ...) by name.

        Returns:
            (384, W, 3) uint8.
        """
        from models.nets.end_to_end.draw_reasons import draw_reasons

        why, drawn = self._explained(info, frames, context, state)
        i, j, heading, _ = frames["pose"][-1, 0].tolist()
        return draw_reasons(why, str(info["target"]), drawn, (i, j, heading))

    def thoughts(self, info: Mapping[str, Any], frames: Tensors, context: Tensors, state: Tensors) -> Thoughts:
        """Goal, and belief by cells of the map, after the last step of one episode, as plain values.

        Args:
            info: of the episode's reset.
            frames: (1, 1, ...) by name.
            context: (1, ...) by name.
            state: recurrent state before the step, (1, ...) by name.
        """
        from models.nets.end_to_end.draw_reasons import believed_cells

        why, drawn = self._explained(info, frames, context, state)
        return Thoughts(believed_cells(drawn), why.goal_xy, (), ())

    def _explained(
        self, info: Mapping[str, Any], frames: Tensors, context: Tensors, state: Tensors
    ) -> tuple[Reasons, dict[str, NDArray[np.uint8]]]:
        """Reasons of the last step of one episode, and the layers of its map; arguments as for :meth:`picture`."""
        from models.nets.end_to_end.reasons import reasons

        outputs, inside = self.think(frames, context, state)
        after = {name: tensor.cpu() for name, tensor in outputs.state.items()}
        believed = track_belief(after, _padded(context["belief"]).cpu(), self.things.openable.cpu())
        why = reasons(self.reader, info, frames, context, after, believed, inside, outputs.logits[-1, 0])
        return why, layers(after, believed)

    def _masses(self, ids: Tensor, context: dict[str, Tensor]) -> Tensor:
        """Belief (T, B, N, 4) that the target is on, beside or under, in (open) or in (closed) each thing in view.

        Values are relative to the category with the highest belief.
        """
        belief = _padded(context["belief"])  # (B, n + 1, 4)
        best = belief.sum(-1).amax(-1)[:, None, None].clamp(min=1e-6)
        row = ids.clamp(min=0).long()
        episode = torch.arange(len(belief), device=row.device)[None, :, None]
        p = (belief / best)[episode, row] * (ids >= 0)[..., None]
        ontop, inside, under, beside = p.unbind(-1)
        shut = self.things.openable[row]
        return torch.stack([ontop, under + beside, inside * ~shut, inside * shut], -1)

    @torch.no_grad()
    def _remember(
        self, frames: Tensors, things: Tensor, context: dict[str, Tensor], state: Tensors
    ) -> tuple[dict[str, Tensor], Tensor, Outlook, Tensor]:
        """Write T frames into the map memory, step by step; on the CPU, whatever the device of the network.

        Returns:
            The new state; which things were opened (T, B, N); what the poses around each of T * B agents would show;
            and the remembered target relative to the agent, (T, B, 5).
        """
        device, cpu = self.device, torch.device("cpu")
        new = {name: state[name].to(cpu, copy=True) for name in (*_MAPS, "target_at")}
        frames = {name: frames[name].to(cpu).contiguous() for name in _WRITTEN}
        belief, reach = _padded(context["belief"]).to(cpu), context["reach_m"].float().to(cpu)
        target, openable, things = context["target"].to(cpu), self.things.openable.to(cpu), things.to(cpu)
        just, opened, seen_from, remembered = things[..., THING_FEATURES.index("just_opened")] > 0.5, [], [], []
        for t, ids in enumerate(frames["thing_ids"]):
            tracks, pose = frames["thing_tracks"][t], frames["pose"][t]
            is_target = (ids == target[:, None]) & (ids >= 0)
            new["target_at"] = target_at(new["target_at"], is_target[:, 0], things[t, :, 0], pose.long())
            step = MemoryStep(
                pose, frames["status"][t, :, 1] > 0, frames["patch"][t], frames["look"][t], frames["pair_cell"][t],
                frames["pair_row"][t], tracks, ids, is_target, just[t],
            )  # fmt: skip
            mass = write(new, step, belief, openable)
            known = (tracks >= 0) & (tracks < N_TRACKS)
            opened.append(new["opened"].gather(1, tracks.long().clamp(0, N_TRACKS - 1)) & known)
            shown = outlook(new, mass, pose, reach, ENDLESS if self.training else _PATIENCE, self._kept)
            if not self.training:
                shown.counts[:, OUTLOOK.index("used")] = 0.0
            seen_from.append(shown)
            remembered.append(from_here(new["target_at"], pose.long()))
        joined = Outlook(*(torch.cat(parts).to(device) for parts in zip(*seen_from, strict=True)))
        return (
            {name: tensor.to(device) for name, tensor in new.items()},
            torch.stack(opened).to(device),
            joined,
            torch.stack(remembered).to(device),
        )

    def _status(self, frames: Tensors, context: dict[str, Tensor], seen_from: Outlook, remembered: Tensor) -> Tensor:
        """Features (T, B, _N_STATUS): look, last action, step, collision, remembered target, nodes around, belief."""
        pose, status = frames["pose"].long(), frames["status"].long()
        look = nn.functional.one_hot(pose[..., 3] + 2, _N_LOOKS)
        last = nn.functional.one_hot(status[..., 2], 8)
        step = status[..., :2] / torch.tensor([_MAX_STEPS, 1.0], device=pose.device)
        beside = seen_from.beside.unflatten(0, pose.shape[:2])
        summary = context["summary"].float().expand(len(pose), -1, -1)
        return torch.cat([look, last, step, remembered, beside, summary], -1)

    def _ways(
        self, frames: Tensors, seen_from: Outlook, status: Tensor, context: dict[str, Tensor], aim: Tensor
    ) -> Ways:
        """Places to go to with their probabilities, and log-probabilities of moves."""
        step, found = status[..., _N_LOOKS + 8, None], status[..., _N_LOOKS + 10, None]
        reach = context["reach_m"].float().expand(len(status), -1)[..., None]
        totals = torch.log1p(seen_from.totals / self.totals_unit).unflatten(0, status.shape[:2])
        given = torch.cat([status[..., -len(SUMMARY_FEATURES) :], reach, step, found, totals], -1)
        return self.places(seen_from, given, aim, frames["pose"].long())  # type: ignore[no-any-return]

    def _apart(self, ways: Ways, frames: Tensors) -> Tensor | None:
        """Divergence (T, B) in nats from an expert's scores of the poses; None without these, or without ``plan``."""
        if "views" not in frames or not self._plan:
            return None
        goals, views, pose = (part.flatten(0, 1) for part in (ways.log_goal, frames["views"], frames["pose"]))
        return divergence(goals, views, pose, self._sharpness).unflatten(0, frames["pose"].shape[:2])


def _padded(belief: Tensor) -> Tensor:
    """Belief (B, n + 1, 4) float32, with 0 in the last row, for names outside the catalogue."""
    return nn.functional.pad(belief.float(), (0, 0, 0, 1))


def bent_on(logits: Tensor, remembered: Tensor, pose: Tensor, in_view: Tensor) -> Tensor:
    """Logits (..., 7) without actions that are idle once the target was seen.

    The agent then opens nothing. Nearby, while the target does not show, it looks only to the target's height.

    Args:
        logits: (..., 7).
        remembered: (..., 5) of :func:`from_here`.
        pose: (..., 4) of the agents.
        in_view: (...) bool, whether the target shows.
    """
    seen, up, away = remembered[..., 0] > 0.5, 4.0 * remembered[..., 3], 4.0 * remembered[..., 4]
    wanted = torch.round(torch.atan2(up, away.clamp(min=0.1)) / _LOOK_RAD)
    close = seen & (away <= _CLOSE_M) & ~in_view
    look, kept = pose[..., 3], list(logits.unbind(-1))
    for action, idle in (
        (Action.OPEN, seen), (Action.LOOK_UP, close & (look >= wanted)), (Action.LOOK_DOWN, close & (look <= wanted)),
    ):  # fmt: skip
        kept[action] = torch.where(idle, kept[action] + _NEVER, kept[action])
    return torch.stack(kept, -1)


def _possible(logits: Tensor, seen: Seen) -> Tensor:
    """Logits (..., 7) with Open and Done all but impossible where nothing can be opened or taken."""
    kept = list(logits.unbind(-1))
    for action, possible in ((Action.OPEN, seen.openable), (Action.DONE, seen.near)):
        others = torch.stack([one for number, one in enumerate(kept) if number != action], -1).logsumexp(-1)
        kept[action] = torch.where(possible, kept[action], others + _NEVER)
    return torch.stack(kept, -1)
