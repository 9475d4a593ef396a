"""What the wheel would hold."""

import sys
from pathlib import Path

import pytest

if sys.version_info >= (3, 11):
    import tomllib
else:
    tomllib = pytest.importorskip("tomli")

ROOT = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def project():
    return tomllib.loads((ROOT / "pyproject.toml").read_text())


def test_every_data_file_of_the_package_is_shipped(project):
    package = ROOT / "ucon"
    shipped = {p for pattern in project["tool"]["setuptools"]["package-data"]["ucon"] for p in package.glob(pattern)}
    data = {p for p in package.rglob("*") if p.is_file() and p.suffix != ".py" and "__pycache__" not in p.parts}
    assert data
    assert not {str(p.relative_to(ROOT)) for p in data - shipped if not p.name.startswith(".")}


def test_every_folder_of_code_is_a_package():
    folders = {p.parent for p in (ROOT / "ucon").rglob("*.py")}
    assert not [str(f.relative_to(ROOT)) for f in folders if not (f / "__init__.py").is_file()]


def test_the_mini_set_is_in_the_package():
    assert (ROOT / "ucon" / "task" / "data" / "mini.jsonl.xz").is_file()


def test_every_dependency_is_pinned(project):
    from packaging.requirements import Requirement
    from packaging.utils import canonicalize_name

    lines = (ROOT / "constraints.txt").read_text().splitlines()
    pinned = {canonicalize_name(Requirement(line).name) for line in lines if line and line[0] != "#"}
    wanted = [*project["project"]["dependencies"], *project["project"]["optional-dependencies"]["dev"]]
    assert not [name for name in wanted if canonicalize_name(Requirement(name).name) not in pinned]


def test_pins_lie_within_the_bounds(project):
    from packaging.requirements import Requirement

    lines = (ROOT / "constraints.txt").read_text().splitlines()
    pins = [Requirement(line) for line in lines if line and line[0] != "#"]
    bounds = {Requirement(d).name: Requirement(d).specifier for d in project["project"]["dependencies"]}
    for pin in pins:
        version = next(iter(pin.specifier)).version
        assert pin.name not in bounds or version in bounds[pin.name], f"{pin} is outside {bounds[pin.name]}"
