"""Constructors that ``configs/`` names, each with its arguments, for tests of stored configurations."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

from hydra import compose, initialize_config_dir
from omegaconf import OmegaConf

CONFIGS = Path(__file__).parents[2] / "configs"
#: Values that files leave to the user, and the agents that parts and learners belong to.
GIVEN = {
    "habits/official": ["habits.path=none"],
    "habits/folder": ["habits.path=none"],
    "part/clip": ["agent=habit_policy_e2e", "agent.policy.clip.path=none"],
    "part/advisor": ["agent=habit_policy_e2e"],
    "part/detr_tokens": ["agent=vtn", "agent.policy.tokens.path=none"],
    "part/imagenet": ["agent=vtn"],
    "part/clip_goal": ["agent=zson", "agent.policy.goal.path=none"],
    "learner/imitation": ["agent=vtn"],
    "learner/searches": ["agent=habit_policy_e2e"],
    "learner/dagger": ["agent=vtn"],
    "learner/image_goal": ["agent=zson", "part=clip_goal", "agent.policy.goal.path=none"],
}
OF_TRAINING = ("learner", "collector", "budget")


def composed(root: str, *overrides: str) -> dict[str, Any]:
    """A configuration as a run stores it."""
    with initialize_config_dir(str(CONFIGS), version_base="1.3"):
        config = compose(root, overrides=[*overrides, "out=runs/test"])
    return OmegaConf.to_container(config, resolve=True, throw_on_missing=True)  # type: ignore[return-value]


@cache
def stored() -> dict[str, dict[str, Any]]:
    """One configuration for every file of a group, by ``group/name``; those of training are composed by ``train``."""
    out = {}
    for file in sorted(CONFIGS.glob("*/*.yaml")):
        group, name = file.parent.name, file.stem
        root = "train" if group in OF_TRAINING else "eval"
        out[f"{group}/{name}"] = composed(root, f"{group}={name}", *GIVEN.get(f"{group}/{name}", ()))
    for file in sorted((CONFIGS / "learner" / "of").glob("*.yaml")):
        out[f"learner/of/{file.stem}"] = composed("train", f"agent={file.stem}")
    return out


def parts(node: Any, place: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], dict[str, Any]]]:
    """Every node with a ``_target_``, with its place."""
    if isinstance(node, dict):
        if "_target_" in node:
            yield place, node
        for name, inner in node.items():
            yield from parts(inner, (*place, name))


@cache
def each() -> dict[str, tuple[tuple[str, ...], dict[str, Any]]]:
    """Every constructor of ``configs/`` once: its place in a stored configuration, and the node stored there."""
    out: dict[str, tuple[tuple[str, ...], dict[str, Any]]] = {}
    for config in stored().values():
        for place, node in parts(config):
            out.setdefault(node["_target_"], (place, node))
    return out
