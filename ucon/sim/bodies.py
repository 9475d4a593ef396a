"""PyBullet bodies from collision solids. They have no visual shapes: images come from the renderer."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ucon.objects.model import Vec3
from ucon.sim.bullet import bullet
from ucon.sim.shapes import BOX, CYLINDER, SPHERE, Array, Solid, quat_of_matrix

_COMPOUND_LIMIT = 16
"""PyBullet takes at most this many primitives in one compound shape."""

NO_TURN = (0.0, 0.0, 0.0, 1.0)


class BodyFactory:
    """Creates bodies in one PyBullet client and reuses the collision shapes of equal models.

    Bodies without joints use maximal coordinates (plain rigid bodies), whose steps cost less than half.
    """

    def __init__(self, client: int) -> None:
        self._client = client
        self._bullet = bullet()
        self._geometry = {
            BOX: self._bullet.GEOM_BOX,
            CYLINDER: self._bullet.GEOM_CYLINDER,
            SPHERE: self._bullet.GEOM_SPHERE,
        }
        self._shapes: dict[tuple[int, int], tuple[Solid, list[int]]] = {}

    def furniture(self, shape: Solid, position: Array | Vec3, quat_xyzw: Sequence[float] = NO_TURN) -> list[int]:
        """Fixed bodies of one instance: the first has the joints, further ones the primitives beyond PyBullet's limit.

        Args:
            shape: collision primitives.
            position: of the model origin, world metres.
            quat_xyzw: unit quaternion.

        Returns:
            PyBullet body numbers.
        """
        p = self._bullet
        base = self._link_shapes(shape, -1)
        joints = shape.model.joints if (shape.link >= 0).any() else ()
        links = [self._link_shapes(shape, number)[0] for number in range(len(joints))]
        count = len(joints)
        pose = {"basePosition": tuple(position), "baseOrientation": tuple(quat_xyzw), "physicsClientId": self._client}
        kinds = {"revolute": p.JOINT_REVOLUTE, "prismatic": p.JOINT_PRISMATIC}
        first = p.createMultiBody(
            baseMass=0.0,
            baseCollisionShapeIndex=base[0],
            linkMasses=[1.0] * count,
            linkCollisionShapeIndices=links,
            linkVisualShapeIndices=[-1] * count,
            linkPositions=[joint.origin for joint in joints],
            linkOrientations=[NO_TURN] * count,
            linkInertialFramePositions=[(0.0, 0.0, 0.0)] * count,
            linkInertialFrameOrientations=[NO_TURN] * count,
            linkParentIndices=[0] * count,
            linkJointTypes=[kinds[joint.kind] for joint in joints],
            linkJointAxis=[joint.axis for joint in joints],
            useMaximalCoordinates=0,
            **pose,
        )
        rest = [p.createMultiBody(baseMass=0.0, baseCollisionShapeIndex=index, **pose) for index in base[1:]]
        return [first, *rest]

    def separate(self, shape: Solid) -> list[int]:
        """One fixed body for each primitive, for walls and floors: one compound's box would cover the whole room."""
        indices = range(len(shape.kind))
        return [
            self._bullet.createMultiBody(
                baseMass=0.0, baseCollisionShapeIndex=self._compound(shape, [k])[0], physicsClientId=self._client
            )
            for k in indices
        ]

    def dynamic(self, shape: Solid, mass_kg: float, centre: Array, position: Vec3, quat_xyzw: Sequence[float]) -> int:
        """A falling body.

        Args:
            shape: collision primitives.
            mass_kg: mass.
            centre: (3,) centre of mass in the object frame; the body's origin.
            position: of that origin, world metres.
            quat_xyzw: unit quaternion.

        Returns:
            PyBullet body number.
        """
        p = self._bullet
        index = self._compound(shape, list(range(len(shape.kind)))[:_COMPOUND_LIMIT], origin=centre)[0]
        return int(
            p.createMultiBody(
                baseMass=mass_kg,
                baseCollisionShapeIndex=index,
                basePosition=position,
                baseOrientation=tuple(quat_xyzw),
                useMaximalCoordinates=1,
                physicsClientId=self._client,
            )
        )

    def primitive(self, kind: int, half: Array, position: Array, turn: Array) -> int:
        """One fixed primitive.

        Args:
            kind: BOX, CYLINDER or SPHERE.
            half: (3,) half extents, metres.
            position: (3,) world metres.
            turn: (3, 3) rotation.

        Returns:
            PyBullet body number.
        """
        p = self._bullet
        if kind == BOX:
            index = p.createCollisionShape(p.GEOM_BOX, halfExtents=tuple(half), physicsClientId=self._client)
        elif kind == CYLINDER:
            index = p.createCollisionShape(
                p.GEOM_CYLINDER, radius=half[0], height=2 * half[2], physicsClientId=self._client
            )
        else:
            index = p.createCollisionShape(p.GEOM_SPHERE, radius=half[0], physicsClientId=self._client)
        return int(
            p.createMultiBody(
                baseMass=0.0,
                baseCollisionShapeIndex=index,
                basePosition=tuple(position),
                baseOrientation=quat_of_matrix(turn),
                useMaximalCoordinates=1,
                physicsClientId=self._client,
            )
        )

    def _link_shapes(self, shape: Solid, link: int) -> list[int]:
        key = (id(shape), link)
        if key not in self._shapes:
            carried = np.flatnonzero(shape.link == link)
            origin = np.zeros(3) if link < 0 else np.array(shape.model.joints[link].origin)
            self._shapes[key] = (shape, self._compound(shape, carried.tolist(), origin))
        return self._shapes[key][1]

    def _compound(self, shape: Solid, indices: list[int], origin: Array | None = None) -> list[int]:
        """Collision shapes of some primitives, in pieces that PyBullet accepts; [-1] for none."""
        if not indices:
            return [-1]
        center = shape.center if origin is None else shape.center - origin
        result = []
        for start in range(0, len(indices), _COMPOUND_LIMIT):
            piece = indices[start : start + _COMPOUND_LIMIT]
            result.append(
                self._bullet.createCollisionShapeArray(
                    shapeTypes=[self._geometry[int(shape.kind[k])] for k in piece],
                    halfExtents=[tuple(shape.half[k]) for k in piece],
                    radii=[float(shape.half[k, 0]) for k in piece],
                    lengths=[float(2 * shape.half[k, 2]) for k in piece],
                    collisionFramePositions=[tuple(center[k]) for k in piece],
                    collisionFrameOrientations=[quat_of_matrix(shape.turn[k]) for k in piece],
                    physicsClientId=self._client,
                )
            )
        return result
