"""Shipped weights fit the configured agents and are whole, small and described."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from models.agents.checkpoint import FOLDER, SHIPPED
from tests.models.playing import CONFIGS, config_of
from ucon.configuration.wiring import Factory
from ucon.core.files import MANIFEST, read_verified

FOLDERS = sorted(path for path in FOLDER.iterdir() if path.is_dir())
AGENTS = [
    name
    for name in sorted(path.stem for path in (CONFIGS / "agent").glob("*.yaml"))
    if config_of(name)["agent"].get("checkpoint") == SHIPPED
]


@pytest.mark.parametrize("folder", FOLDERS, ids=lambda path: path.name)
def test_weights_are_whole_small_and_described(folder: Path) -> None:
    named = json.loads((folder / "model" / MANIFEST).read_text())["files"]
    files = {path.name for path in (folder / "model").iterdir()} - {MANIFEST}
    assert files == set(named)
    assert sum(len(read_verified(folder / "model" / name)) for name in files) < 20e6
    card = (folder / "MODEL_CARD.md").read_text()
    assert all(f"## {part}" in card for part in ("Validation, best checkpoint", "Made from", "Licence"))
    assert (folder / "config.yaml").is_file()


@pytest.mark.parametrize("name", AGENTS)
def test_they_fit_their_agent(name: str) -> None:
    agent = Factory(config_of(name)["agent"])()
    agent.check()
    assert agent.fingerprint()
    assert sum(value.numel() for value in agent.policy.parameters()) < 5e6


def test_the_habit_policies_come_trained() -> None:
    assert {"habit_policy", "habit_policy_e2e"} <= set(AGENTS)
