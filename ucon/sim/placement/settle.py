"""Settling: the object falls in a small PyBullet world that holds only its neighbours.

Every trial uses new bodies in a client that was reset, so that equal inputs give equal bits. PyBullet's saved states do
not guarantee that, and are not used.
"""

from __future__ import annotations

import atexit
import os
from dataclasses import dataclass
from enum import Enum

import numpy as np

from ucon.core.geometry import matrix_from_quat
from ucon.sim.bodies import BodyFactory
from ucon.sim.bullet import bullet
from ucon.sim.placement.slots import Slot
from ucon.sim.placement.surroundings import Surroundings
from ucon.sim.shapes import Array, Solid, quat_of_matrix

STEP_HZ = 240
SETTLE_STEPS = 40
WATCH_STEPS = 240
_WATCH_PIECE = 40
_REST_M = 2e-5
"""An object that moved less than this in one piece of the watch is at rest, metres."""
STABLE_M = 0.02
TILT_COS = float(np.cos(np.radians(8.0)))
_SNAP_COS = float(np.cos(np.radians(0.3)))
_MARGIN_M = 0.06
_FALL_M = 0.03
_TOUCH_M = 0.004
_BLOCKED_M = 0.002
_CENTRE_OF_MASS = 0.4
"""Height of the centre of mass as a share of the object's height."""


@dataclass(frozen=True, eq=False)
class Settled:
    """A resting pose."""

    position: Array
    """(3,) of the model origin, world metres."""
    turn: Array
    """(3, 3) rotation."""
    contacts: frozenset[int]
    """Instances that it touches."""


class Miss(Enum):
    """Why an object cannot rest at a slot: something is in the way, or it falls, tips or keeps moving."""

    BLOCKED = "no_free_slot"
    UNSTABLE = "unstable"


class _Scratch:
    """One empty PyBullet client, reused for all settling in a process."""

    def __init__(self) -> None:
        self.bullet = bullet()
        self.process = os.getpid()
        self.client = self.bullet.connect(self.bullet.DIRECT)
        atexit.register(self.close)

    def close(self) -> None:
        if self.client >= 0 and self.process == os.getpid():
            self.bullet.disconnect(physicsClientId=self.client)
        self.client = -1

    def reset(self) -> BodyFactory:
        p = self.bullet
        p.resetSimulation(physicsClientId=self.client)
        p.setGravity(0, 0, -9.81, physicsClientId=self.client)
        p.setTimeStep(1.0 / STEP_HZ, physicsClientId=self.client)
        p.setPhysicsEngineParameter(deterministicOverlappingPairs=1, physicsClientId=self.client)
        return BodyFactory(self.client)


_scratch: _Scratch | None = None


def settle(scene: Surroundings, shape: Solid, slot: Slot) -> Settled | Miss:
    """Let an object fall at a slot.

    Args:
        scene: the home and its arrangement.
        shape: collision primitives of the object.
        slot: where to drop it.

    Returns:
        The resting pose, or a :class:`Miss`.
    """
    scratch = _client()
    p, client = scratch.bullet, scratch.client
    factory = scratch.reset()
    owners = _neighbours(factory, scene, slot)
    centre = centre_of_mass(shape)
    start = np.array(slot.position) + slot.pose.turn @ centre
    body = factory.dynamic(shape, max(shape.model.mass_kg, 0.02), centre, tuple(start), quat_of_matrix(slot.pose.turn))
    p.changeDynamics(
        body,
        -1,
        lateralFriction=0.8,
        spinningFriction=0.02,
        rollingFriction=0.02,
        linearDamping=0.04,
        angularDamping=0.2,
        physicsClientId=client,
    )
    p.performCollisionDetection(physicsClientId=client)
    if any(point[8] < -_BLOCKED_M for point in p.getContactPoints(bodyA=body, physicsClientId=client)):
        return Miss.BLOCKED
    _steps(scratch, SETTLE_STEPS)
    rest, _ = _pose(scratch, body)
    if np.linalg.norm(rest - start) > _FALL_M:
        return Miss.UNSTABLE
    end, turn = _watch(scratch, body, rest)
    upright = float(np.trace(turn @ slot.pose.turn.T) - 1) / 2
    if np.linalg.norm(end - rest) > STABLE_M or upright < TILT_COS:
        return Miss.UNSTABLE
    touched = {
        owners[other]
        for other in owners
        if p.getClosestPoints(body, other, _TOUCH_M, linkIndexA=-1, linkIndexB=-1, physicsClientId=client)
    }
    if upright > _SNAP_COS:
        turn = slot.pose.turn  # Exactly axis-aligned; the difference is below a millimetre.
    return Settled(np.round(end - turn @ centre, 6), turn, frozenset(touched))


def centre_of_mass(shape: Solid) -> Array:
    """Centre of mass (3,) in the object frame, metres: the mean of the primitives by volume, at 0.4 of the height."""
    low, high = shape.bounds[:3], shape.bounds[3:]
    middle = (low + high) / 2
    if len(shape.kind) > 1:
        volume = np.prod(2 * shape.half, axis=1)
        middle = (shape.center * volume[:, None]).sum(axis=0) / volume.sum()
    middle[2] = low[2] + _CENTRE_OF_MASS * (high[2] - low[2])
    return middle


def _client() -> _Scratch:
    global _scratch
    if _scratch is None or _scratch.process != os.getpid() or _scratch.client < 0:
        _scratch = _Scratch()
    return _scratch


def _neighbours(factory: BodyFactory, scene: Surroundings, slot: Slot) -> dict[int, int]:
    """Fixed bodies of all parts near a slot, mapped to the instances that own them."""
    box = slot.box + np.array([-_MARGIN_M] * 3 + [_MARGIN_M] * 3)
    owners = {}
    for row in scene.parts_near(box):
        owner = int(scene.parts.owner[row])
        standing = scene.standing[owner]
        shape, k = standing.shape, int(scene.parts.number[row])
        position = standing.turn @ shape.center[k] + standing.position
        body = factory.primitive(int(shape.kind[k]), shape.half[k], position, standing.turn @ shape.turn[k])
        owners[body] = owner
    return owners


def _watch(scratch: _Scratch, body: int, rest: Array) -> tuple[Array, Array]:
    """The pose after a second, or earlier if it is at rest."""
    before, turn = rest, np.eye(3)
    for _ in range(WATCH_STEPS // _WATCH_PIECE):
        _steps(scratch, _WATCH_PIECE)
        now, turn_now = _pose(scratch, body)
        still = np.abs(now - before).max() < _REST_M and np.abs(turn_now - turn).max() < _REST_M
        before, turn = now, turn_now
        if still:
            break
    return before, turn


def _steps(scratch: _Scratch, count: int) -> None:
    step, client = scratch.bullet.stepSimulation, scratch.client
    for _ in range(count):
        step(physicsClientId=client)


def _pose(scratch: _Scratch, body: int) -> tuple[Array, Array]:
    position, quat = scratch.bullet.getBasePositionAndOrientation(body, physicsClientId=scratch.client)
    return np.array(position), matrix_from_quat(np.array(quat))
