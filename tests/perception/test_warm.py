from __future__ import annotations

import subprocess
import sys

CODE = """
from ucon.programs.warming import WARMING
from ucon.envs.ucon_env import UcONEnv
from ucon.perception.detectors import noisy_kernels as d
from ucon.perception.tracking import association_kernels as s, segment_kernels as t, structure_kernels as r
from ucon.perception.detectors.noisy import NoisyDetector
from ucon.perception.mapping import fine_kernels as f, frontier_kernels as e, map_kernels as m, planner
from ucon.perception.places import chance_kernels as c, place_kernels as p
from ucon.perception.hypotheses import look_kernels as h
from ucon.perception.views import approach_kernels as a, node_kernels as n, space_kernels as w, view_kernels as v
from ucon.perception.warm import look_around
called_from_python = (
    m.integrate, m.carve, m.look, p.changed_boxes, p.make_points, p.stretch, p.facing, p.copy_unseen, w.space_gain,
    v.place_gain, v.open_gain, w.fade_space, v.fade_places, planner._search, f.add_frame, f.walk, n.nodes_ahead,
    a.best_views, p.searched, e.edges, e.groups, d.outline, d.things, d.false_boxes, t.segment,
    r.structure, s.associate, s.overlaps, h.new_looks, c.look_by_chance, c.gain_by_chance, c.fade_by_chance,
)
for detector in (True, NoisyDetector()):
    known = look_around(UcONEnv("mini", observe="symbolic", detector=detector), WARMING)
    assert known.n_tracks > 3
twice = {kernel.__name__ for kernel in called_from_python if len(kernel.signatures) > 1}
assert not twice, f"compiled for several layouts of arrays: {twice}"
print([kernel.__name__ for kernel in called_from_python if not kernel.signatures])
"""


def test_every_kernel_of_perception_is_compiled() -> None:
    """Warming up leaves nothing to compile in the first episode; a new process, so that nothing else called them."""
    result = subprocess.run([sys.executable, "-c", CODE], capture_output=True, text=True, timeout=300, check=False)
    assert result.returncode == 0, result.stderr[-2000:]
    assert result.stdout.splitlines()[-1] == "[]"
