"""What must not be in the product: unsafe loading, network hosts of one machine, names of tools."""

from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
SOURCES = sorted(
    p for folder in ("ucon", "models") for p in (ROOT / folder).rglob("*.py")
) + sorted(ROOT.glob("*.py"))  # fmt: skip

UNSAFE = ("pickle.load", "cPickle", "dill.load", "joblib.load", "allow_pickle=True", "weights_only=False", "yaml.load(")


@pytest.mark.parametrize("path", SOURCES, ids=lambda p: str(p.relative_to(ROOT)))
def test_nothing_is_unpickled_from_disk(path):
    text = path.read_text()
    assert not [word for word in UNSAFE if word in text]


def test_there_are_sources_to_check():
    assert len(SOURCES) > 50


def test_pins_name_no_host_and_parse():
    from packaging.requirements import Requirement

    lines = [line for line in (ROOT / "constraints.txt").read_text().splitlines() if line and line[0] != "#"]
    assert not [line for line in lines if "/" in line or "@" in line or line.startswith("-")]
    assert {Requirement(line).name for line in lines} >= {"torch", "torchrl", "tensordict", "pybullet", "numpy"}
    assert all(str(Requirement(line).specifier).startswith("==") for line in lines)
