"""What can be mutated in a file: every mutation that cosmic-ray can make, except meaningless ones."""

from __future__ import annotations

import ast
import hashlib
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, Final

from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import MutationVisitor
from cosmic_ray.plugins import get_operator, operator_names

#: Decorators compile and cache: without them things are slower, not wrong.
UNUSED: Final = ("core/RemoveDecorator",)
#: Kinds of nodes that no operator mutates; most nodes are of these kinds.
_SKIPPED: Final = frozenset(
    {"name", "newline", "string", "endmarker", "fstring_string", "fstring_start", "fstring_end"}
)
_PUNCTUATION: Final = frozenset("()[]{},:.;=")
#: Calls that write messages for people.
_TELLING: Final = frozenset({"print", "warn", "debug", "info", "warning", "error", "write"})
Position = tuple[int, int]
"""Line from 1, column from 0."""


@dataclass(frozen=True, slots=True)
class Mutation:
    """One change of one file."""

    file: str
    """Relative to the repository, with slashes."""
    function: str
    """Qualified name of the function or class around it; empty at the level of the module."""
    line: int
    text: str
    """The line as it is, without indentation."""
    column: int
    """Column in that text where the place begins."""
    end: Position
    nth: int
    """Index of the place among those in its function with the same line and column."""
    operator: str
    index: int
    """Index of the mutation among those by this operator at this place."""
    occurrence: int
    """Index among all mutations by this operator in this file, as cosmic-ray counts them."""

    @property
    def place(self) -> str:
        """A key of the place that stays the same when lines move."""
        return "|".join((self.file, self.function, self.text, str(self.column), str(self.nth)))

    @property
    def key(self) -> str:
        """A key of the mutation that stays the same when lines move."""
        return f"{self.place}|{self.operator}|{self.index}"


def rank(seed: int, text: str) -> str:
    """A pseudo-random rank that depends only on the seed and the text."""
    return hashlib.sha256(f"{seed}|{text}".encode()).hexdigest()


def mutated(source: str, mutation: Mutation) -> str:
    """The file after the mutation."""
    after = MutationVisitor.mutate_code(source, get_operator(mutation.operator)(), mutation.occurrence)
    if after is None:
        raise ValueError(f"{mutation.file}:{mutation.line}: no mutation number {mutation.occurrence} there")
    return str(after)


def changed_line(source: str, mutation: Mutation) -> str:
    """The mutated line, without indentation."""
    return mutated(source, mutation).splitlines()[mutation.line - 1].strip()


def mutations(root: Path, file: str) -> list[Mutation]:
    """All meaningful mutations of a file, in the order of the file."""
    source = (root / file).read_text()
    tree, lines = ast.parse(source), source.splitlines()
    left_out, functions = Spans(_meaningless(tree)), _functions(tree)
    alike: dict[tuple[str, str, int], list[int]] = defaultdict(list)
    indices: Counter[tuple[Position, str]] = Counter()
    out = []
    for start, operator, occurrence, end in sorted((s, o, k, e) for o, k, s, e in _positions(source)):
        if start in left_out:
            continue
        function, text = _around(functions, start[0]), lines[start[0] - 1].strip()
        column = start[1] - lines[start[0] - 1].index(text)
        same = alike[function, text, column]
        if start[0] not in same:
            same.append(start[0])
        nth, index = same.index(start[0]), indices[start, operator]
        indices[start, operator] += 1
        out.append(Mutation(file, function, start[0], text, column, end, nth, operator, index, occurrence))
    return out


def _positions(source: str) -> Iterator[tuple[str, int, Position, Position]]:
    """Operator, occurrence, start and end of every mutation."""
    nodes = [node for node in ast_nodes(get_ast(source)) if not _dull(node)]
    for name, operator in _operators():
        occurrence = 0
        for node in nodes:
            for start, end in operator.mutation_positions(node):
                yield name, occurrence, start, end
                occurrence += 1


@lru_cache(maxsize=1)
def _operators() -> tuple[tuple[str, Any], ...]:
    classes = {name: get_operator(name) for name in sorted(operator_names()) if name not in UNUSED}
    return tuple((name, made()) for name, made in classes.items() if not made.arguments())


def _dull(node: Any) -> bool:
    return node.type in _SKIPPED or (node.type == "operator" and node.value in _PUNCTUATION)


class Spans:
    """The spans of some nodes in a file."""

    def __init__(self, nodes: Iterable[ast.AST]) -> None:
        self._spans = [((n.lineno, n.col_offset), (n.end_lineno, n.end_col_offset)) for n in nodes]  # type: ignore[attr-defined]

    def __contains__(self, at: Position) -> bool:
        return any(start <= at < end for start, end in self._spans)


def _meaningless(tree: ast.Module) -> Iterator[ast.AST]:
    """Nodes whose mutation has no observable effect, or changes only messages for people."""
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            yield from node.decorator_list
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and node.returns:
            yield node.returns
        if isinstance(node, ast.arg) and node.annotation:
            yield node.annotation
        if isinstance(node, ast.AnnAssign):
            yield node if "TypeAlias" in ast.unparse(node.annotation) else node.annotation
        if isinstance(node, ast.Assign) and any(isinstance(t, ast.Name) and t.id == "__all__" for t in node.targets):
            yield node
        if isinstance(node, ast.If) and (
            "TYPE_CHECKING" in ast.unparse(node.test) or "__main__" in ast.unparse(node.test)
        ):
            yield node
        if isinstance(node, ast.Raise) or (isinstance(node, ast.Call) and _name(node.func) in _TELLING):
            yield from (part for part in ast.walk(node) if isinstance(part, ast.JoinedStr))
        if isinstance(node, ast.Call) and _name(node.func) == "zip":  # `strict` only finds coding mistakes
            yield from (keyword.value for keyword in node.keywords if keyword.arg == "strict")


def _name(function: ast.expr) -> str:
    return function.attr if isinstance(function, ast.Attribute) else getattr(function, "id", "")


def _functions(tree: ast.Module) -> list[tuple[int, int, str]]:
    """(first line, last line, qualified name) of every function and class, outer ones first."""
    out: list[tuple[int, int, str]] = []

    def visit(node: ast.AST, prefix: str) -> None:
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
                name = f"{prefix}{child.name}"
                out.append((child.lineno, child.end_lineno or child.lineno, name))
                visit(child, f"{name}.")
            else:
                visit(child, prefix)

    visit(tree, "")
    return out


def _around(functions: list[tuple[int, int, str]], line: int) -> str:
    return next((name for first, last, name in reversed(functions) if first <= line <= last), "")
