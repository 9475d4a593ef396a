"""The live world: one PyBullet client that holds a home. Compiled states are tested against it."""

from __future__ import annotations

from types import TracebackType
from typing import Any

import numpy as np

from ucon.core.errors import SceneError
from ucon.core.geometry import axis_angle_matrix, matrix_from_quat
from ucon.scenes.spec import HomeSpec
from ucon.sim.arrangement import Arrangement, PlacedObject
from ucon.sim.bodies import BodyFactory
from ucon.sim.bullet import bullet
from ucon.sim.house import STRUCTURE, House
from ucon.sim.shapes import Array, item_solid, item_turn, object_solid, quat_of_matrix, solid_of_parts
from ucon.sim.structure import structure_parts


class World:
    """Bodies, joints and contacts of one home and one arrangement in it.

    Use it as a context manager; leaving it disconnects the client.

    Example:
        ``with World(house) as world: world.set_open(12, 1.0); world.boxes()``
    """

    def __init__(self, home: House | HomeSpec) -> None:
        self.spec = home.spec if isinstance(home, House) else home
        self.bullet = bullet()
        self.client: int = self.bullet.connect(self.bullet.DIRECT)
        if self.client < 0:
            raise SceneError("PyBullet gave no client; close worlds that are no longer used")
        self.n_base = len(self.spec.items) + 3 * len(self.spec.rooms)
        self.arrangement = Arrangement()
        self._factory = BodyFactory(self.client)
        self._bodies: dict[int, list[int]] = {}
        self._owner: dict[int, int] = {}
        self._open: dict[int, float] = {}
        for number in range(len(self.spec.items)):
            self._add_item(number)
        for room, kind, parts in structure_parts(self.spec):
            instance = len(self.spec.items) + 3 * room + STRUCTURE.index(kind)
            if parts:  # An outdoor room has no ceiling.
                self._register(instance, self._factory.separate(solid_of_parts(parts)))

    def __enter__(self) -> World:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Disconnect; further calls do nothing."""
        if self.client >= 0:
            self.bullet.disconnect(physicsClientId=self.client)
            self.client = -1

    @property
    def instances(self) -> tuple[int, ...]:
        """Instances that are present, ascending."""
        return tuple(sorted(self._bodies))

    def apply(self, arrangement: Arrangement) -> None:
        """Change the world to this arrangement, with everything closed."""
        for instance in list(self._open):
            self.set_open(instance, 0.0)
        for instance in [i for i in self._bodies if i >= self.n_base]:
            self._remove(instance)
        for instance in set(self.arrangement.removed) - set(arrangement.removed):
            self._add_item(instance)
        for instance in set(arrangement.removed) & set(self._bodies):
            self._remove(instance)
        self.arrangement = arrangement
        for index, placed in enumerate(arrangement.objects):
            bodies = self._factory.furniture(object_solid(placed), placed.position, placed.quat_xyzw)
            self._register(self.n_base + index, bodies)

    def bodies(self, instance: int) -> tuple[int, ...]:
        """PyBullet bodies of an instance; empty if it was removed."""
        return tuple(self._bodies.get(instance, ()))

    def set_open(self, instance: int, fraction: float) -> None:
        """Open all joints of an instance, with what its drawers hold.

        Args:
            instance: its number.
            fraction: of the travel, 0 to 1.
        """
        joints = self._joints(instance)
        body = self._bodies[instance][0]
        for number, joint in enumerate(joints):
            self.bullet.resetJointState(body, number, joint.travel * fraction, physicsClientId=self.client)
        self._open[instance] = fraction
        for index, placed in enumerate(self.arrangement.objects):
            if placed.holder == instance and placed.compartment >= 0:
                self._carry(index, placed, fraction)

    def openness(self, instance: int) -> float:
        """Fraction of the travel of an instance's first joint, read back from PyBullet; 0 without joints."""
        joints = self._joints(instance)
        if not joints:
            return 0.0
        state = self.bullet.getJointState(self._bodies[instance][0], 0, physicsClientId=self.client)
        return float(state[0]) / joints[0].travel

    def boxes(self) -> Array:
        """Current boxes of all instances, from PyBullet.

        Returns:
            (n, 6) world metres; zeros for absent ones.
        """
        result = np.zeros((self.n_base + len(self.arrangement.objects), 6))
        for instance, bodies in self._bodies.items():
            low, high = np.full(3, np.inf), np.full(3, -np.inf)
            for body, link in self._links(bodies):
                a, b = self.bullet.getAABB(body, link, physicsClientId=self.client)
                low, high = np.minimum(low, a), np.maximum(high, b)
            result[instance] = (*low, *high)
        return result

    def poses(self) -> dict[int, tuple[tuple[float, ...], tuple[float, ...]]]:
        """Position and quaternion ``xyzw`` of the first body of every instance."""
        get = self.bullet.getBasePositionAndOrientation
        return {i: get(bodies[0], physicsClientId=self.client) for i, bodies in sorted(self._bodies.items())}

    def contacts(self, instance: int, within_m: float = 0.004) -> dict[int, float]:
        """Instances near an instance.

        Args:
            instance: its number.
            within_m: greatest distance.

        Returns:
            Distance in metres by instance; negative is penetration depth.
        """
        found: dict[int, float] = {}
        for body, link in self._links(self._bodies[instance]):
            low, high = self.bullet.getAABB(body, link, physicsClientId=self.client)
            for other, distance in self.near(body, link, np.array(low), np.array(high), within_m).items():
                if other != instance:
                    found[other] = min(distance, found.get(other, np.inf))
        return found

    def near(self, body: int, link: int, low: Array, high: Array, within_m: float) -> dict[int, float]:
        """Instances near one link of a body.

        Args:
            body: PyBullet body.
            link: of the body, -1 for its base.
            low: (3,) lower corner of the link's box.
            high: (3,) upper corner.
            within_m: greatest distance.

        Returns:
            Distance in metres by instance.
        """
        p, client = self.bullet, self.client
        found: dict[int, float] = {}
        hits = p.getOverlappingObjects(tuple(low - within_m), tuple(high + within_m), physicsClientId=client) or ()
        for other, other_link in sorted(set(hits)):
            if other == body or other not in self._owner:
                continue
            points = p.getClosestPoints(
                body, other, within_m, linkIndexA=link, linkIndexB=other_link, physicsClientId=client
            )
            if points:
                owner = self._owner[other]
                found[owner] = min(min(point[8] for point in points), found.get(owner, np.inf))
        return found

    def _joints(self, instance: int) -> tuple[Any, ...]:
        if instance >= self.n_base:
            return object_solid(self.arrangement.objects[instance - self.n_base]).model.joints
        return item_solid(self.spec.items[instance]).model.joints if instance < len(self.spec.items) else ()

    def _links(self, bodies: list[int]) -> list[tuple[int, int]]:
        count = self.bullet.getNumJoints(bodies[0], physicsClientId=self.client)
        return [(bodies[0], link) for link in range(-1, count)] + [(body, -1) for body in bodies[1:]]

    def _add_item(self, number: int) -> None:
        item = self.spec.items[number]
        quat = quat_of_matrix(item_turn(item))
        self._register(number, self._factory.furniture(item_solid(item), item.position, quat))

    def _register(self, instance: int, bodies: list[int]) -> None:
        self._bodies.setdefault(instance, []).extend(bodies)
        self._owner.update(dict.fromkeys(bodies, instance))

    def _remove(self, instance: int) -> None:
        for body in self._bodies.pop(instance):
            del self._owner[body]
            self.bullet.removeBody(body, physicsClientId=self.client)
        self._open.pop(instance, None)

    def _carry(self, index: int, placed: PlacedObject, fraction: float) -> None:
        turn, position = carried_pose(self.spec, self.arrangement, placed, fraction)
        for body in self._bodies[self.n_base + index]:
            self.bullet.resetBasePositionAndOrientation(
                body, tuple(position), quat_of_matrix(turn), physicsClientId=self.client
            )


def carried_pose(
    spec: HomeSpec, arrangement: Arrangement, placed: PlacedObject, fraction: float
) -> tuple[Array, Array]:
    """Pose of a placed object while its holder is open.

    Args:
        spec: the home.
        arrangement: the episode's changes.
        placed: the object.
        fraction: of the holder's travel, 0 to 1.

    Returns:
        Rotation (3, 3) and position (3,) in world metres.
    """
    turn, position = matrix_from_quat(np.array(placed.quat_xyzw)), np.array(placed.position)
    base = len(spec.items) + 3 * len(spec.rooms)
    if placed.holder < 0 or placed.compartment < 0:
        return turn, position
    if placed.holder < base:
        item = spec.items[placed.holder]
        model, frame, origin = item_solid(item).model, item_turn(item), np.array(item.position)
    else:
        other = arrangement.objects[placed.holder - base]
        model, frame = object_solid(other).model, matrix_from_quat(np.array(other.quat_xyzw))
        origin = np.array(other.position)
    link = model.compartments[placed.compartment].link
    if link < 0:
        return turn, position
    joint = model.joints[link]
    axis = frame @ np.array(joint.axis)
    if joint.kind == "prismatic":
        return turn, position + axis * joint.travel * fraction
    pivot = origin + frame @ np.array(joint.origin)
    swing = axis_angle_matrix(axis, joint.travel * fraction)
    return swing @ turn, pivot + swing @ (position - pivot)
