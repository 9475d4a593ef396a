"""Shape building: a builder adds parts to a :class:`Kit`, which becomes one :class:`ObjectModel`.

A builder gets a kit for one category, size and colour. Lengths are in metres. After :meth:`Kit.unit` they are fractions
of the size (x and y from -0.5 to 0.5, z from 0 to 1), and the finished parts are stretched to fill the size exactly.
Thicknesses of rods are always in metres.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from math import atan2, hypot, pi, sqrt

from ucon.objects.bounds import fit
from ucon.objects.catalogue import Hints
from ucon.objects.model import Box3, Category, Compartment, Joint, Material, ObjectModel, Part, Surface, Vec3
from ucon.objects.palette import RGB

Builder = Callable[["Kit"], None]

SHAPES: dict[str, Builder] = {}
"""Builder of each archetype; a builder registered under a category's own name takes precedence."""


def shape(*names: str) -> Callable[[Builder], Builder]:
    """Decorator that registers a builder for archetypes or single categories."""

    def register(builder: Builder) -> Builder:
        for name in names:
            if name in SHAPES:
                raise ValueError(f"two builders for shape '{name}'")
            SHAPES[name] = builder
        return builder

    return register


class Kit:
    """Collects the parts of one model.

    Attributes:
        category: row of the catalogue.
        hints: proportions.
        size: metres.
        color: default colour of parts.
        material: default material of parts.
    """

    def __init__(self, category: Category, hints: Hints, size: Vec3, color: RGB, material: Material) -> None:
        self.category = category
        self.hints = hints
        self.size = size
        self.color = color
        self.material = material
        self.parts: list[Part] = []
        self.joints: list[Joint] = []
        self.surfaces: list[Surface] = []
        self.compartments: list[Compartment] = []
        self.under: list[Box3] = []
        self.solid = False
        self._scale: Vec3 = (1.0, 1.0, 1.0)
        self._fit = False

    @property
    def name(self) -> str:
        """Name of the category."""
        return self.category.name

    def has(self, *words: str) -> bool:
        """Whether the category's name contains any of the given words."""
        return any(word in self.category.name for word in words)

    def unit(self) -> Kit:
        """Switch to fractions of the size; the result is stretched to fill the size.

        Returns:
            The kit itself.
        """
        self._scale = self.size
        self._fit = True
        return self

    # Parts ------------------------------------------------------------------------------------------------------

    def box(
        self,
        x: tuple[float, float],
        y: tuple[float, float],
        z: tuple[float, float],
        color: RGB | None = None,
        material: Material | None = None,
        link: int = -1,
        rpy: Vec3 = (0.0, 0.0, 0.0),
    ) -> None:
        """Add a box.

        Args:
            x: extent.
            y: extent.
            z: extent.
            color: default: the kit's.
            material: default: the kit's, or plain with a colour.
            link: joint that carries it, -1 for none.
            rpy: rotation about its centre, radians.
        """
        self._add("box", x, y, z, color, material, link, rpy)

    def ball(
        self,
        x: tuple[float, float],
        y: tuple[float, float],
        z: tuple[float, float],
        color: RGB | None = None,
        material: Material | None = None,
        rpy: Vec3 = (0.0, 0.0, 0.0),
    ) -> None:
        """Add an ellipsoid that fills a box.

        Args:
            x: extent.
            y: extent.
            z: extent.
            color: default: the kit's.
            material: default: the kit's, or plain with a colour.
            rpy: rotation about its centre, radians.
        """
        self._add("sphere", x, y, z, color, material, -1, rpy)

    def wedge(
        self,
        x: tuple[float, float],
        y: tuple[float, float],
        z: tuple[float, float],
        color: RGB | None = None,
        material: Material | None = None,
        flip: bool = False,
        link: int = -1,
    ) -> None:
        """Add a ramp that rises along +x, or along -x with ``flip``.

        Args:
            x: extent.
            y: extent.
            z: extent.
            color: default: the kit's.
            material: default: the kit's, or plain with a colour.
            flip: direction.
            link: joint that carries it, -1 for none.
        """
        self._add("wedge", x, y, z, color, material, link, (0.0, 0.0, pi if flip else 0.0))

    def cyl(
        self,
        x: tuple[float, float],
        y: tuple[float, float],
        z: tuple[float, float],
        color: RGB | None = None,
        material: Material | None = None,
        axis: str = "z",
        taper: float = 1.0,
        link: int = -1,
    ) -> None:
        """Add a cylinder or cone that fills a box.

        Args:
            x: extent.
            y: extent.
            z: extent.
            color: default: the kit's.
            material: default: the kit's, or plain with a colour.
            axis: ``x``, ``y`` or ``z``.
            taper: scale of its end at the larger coordinate.
            link: joint that carries it, -1 for none.
        """
        sx, sy, sz = self._extent(x, y, z)
        turn = 1.0
        if taper > 1.0:  # Parts taper towards their top only, so turn it upside down.
            grown = (
                sx if axis == "x" else sx * taper,
                sy if axis == "y" else sy * taper,
                sz * (taper if axis != "z" else 1),
            )
            (sx, sy, sz), taper, turn = grown, 1.0 / taper, -1.0
        if axis == "x":
            size, rpy = (sz, sy, sx), (0.0, turn * pi / 2, 0.0)
        elif axis == "y":
            size, rpy = (sx, sz, sy), (-turn * pi / 2, 0.0, 0.0)
        else:
            size, rpy = (sx, sy, sz), (0.0 if turn > 0 else pi, 0.0, 0.0)
        self._put("cylinder", size, self._middle(x, y, z), color, material, link, rpy, taper)

    def rod(
        self,
        start: Vec3,
        end: Vec3,
        thickness: float | tuple[float, float],
        color: RGB | None = None,
        material: Material | None = None,
        kind: str = "box",
        taper: float = 1.0,
    ) -> None:
        """Add a straight bar (``box``), round bar (``cylinder``) or lens (``sphere``).

        Args:
            start: one end.
            end: the other.
            thickness: metres, one or two.
            color: default: the kit's.
            material: default: the kit's, or plain with a colour.
            kind: see above.
            taper: of a cylinder.
        """
        p = [c * s for c, s in zip(start, self._scale, strict=True)]
        q = [c * s for c, s in zip(end, self._scale, strict=True)]
        dx, dy, dz = (b - a for a, b in zip(p, q, strict=True))
        length = max(sqrt(dx * dx + dy * dy + dz * dz), 1e-6)
        flat = hypot(dx, dy)
        pitch, yaw = atan2(flat, dz), atan2(dy, dx) if flat > 1e-9 else 0.0
        a, b = thickness if isinstance(thickness, tuple) else (thickness, thickness)
        center = ((p[0] + q[0]) / 2, (p[1] + q[1]) / 2, (p[2] + q[2]) / 2)
        self._put(kind, (a, b, length), center, color, material, -1, (0.0, pitch, yaw), taper)

    def panel(
        self,
        start: tuple[float, float],
        end: tuple[float, float],
        thickness: float,
        z: tuple[float, float],
        color: RGB | None = None,
        material: Material | None = None,
    ) -> None:
        """Add an upright board between two points of the floor plan, slightly longer so that corners close; metres.

        Args:
            start: x, y of one end.
            end: of the other.
            thickness: of the board.
            z: extent.
            color: default: the kit's.
            material: default: the kit's, or plain with a colour.
        """
        dx, dy = end[0] - start[0], end[1] - start[1]
        size = (hypot(dx, dy) + 0.6 * thickness, thickness, z[1] - z[0])
        center = ((start[0] + end[0]) / 2, (start[1] + end[1]) / 2, (z[0] + z[1]) / 2)
        self._put("box", size, center, color, material, -1, (0.0, 0.0, atan2(dy, dx)))

    def path(
        self, points: list[Vec3], thickness: float, color: RGB | None = None, material: Material | None = None
    ) -> None:
        """Add bars through some points: handles, frames, hoses.

        Args:
            points: in order.
            thickness: metres.
            color: default: the kit's.
            material: default: the kit's, or plain with a colour.
        """
        for start, end in pairwise(points):
            self.rod(start, end, thickness, color, material)

    # Meaning ----------------------------------------------------------------------------------------------------

    def surface(
        self, x: tuple[float, float], y: tuple[float, float], z: float, clearance: float = 1.0, link: int = -1
    ) -> None:
        """Add a level surface to put things on; metres, also after :meth:`unit`.

        Args:
            x: extent.
            y: extent.
            z: height.
            clearance: free height above.
            link: joint that carries it, -1 for none.
        """
        self.surfaces.append(Surface(x[0], y[0], x[1], y[1], z, clearance, link))

    def top_surface(self, inset: float = 0.0, z: float | None = None, clearance: float = 1.0) -> None:
        """Add the whole top as a surface.

        Args:
            inset: distance from its edges, metres.
            z: height; the top by default.
            clearance: free height above.
        """
        hx, hy = self.size[0] / 2 - inset, self.size[1] / 2 - inset
        self.surface((-hx, hx), (-hy, hy), self.size[2] if z is None else z, clearance)

    def space(
        self,
        x: tuple[float, float],
        y: tuple[float, float],
        z: tuple[float, float],
        link: int = -1,
        opened_by: tuple[int, ...] = (),
    ) -> None:
        """Add a compartment; metres, also after :meth:`unit`.

        Args:
            x: extent.
            y: extent.
            z: extent.
            link: joint that carries its content, -1 for none.
            opened_by: joints that must be open to see into it.
        """
        self.compartments.append(Compartment((x[0], y[0], z[0], x[1], y[1], z[1]), link, opened_by))

    def below(self, x: tuple[float, float], y: tuple[float, float], z1: float, z0: float = 0.0) -> None:
        """Add a free space below the object; metres, also after :meth:`unit`.

        Args:
            x: extent.
            y: extent.
            z1: its top.
            z0: its bottom.
        """
        self.under.append((x[0], y[0], z0, x[1], y[1], z1))

    def hinge(self, origin: Vec3, axis: Vec3, travel_rad: float) -> int:
        """Add a revolute joint.

        Args:
            origin: a point on the axis, metres.
            axis: unit vector.
            travel_rad: angle when open.

        Returns:
            Number of the joint, the ``link`` of the parts it carries.
        """
        self.joints.append(Joint("revolute", origin, axis, travel_rad))
        return len(self.joints) - 1

    def slide(self, origin: Vec3, travel_m: float) -> int:
        """Add a drawer joint along +x.

        Args:
            origin: metres.
            travel_m: distance when open.

        Returns:
            Number of the joint, the ``link`` of the parts it carries.
        """
        self.joints.append(Joint("prismatic", origin, (1.0, 0.0, 0.0), travel_m))
        return len(self.joints) - 1

    def finish(self) -> ObjectModel:
        """The model made of everything that was added."""
        parts = fit(self.parts, self.size) if self._fit else self.parts
        loose = self.category.role == "movable" and not (self.compartments or self.joints or self.under)
        return ObjectModel(
            category=self.name,
            size=self.size,
            parts=tuple(parts),
            joints=tuple(self.joints),
            surfaces=tuple(self.surfaces),
            compartments=tuple(self.compartments),
            under=tuple(self.under),
            mass_kg=self.category.mass_kg,
            simple_collision=self.solid or (loose and all(s.z >= self.size[2] - 1e-6 for s in self.surfaces)),
        )

    # Inside -----------------------------------------------------------------------------------------------------

    def _extent(self, x: tuple[float, float], y: tuple[float, float], z: tuple[float, float]) -> Vec3:
        s = self._scale
        return ((x[1] - x[0]) * s[0], (y[1] - y[0]) * s[1], (z[1] - z[0]) * s[2])

    def _middle(self, x: tuple[float, float], y: tuple[float, float], z: tuple[float, float]) -> Vec3:
        s = self._scale
        return ((x[0] + x[1]) / 2 * s[0], (y[0] + y[1]) / 2 * s[1], (z[0] + z[1]) / 2 * s[2])

    def _add(
        self,
        kind: str,
        x: tuple[float, float],
        y: tuple[float, float],
        z: tuple[float, float],
        color: RGB | None,
        material: Material | None,
        link: int,
        rpy: Vec3,
    ) -> None:
        self._put(kind, self._extent(x, y, z), self._middle(x, y, z), color, material, link, rpy)

    def _put(
        self,
        kind: str,
        size: Vec3,
        center: Vec3,
        color: RGB | None,
        material: Material | None,
        link: int,
        rpy: Vec3,
        taper: float = 1.0,
    ) -> None:
        if material is None:
            material = self.material if color is None else Material.PLAIN
        self.parts.append(
            Part(kind, size, center, color or self.color, material, rpy, link, taper)  # type: ignore[arg-type]
        )
