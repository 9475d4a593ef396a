"""The end-to-end habit policy: frames, detections and habits in, one of the seven actions out.

An RGB-D encoder, detections as tokens that attend to the habits, a belief over anchors, a map memory and an LSTM. The
map is part of the recurrent state: fixed rules write it, convolutions read it. A mixture over places to go to
(:mod:`models.nets.end_to_end.places_to_go`) gives action preferences by shortest paths over what was seen; nothing that
the agent has not seen enters. Done is suppressed where no target is seen nearby.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from models.nets.belief.head_reader import default_head_reader
from models.nets.end_to_end.advice import Advisor
from models.nets.end_to_end.ego_view import THING_FEATURES
from models.nets.end_to_end.floor_memory import CHANNELS, N_TRACKS, REACH, FloorMemory, MemoryStep, Window
from models.nets.end_to_end.frames_of_reference import from_here, target_at, turned
from models.nets.end_to_end.inside import PolicyTrace
from models.nets.end_to_end.one_frame import one_frame
from models.nets.end_to_end.places_to_go import PlacesToGo, Ways
from models.nets.end_to_end.read_habits import SUMMARY_FEATURES, read_habits, words
from models.nets.end_to_end.things_in_view import N_CUES, ThingsInView
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
from ucon.task.actions import Action

_MAX_STEPS = 300.0
_N_LOOKS = 5
#: Log odds of Done where the target is not near, whatever the network says. Subtracting a constant from its logit does
#: not work: some solutions end farther off, so training raised the logit until constants of 10 and of 30 were undone.
_NEVER = -15.0
#: Offsets (i, j) of the nodes ahead, right, left and here in the window around the agent: (4 headings, 4, 2).
_BESIDE = np.array([[(c, s), (s, -c), (-s, c), (0, 0)] for c, s in ((1, 0), (0, 1), (-1, 0), (0, -1))])
_N_STATUS = _N_LOOKS + 8 + 2 + 5 + 8 + len(SUMMARY_FEATURES)


class HabitPolicyE2E(PolicyModule):
    """Recurrent policy over the seven actions that reads habits (see the module)."""

    architecture = "habit_policy_e2e"
    uses_habits = True
    max_habits = MAX_HABITS

    openable: Tensor
    beside: Tensor

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
        seed: int = 0,
    ) -> None:
        """Build the network with random weights.

        Args:
            reader: reads the habits; by default the shipped one that ``head`` names.
            head: True: the belief head reads the habits. False: the fitted anchor reader does (ablation).
            image_px: side of the image that the visual encoder reads; divides the camera's, a multiple of 16.
            width: of tokens.
            hidden: size of the LSTM's state.
            rgb: False blanks the image (ablation).
            plan: False leaves out the places to go to (ablation).
            attend: False zeroes the habits' vectors, which leaves the belief (ablation).
            scores: retrieval scores as a feature of habits.
            advisor: a language model's choice among anchors as a feature of things.
            clip: a frozen CLIP image encoder beside the learned one.
            seed: of the weights.

        Raises:
            ConfigError: a size that does not fit.
        """
        super().__init__()
        if type(image_px) is not int or not 16 <= image_px <= MOST or image_px % 16:
            raise ConfigError(f"agent.policy.image_px={brief(image_px)}: must be a multiple of 16, from 16 to {MOST}")
        check_sizes("agent.policy", width=width, hidden=hidden)
        self._reader, self._head = reader, head
        self._arguments = {"image_px": image_px, "width": width, "hidden": hidden}
        self._arguments |= {"rgb": rgb, "plan": plan, "attend": attend, "scores": scores}
        self._advisor, self._clip = advisor, clip
        self._rgb, self._plan, self._attend, self._scores, self._image_px = rgb, plan, attend, scores, image_px
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(derived_seed(seed, self.architecture))
            self._build(width, hidden)

    def _build(self, width: int, hidden: int) -> None:
        self.eye = Eye(self._image_px, 2 * width)
        self.things = ThingsInView(width, tuple(self.reader.known), DIM)
        self.memory = FloorMemory()
        self.places = PlacesToGo(len(SUMMARY_FEATURES) + 2)
        facts = N_CUES + _N_STATUS + 4
        looks = 2 * width + (0 if self._clip is None else self._clip.dim)
        self.join = nn.Sequential(nn.Linear(looks + 3 * width + facts, hidden), nn.ReLU())
        self.lstm = nn.LSTM(hidden, hidden)
        last = nn.Linear(hidden, N_ACTIONS)
        nn.init.normal_(last.weight, std=0.01)  # small, so that at first the places to go to decide
        self.choose = nn.Sequential(nn.Linear(hidden + facts, hidden), nn.ReLU(), last)
        self.plan_weight = nn.Parameter(torch.tensor([1.0, 1.0, 1.0, 0.2, 0.2, 0.2, 0.2]))
        self.judge = nn.Sequential(nn.Linear(hidden + facts, hidden // 2), nn.ReLU(), nn.Linear(hidden // 2, 1))
        self.register_buffer("beside", torch.from_numpy(_BESIDE), persistent=False)

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
        """Raise an error of one line where weights of the advisor or of CLIP are missing."""
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
        """Recurrent state at the start: empty maps, no container opened, no target seen, LSTM states of 0."""
        device = self.device
        return {
            **self.memory.initial_state(batch, device),
            **lstm_state(batch, self.lstm),
            "opened": torch.zeros(batch, N_TRACKS, dtype=torch.bool, device=device),
            "target_at": torch.zeros(batch, 4, device=device),
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
        new, opened, windows, remembered = self._remember(frames, things, mass, given, state)
        status = self._status(frames, given, windows, remembered)
        image = frames["image"].flatten(0, 1)
        sight = self.eye(image if self._rgb else torch.zeros_like(image)).unflatten(0, frames["pose"].shape[:2])
        if "clip" in frames:
            sight = torch.cat([sight, frames["clip"].float()], -1)
        seen = self.things(frames["thing_ids"].long(), things, opened, mass, given)
        ways, log_p = self._ways(frames, windows, status)
        facts = torch.cat([seen.cues, status, log_p / 4], -1)
        joined = self.join(torch.cat([sight, seen.summary, facts], -1))
        hidden, memory = run_lstm(self.lstm, joined, state)
        thought = torch.cat([hidden, facts], -1)
        planned = torch.cat([log_p[..., :3], log_p[..., 3:].expand(*log_p.shape[:-1], 4)], -1)
        logits = self.choose(thought) + self.plan_weight * planned
        others, done = logits[..., : Action.DONE], logits[..., Action.DONE]  # Done is the last action
        done = torch.where(seen.near, done, others.logsumexp(-1) + _NEVER)
        logits = torch.cat([others, done[..., None]], -1)
        value = self.judge(thought).squeeze(-1)
        return PolicyOutputs(logits.float(), value.float(), {**new, **memory}), PolicyTrace(seen, ways)

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
        from models.nets.end_to_end.reasons import reasons

        outputs, inside = self.think(frames, context, state)
        why = reasons(self.reader, info, frames, context, outputs.state, inside, outputs.logits[-1, 0])
        i, j, heading, _ = frames["pose"][-1, 0].tolist()
        return draw_reasons(why, str(info["target"]), outputs.state["cells"][0], (i, j, heading))

    def _masses(self, ids: Tensor, context: dict[str, Tensor]) -> Tensor:
        """Belief (T, B, N, 4) that the target is on, beside, in (open) or in (closed) each thing.

        Values are relative to the category with the highest belief.
        """
        belief = nn.functional.pad(context["belief"].float(), (0, 0, 0, 1))  # (B, n + 1, 4)
        best = belief.sum(-1).amax(-1)[:, None, None].clamp(min=1e-6)
        row = ids.clamp(min=0).long()
        episode = torch.arange(len(belief), device=row.device)[None, :, None]
        p = (belief / best)[episode, row] * (ids >= 0)[..., None]
        ontop, inside, under, beside = p.unbind(-1)
        shut = self.things.openable[row]
        return torch.stack([ontop, under + beside, inside * ~shut, inside * shut], -1)

    @torch.no_grad()
    def _remember(
        self, frames: Tensors, things: Tensor, mass: Tensor, context: dict[str, Tensor], state: Tensors
    ) -> tuple[dict[str, Tensor], Tensor, list[Window], Tensor]:
        """Write T frames into the map memory, step by step.

        Returns:
            The new state; which things were opened (T, B, N); the window around the agent at each step; and the
            remembered
            target relative to the agent, (T, B, 4).
        """
        new = {name: state[name].clone() for name in ("cells", "what", "opened", "target_at")}
        just, opened, windows, remembered = things[..., THING_FEATURES.index("just_opened")] > 0.5, [], [], []
        for t, ids in enumerate(frames["thing_ids"]):
            tracks, is_target = frames["thing_tracks"][t].long(), ids == context["target"][:, None]
            known = (tracks >= 0) & (tracks < N_TRACKS)
            batch, row = (just[t] & known).nonzero(as_tuple=True)
            new["opened"][batch, tracks[batch, row]] = True
            opened.append(new["opened"].gather(1, tracks.clamp(0, N_TRACKS - 1)) & known)
            pose = frames["pose"][t].long()
            new["target_at"] = target_at(new["target_at"], is_target[:, 0] & (ids[:, 0] >= 0), things[t, :, 0], pose)
            rows = frames["pair_row"][t].clamp(min=0).long()
            marks = torch.stack([just[t] | opened[-1], is_target], 1).float()
            masses = torch.cat([mass[t].transpose(1, 2), marks], 1)  # (B, 6, N)
            pair_mass = masses.gather(2, rows[:, None].expand(-1, 6, -1))
            category = ids.long().gather(1, rows)
            collision = frames["status"][t, :, 1] > 0
            patch, look = frames["patch"][t], frames["look"][t]
            self.memory.write(
                new, MemoryStep(pose, collision, patch, look, frames["pair_cell"][t], pair_mass, category)
            )
            windows.append(self.memory.read(new, pose))
            remembered.append(from_here(new["target_at"], pose))
        return new, torch.stack(opened), windows, torch.stack(remembered)

    def _status(self, frames: Tensors, context: dict[str, Tensor], windows: list[Window], remembered: Tensor) -> Tensor:
        """Features (T, B, _N_STATUS): look, last action, step, collision, remembered target, nodes around, belief."""
        pose, status = frames["pose"].long(), frames["status"].long()
        look = nn.functional.one_hot(pose[..., 3] + 2, _N_LOOKS)
        last = nn.functional.one_hot(status[..., 2], 8)
        step = status[..., :2] / torch.tensor([_MAX_STEPS, 1.0], device=pose.device)
        at = REACH + self.beside[pose[..., 2]]  # (T, B, 4, 2)
        batch = torch.arange(pose.shape[1], device=pose.device)[:, None]
        visits, free = [], []
        for t, window in enumerate(windows):
            i, j = at[t].unbind(-1)
            visits.append(window.cells[batch, CHANNELS.index("visited"), i, j] / 255.0)
            free.append(window.free[batch, i, j])
        beside = torch.cat([torch.stack(visits), torch.stack(free).float()], -1)
        summary = context["summary"].float().expand(len(pose), -1, -1)
        return torch.cat([look, last, step, remembered, beside, summary], -1)

    def _ways(self, frames: Tensors, windows: list[Window], status: Tensor) -> tuple[Ways, Tensor]:
        """Places to go to with their weights, and log-probabilities of moves (T, B, 4)."""
        joined = Window(torch.cat([w.cells for w in windows]), torch.cat([w.free for w in windows]))
        step, found = status[..., _N_LOOKS + 8, None], status[..., _N_LOOKS + 10, None]
        given = torch.cat([status[..., -len(SUMMARY_FEATURES) :], step, found], -1).flatten(0, 1)
        ways = self.places(joined, frames["pose"][..., 2].flatten(), given)
        log_p = ways.log_p.unflatten(0, status.shape[:2])
        return ways, log_p if self._plan else torch.zeros_like(log_p)
