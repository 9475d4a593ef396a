"""Things that must not be in the product: unsafe loading of files, and hosts in pinned requirements."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
SOURCES = sorted(
    path for folder in ("ucon", "models", "tests") for path in (ROOT / folder).rglob("*.py")
) + sorted(ROOT.glob("*.py"))  # fmt: skip

#: Full names of functions that may run code from what they read.
UNSAFE = {
    f"{module}.{name}"
    for module in ("pickle", "_pickle", "cPickle", "dill", "cloudpickle", "marshal", "torch.serialization.pickle")
    for name in ("load", "loads", "Unpickler")
} | {"joblib.load", "shelve.open", "pandas.read_pickle", "yaml.unsafe_load", "yaml.full_load"}
#: Functions that do so unless an option has the safe value: the option and that value.
GUARDED = {"torch.load": ("weights_only", True)}
#: Options that allow it, and the only value that they may have.
SAFE_VALUES = {"weights_only": True, "allow_pickle": False, "trust_remote_code": False}
#: Options that must be given when a model is loaded: whether its code is run, and whether the network is used.
OF_FOLDERS = ("local_files_only", "trust_remote_code")
#: Unpickling of data just pickled in the same test, never from files: sending policies and copying environments.
ALLOWED = {
    (f"tests/{name}.py", "pickle.loads")
    for name in (
        "models/test_policies", "envs/test_copies", "envs/test_robot", "sim/robot/test_floor", "habits/test_contexts",
        "retrieval/test_conditions",
    )
}  # fmt: skip


def unsafe(tree: ast.Module) -> Iterator[str]:
    """Everything in a program that may unpickle, found by full names."""
    full = imported(tree)
    for node in ast.walk(tree):
        if isinstance(node, ast.Name | ast.Attribute) and (name := named(node, full)) in UNSAFE:
            yield name
        if isinstance(node, ast.Call):
            yield from unsafe_call(node, named(node.func, full))


def unsafe_call(call: ast.Call, name: str) -> Iterator[str]:
    """Options of a call, or missing ones, that let it unpickle."""
    given = {word.arg: word.value for word in call.keywords}
    for option, safe in SAFE_VALUES.items():
        if option in given and not is_constant(given[option], safe):
            yield f"{option} is not {safe}"
    option, safe = GUARDED.get(name, ("", None))
    if option and option not in given:
        yield f"{name} without {option}={safe}"
    if name.endswith(".from_pretrained"):
        yield from (f"{name} without {option}" for option in OF_FOLDERS if option not in given)
    loader = given.get("Loader", call.args[1] if len(call.args) > 1 else None)
    if name == "yaml.load" and not ast.unparse(loader or ast.Constant(None)).endswith("SafeLoader"):
        yield "yaml.load without SafeLoader"


def is_constant(node: ast.expr, value: object) -> bool:
    return isinstance(node, ast.Constant) and node.value is value


def imported(tree: ast.Module) -> dict[str, str]:
    """Full names of imports, by their local names."""
    found = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found |= {alias.asname: alias.name for alias in node.names if alias.asname}
        if isinstance(node, ast.ImportFrom):
            found |= {alias.asname or alias.name: f"{node.module}.{alias.name}" for alias in node.names}
    return found


def named(node: ast.expr, full: dict[str, str]) -> str:
    """The dotted name of an expression; "" if it has none."""
    if isinstance(node, ast.Name):
        return full.get(node.id, node.id)
    if isinstance(node, ast.Attribute) and (owner := named(node.value, full)):
        return f"{owner}.{node.attr}"
    return ""


@pytest.mark.parametrize("path", SOURCES, ids=lambda p: str(p.relative_to(ROOT)))
def test_nothing_is_unpickled(path):
    name = path.relative_to(ROOT).as_posix()
    found = [what for what in unsafe(ast.parse(path.read_text())) if (name, what) not in ALLOWED]
    if name.startswith("tests/"):  # tests read what they have made themselves
        found = [what for what in found if ".from_pretrained without" not in what]
    assert found == []


@pytest.mark.parametrize(
    ("program", "found"),
    [
        ("import pickle\npickle.load(f)", "pickle.load"),
        ("import pickle as p\np.loads(b)", "pickle.loads"),
        ("from pickle import loads as read\nread(b)", "pickle.loads"),
        ("import pickle\nclass Own(pickle.Unpickler): ...", "pickle.Unpickler"),
        ("import joblib\nread = joblib.load", "joblib.load"),
        ("import torch\ntorch.load(f)", "torch.load without weights_only=True"),
        ("from torch import load\nload(f)", "torch.load without weights_only=True"),
        ("import torch\ntorch.load(f, weights_only=False)", "weights_only is not True"),
        ("import torch\ntorch.load(f, weights_only=safe)", "weights_only is not True"),
        ("import numpy as np\nnp.load(f, allow_pickle = True)", "allow_pickle is not False"),
        ("import numpy as np\nnp.load(f, allow_pickle=1)", "allow_pickle is not False"),
        ("AutoModel.from_pretrained(f, trust_remote_code=False)", "AutoModel.from_pretrained without local_files_only"),
        ("AutoModel.from_pretrained(f, local_files_only=True)", "AutoModel.from_pretrained without trust_remote_code"),
        ("load(f, trust_remote_code=True)", "trust_remote_code is not False"),
        ("import yaml\nyaml.load(f)", "yaml.load without SafeLoader"),
        ("import yaml\nyaml.load(f, yaml.Loader)", "yaml.load without SafeLoader"),
    ],
)
def test_what_unpickles_is_found(program, found):
    assert found in list(unsafe(ast.parse(program)))


@pytest.mark.parametrize(
    "program",
    [
        "import pickle\npickle.dumps(1)",
        "import torch\ntorch.load(f, weights_only=True)",
        "import numpy as np\nnp.load(f, allow_pickle=False)",
        "import yaml\nyaml.load(f, Loader=yaml.SafeLoader)",
        "from safetensors.torch import load\nload(b)",
        "'pickle.load, weights_only=False'",
    ],
)
def test_what_does_not_is_left_alone(program):
    assert list(unsafe(ast.parse(program))) == []


def test_there_are_sources_to_check():
    assert len(SOURCES) > 50


def test_pins_name_no_host_and_parse():
    from packaging.requirements import Requirement

    lines = [line for line in (ROOT / "constraints.txt").read_text().splitlines() if line and line[0] != "#"]
    assert not [line for line in lines if "/" in line or "@" in line or line.startswith("-")]
    assert {Requirement(line).name for line in lines} >= {"torch", "torchrl", "tensordict", "pybullet", "numpy"}
    assert all(str(Requirement(line).specifier).startswith("==") for line in lines)
