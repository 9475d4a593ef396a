"""Agents made in Python behave as those of the commands: their defaults are what a file in ``configs/`` says."""

from __future__ import annotations

import inspect
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hydra.utils import get_object
from omegaconf import OmegaConf

CONFIGS = Path(__file__).parents[1] / "configs"


def nodes(node: Any) -> Iterator[dict[str, Any]]:
    """Every node of a configuration that builds something."""
    if isinstance(node, dict):
        if str(node.get("_target_")).startswith("models.agents."):
            yield node
        for child in node.values():
            yield from nodes(child)


def said() -> dict[tuple[str, str], set[Any]]:
    """By constructor and argument: the plain values that files give it."""
    out: dict[tuple[str, str], set[Any]] = defaultdict(set)
    for path in sorted(CONFIGS.rglob("*.yaml")):
        for node in nodes(OmegaConf.to_container(OmegaConf.load(path))):
            for name, value in node.items():
                if name[0] != "_" and isinstance(value, bool | int | float | str) and "$" not in str(value) != "???":
                    out[node["_target_"], name].add(value)
    return out


#: What only the agents of known homes are given.
LEFT_OUT = "tour"
SAID = said()


@pytest.mark.parametrize("target", sorted({target for target, _ in SAID}))
def test_defaults_are_those_of_a_configuration(target: str) -> None:
    for name, parameter in inspect.signature(get_object(target)).parameters.items():
        default = parameter.default
        if name != LEFT_OUT and isinstance(default, bool | int | float | str) and (target, name) in SAID:
            assert default in SAID[target, name], name


def test_seeds_are_0() -> None:
    for target in {target for target, _ in SAID}:
        parameter = inspect.signature(get_object(target)).parameters.get("seed")
        assert parameter is None or parameter.default in (0, inspect.Parameter.empty), target
