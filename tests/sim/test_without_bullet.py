import subprocess
import sys

import pytest

from tests.sim.homes import hand_house
from ucon.sim.homefile import house_to_bytes

BLOCKED = """
import sys
class Block:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] == "pybullet":
            raise ImportError("blocked")
sys.meta_path.insert(0, Block())
"""

COMPILED_PATH = (
    BLOCKED
    + """
import pathlib
import ucon.sim
from ucon.sim import Arrangement, PlacedObject, SceneState, paths
from ucon.sim.homefile import house_from_bytes
file = pathlib.Path(sys.argv[1])
house = house_from_bytes(file.read_bytes(), str(file))
apple = PlacedObject("apple", (2.5, 2.5, 0.75), (0, 0, 0, 1), 0, "ontop", 1)
state = SceneState(house, Arrangement((5,), (apple,), ((1, 1),)))
state.set_open(4)
print(paths.distances(state.free, [(12, 3)]).max() > 0, "pybullet" in sys.modules)
"""
)

BUILD = (
    BLOCKED
    + """
from ucon.core.errors import UconError
from ucon.sim.world import World
from ucon.sim.bullet import bullet
try:
    bullet()
except UconError as error:
    print(error)
"""
)


def run(code, *arguments):
    done = subprocess.run([sys.executable, "-c", code, *arguments], capture_output=True, text=True, check=True)
    return done.stdout.strip()


def test_the_compiled_path_never_imports_bullet(tmp_path):
    file = tmp_path / "hand.home"
    file.write_bytes(house_to_bytes(hand_house()))
    assert run(COMPILED_PATH, str(file)) == "True False"


def test_building_without_bullet_says_what_to_do():
    message = run(BUILD)
    assert "PyBullet is needed" in message
    assert "Python 3.10 or 3.11" in message


def test_bullet_keeps_quiet():
    pytest.importorskip("pybullet", reason="it has no wheels for this Python")
    assert run("from ucon.sim.bullet import bullet; bullet()") == ""
