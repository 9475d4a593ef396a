"""Agents made in Python behave like those of the commands: defaults match a file in ``configs/``."""

from __future__ import annotations

import inspect
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hydra.utils import get_object
from omegaconf import OmegaConf

from ucon.language.models.encoder import EncoderModel

CONFIGS = Path(__file__).parents[2] / "configs"


def nodes(node: Any) -> Iterator[dict[str, Any]]:
    """Every node of a configuration that builds an agent."""
    if isinstance(node, dict):
        if str(node.get("_target_")).startswith("models.agents."):
            yield node
        for child in node.values():
            yield from nodes(child)


def said() -> dict[tuple[str, str], set[Any]]:
    """The plain values given in files, by constructor and argument."""
    out: dict[tuple[str, str], set[Any]] = defaultdict(set)
    for path in sorted(CONFIGS.rglob("*.yaml")):
        for node in nodes(OmegaConf.to_container(OmegaConf.load(path))):
            for name, value in node.items():
                if name[0] != "_" and isinstance(value, bool | int | float | str) and "$" not in str(value) != "???":
                    out[node["_target_"], name].add(value)
    return out


#: Given only to the agents of known homes.
LEFT_OUT = "tour"
SAID = said()
assert len(SAID) > 30, "there are agents"


@pytest.mark.parametrize("target", sorted({target for target, _ in SAID}))
def test_defaults_are_those_of_a_configuration(target: str) -> None:
    """They also suffice: an agent that needs at most a language model can be made with them."""
    parameters = inspect.signature(get_object(target)).parameters
    for name, parameter in parameters.items():
        default = parameter.default
        if name != LEFT_OUT and isinstance(default, bool | int | float | str) and (target, name) in SAID:
            assert default in SAID[target, name], name
    assert "seed" not in parameters or parameters["seed"].default == 0
    needed = {name for name, one in parameters.items() if one.default is inspect.Parameter.empty}
    if needed <= {"language"}:
        get_object(target)(**dict.fromkeys(needed, EncoderModel()))
