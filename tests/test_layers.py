"""The architecture is kept: imports only go down, there are no import cycles, and folders stay small."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]

#: From the bottom up; a part imports only those below it.
LAYERS = (
    "ucon.core", "ucon.objects", "ucon.habits", "ucon.language", "ucon.scenes", "ucon.sim", "ucon.task",
    "ucon.lives", "ucon.readers", "ucon.retrieval", "ucon.perception", "ucon.search", "ucon.memory", "ucon.envs",
    "ucon.generation", "ucon.evaluation", "ucon.fitting", "ucon.learning", "ucon.cluster",
    "ucon.configuration", "ucon.programs", "ucon.pages", "ucon.commands", "ucon.__main__", "models",
)  # fmt: skip
#: Most files in a folder, and the one folder without a limit: shapes have one file per family of objects.
MOST, WITHOUT_END = 20, "ucon/objects/shapes"


def modules() -> dict[str, Path]:
    """All modules of the product, by name."""
    found = {}
    for path in [*(ROOT / "ucon").rglob("*.py"), *(ROOT / "models").rglob("*.py")]:
        name = ".".join(path.relative_to(ROOT).with_suffix("").parts)
        found[name.removesuffix(".__init__")] = path
    return found


MODULES = modules()


def imported(path: Path) -> Iterator[str]:
    """Modules of the product that a file imports: at the top, only for types, or inside a function."""

    def walk(node: ast.AST) -> Iterator[str]:
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.Import):
                yield from (name.name for name in child.names if name.name in MODULES)
            elif isinstance(child, ast.ImportFrom) and child.module in MODULES:
                whole = (f"{child.module}.{name.name}" for name in child.names)
                yield from (name if name in MODULES else child.module for name in whole)
            yield from walk(child)

    return walk(ast.parse(path.read_text(encoding="utf-8")))


def layer(module: str) -> int:
    """Number of the part that a module belongs to."""
    return next(k for k, part in enumerate(LAYERS) if module == part or module.startswith(f"{part}."))


@pytest.mark.parametrize("name", sorted(MODULES.keys() - {"ucon"}))
def test_imports_go_down_only(name: str) -> None:
    upwards = [to for to in imported(MODULES[name]) if to != "ucon" and layer(to) > layer(name)]
    assert upwards == []


def test_modules_import_each_other_in_no_circle() -> None:
    """This includes imports only for types and inside functions."""
    graph = {name: {to for to in imported(path) if to != name} for name, path in MODULES.items()}
    for name, to in graph.items():  # importing a package runs what it imports, but not its modules
        graph[name] = {one for one in to if one != "ucon" and not name.startswith(f"{one}.")}
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        pytest.fail(" imports ".join(error.args[1]))


def test_folders_stay_small() -> None:
    folders = {path.parent for path in MODULES.values()} - {ROOT / WITHOUT_END}
    counts = {str(folder.relative_to(ROOT)): len(list(folder.glob("*.py"))) for folder in folders}
    assert {folder: n for folder, n in counts.items() if n > MOST} == {}
