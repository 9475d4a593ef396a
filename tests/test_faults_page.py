"""Every test named on the page on faults exists, and every fault names one."""

import ast
import re
from pathlib import Path

ROOT = Path(__file__).parents[1]
ROWS = re.findall(r"^\| (R\d+) \|(.*)\|$", (ROOT / "docs" / "faults.md").read_text(), re.MULTILINE)


def test_every_fault_names_tests_that_exist():
    assert [name for name, _ in ROWS] == [f"R{number}" for number in range(1, 20)]
    for name, row in ROWS:
        named = re.findall(r"`(tests/[\w/]+\.py)::(\w+)`", row)
        assert named, name
        for path, function in named:
            tree = ast.parse((ROOT / path).read_text())
            assert function in {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}, (
                f"{path}::{function}"
            )
