"""Which tests can notice a mutation: those that run its line, or lines that use the names its line defines.

Coverage does not see kernels, whose lines run compiled, nor constants, which are set while a module is imported, before
any test. For these it takes the tests that run a line, in any file, naming the kernel, the constant or the field.
Programs that run in separate processes are covered by the tests in files that name them.
"""

from __future__ import annotations

import ast
import json
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path
from typing import Final

from tests.mutants.places import Mutation
from tests.mutants.recorder import MEASURED
from tests.mutants.sample import PARTS, part_of

_KERNELS: Final = frozenset({"jit", "merged", "leaf", "inlined", "njit"})
#: Most steps from name to name: a kernel may be called by a kernel that is called by a kernel ...
_DEPTH: Final = 5
Line = tuple[str, int]
Function = ast.FunctionDef | ast.AsyncFunctionDef


@dataclass(frozen=True)
class Recorded:
    """The records of all tests."""

    seconds: Mapping[str, float]
    """Seconds by test, without tests that failed or were skipped without any mutation."""
    by_line: Mapping[Line, frozenset[str]]

    @classmethod
    def read(cls, files: Iterable[Path]) -> Recorded:
        """Combine the files written by :mod:`tests.mutants.recorder`."""
        seconds: dict[str, float] = {}
        by_line: dict[Line, set[str]] = defaultdict(set)
        for file in files:
            found = json.loads(file.read_text())
            names = list(found["tests"])
            good = {name for name, told in found["tests"].items() if told["passed"]}
            seconds |= {name: found["tests"][name]["seconds"] for name in good}
            for source, lines in found["lines"].items():
                for line, tests in lines.items():
                    by_line[source, int(line)] |= {names[k] for k in tests} & good
        return cls(seconds, {line: frozenset(tests) for line, tests in by_line.items() if tests})


class Reach:
    """Finds tests for mutations of one tree."""

    def __init__(self, root: Path, recorded: Recorded) -> None:
        self._root, self._recorded = root, recorded

    def tests(self, mutation: Mutation, budget_s: float) -> list[str]:
        """Tests that may notice it, within ``budget_s``: those of its own part first, each group quickest first."""
        own = PARTS[part_of(mutation.file)][1]
        seconds = self._recorded.seconds
        found = self._of_line((mutation.file, mutation.line), _DEPTH, set()) or self._naming(mutation.file)
        ranked = sorted(found, key=lambda test: (not test.startswith(f"{own}/"), seconds[test], test))
        chosen, spent = [], 0.0
        for test in ranked:
            if chosen and spent + seconds[test] > budget_s:
                continue
            chosen.append(test)
            spent += seconds[test]
        return chosen

    def seconds(self, tests: Iterable[str]) -> float:
        """How long the tests took when they were recorded."""
        return sum(self._recorded.seconds[test] for test in tests)

    def _of_line(self, line: Line, depth: int, visited: set[Line]) -> frozenset[str]:
        statement = _statement(self._tree(line[0]), line[1])
        direct = self._ran(line[0], statement.lines)
        if (direct and not statement.imported) or depth == 0 or line in visited:
            return direct
        visited.add(line)
        if statement.body:  # defaults of a function: the tests that run its body
            inside = self._ran(line[0], statement.body)
            if inside:
                return inside
        users = {user for name in statement.names for user in self._users(name, line[0])} - visited
        found = [self._of_line(user, depth - 1, visited) for user in sorted(users)]
        return frozenset().union(*found)

    def _naming(self, file: str) -> frozenset[str]:
        """Tests in files that name a module or are named after it, since separate processes are not recorded."""
        stem, module, out = Path(file).stem, file.removesuffix(".py").replace("/", "."), set()
        for test in self._recorded.seconds:
            where = test.partition("::")[0]
            if stem.startswith(Path(where).stem.removeprefix("test_")) or module in self._text(where):
                out.add(test)
        return frozenset(out)

    @cache  # noqa: B019 - one a run
    def _text(self, file: str) -> str:
        path = self._root / file
        return path.read_text() if path.is_file() else ""

    def _ran(self, file: str, lines: Iterable[int]) -> frozenset[str]:
        return frozenset().union(*(self._recorded.by_line.get((file, line), frozenset()) for line in lines))

    def _users(self, name: str, file: str) -> list[Line]:
        """Lines that use a name of a file: in the file, in files that import it, and as an attribute anywhere."""
        module = file.removesuffix(".py").replace("/", ".")
        return [
            (other, line)
            for other, line, attribute in self._names().get(name, ())
            if other == file or attribute or module in self._imports(other)
        ]

    @cache  # noqa: B019 - one a run
    def _tree(self, file: str) -> ast.Module:
        return ast.parse((self._root / file).read_text())

    @cache  # noqa: B019 - one a run
    def _imports(self, file: str) -> frozenset[str]:
        nodes = [node for node in ast.walk(self._tree(file)) if isinstance(node, ast.ImportFrom) and node.module]
        return frozenset({f"{n.module}" for n in nodes} | {f"{n.module}.{a.name}" for n in nodes for a in n.names})

    @lru_cache(maxsize=1)  # noqa: B019 - one a run
    def _names(self) -> dict[str, list[tuple[str, int, bool]]]:
        """Where each name is read: (file, line, whether as an attribute)."""
        out: dict[str, list[tuple[str, int, bool]]] = defaultdict(list)
        for folder in MEASURED:
            for path in sorted((self._root / folder).rglob("*.py")):
                file = path.relative_to(self._root).as_posix()
                for node in ast.walk(self._tree(file)):
                    if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load):
                        out[node.id].append((file, node.lineno, False))
                    elif isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Load):
                        out[node.attr].append((file, node.lineno, True))
        return out


@dataclass(frozen=True)
class Statement:
    """The statement around a line."""

    lines: Sequence[int]
    """Lines of the statement, or of the head of a compound statement."""
    names: Sequence[str]
    """Names by which other code uses what the statement defines."""
    imported: bool
    """Whether the statement runs while the module is imported."""
    body: Sequence[int] = ()
    """Lines of the function's body if the line is in its head."""


def _statement(tree: ast.Module, line: int) -> Statement:
    path = _path(tree, line)
    last = path[-1]
    function = next((node for node in reversed(path) if isinstance(node, Function)), None)
    inner = isinstance(last, Function) or function is not None
    body = getattr(last, "body", None)
    end = body[0].lineno - 1 if isinstance(body, list) and body[0].lineno > last.lineno else last.end_lineno or line
    lines = range(last.lineno, end + 1)
    if function is None:
        names = _made(last) + [node.name for node in path[:-1] if isinstance(node, ast.ClassDef)][-1:]
        return Statement(lines, names, True)
    if function is last:
        return Statement(
            lines, [function.name], True, range(function.body[0].lineno, (function.end_lineno or line) + 1)
        )
    kernel = next((n for n in path if isinstance(n, Function) and _is_kernel(n)), None)
    return Statement(lines, [kernel.name] if kernel and inner else [], False)


def _path(tree: ast.Module, line: int) -> list[ast.stmt]:
    """Statements around a line, outer ones first."""
    out: list[ast.stmt] = []
    inside: ast.AST | None = tree
    while inside is not None:
        statements = [node for node in _statements(inside) if _first(node) <= line <= (node.end_lineno or line)]
        inside = statements[0] if statements else None
        out += statements[:1]
    return out


def _first(node: ast.stmt) -> int:
    """The line of its first decorator, or its own."""
    return min([node.lineno, *(d.lineno for d in getattr(node, "decorator_list", ()))])


def _statements(node: ast.AST) -> list[ast.stmt]:
    """Statements directly below a node, in all branches."""
    out: list[ast.stmt] = []
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.stmt):
            out.append(child)
        elif isinstance(child, ast.ExceptHandler | ast.match_case):
            out += _statements(child)
    return out


def _made(node: ast.stmt) -> list[str]:
    """Names that a statement binds."""
    if isinstance(node, Function | ast.ClassDef):
        return [node.name]
    return [n.id for n in ast.walk(node) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)]


def _is_kernel(node: Function) -> bool:
    return any(
        (d.id if isinstance(d, ast.Name) else getattr(d, "attr", "")) in _KERNELS
        for decorator in node.decorator_list
        for d in [decorator.func if isinstance(decorator, ast.Call) else decorator]
    )
