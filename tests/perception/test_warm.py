from __future__ import annotations

from ucon.commands.doctor import WARMING
from ucon.envs.ucon_env import UcONEnv
from ucon.perception import map_kernels as m
from ucon.perception import place_kernels as p
from ucon.perception import planner
from ucon.perception import view_kernels as v
from ucon.perception.warm import look_around

CALLED_FROM_PYTHON = (
    m.integrate, m.carve, m.look, p.make_points, p.facing, p.inherit, v.space_gain, v.place_gain, v.open_gain,
    v.fade_space, v.fade_places, planner._search,
)  # fmt: skip


def test_every_kernel_of_perception_is_compiled() -> None:
    """A look around calls all of them, so that setting up leaves none to compile in the first episode."""
    known = look_around(UcONEnv("mini", observe="symbolic", detector=True), WARMING)
    assert known.n_tracks > 3
    assert [kernel.__name__ for kernel in CALLED_FROM_PYTHON if not kernel.signatures] == []
