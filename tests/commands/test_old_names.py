"""Stored configurations are translated to today's names, and a removed argument that had an effect is an error."""

from __future__ import annotations

import inspect
from pathlib import Path

import pytest
import yaml
from hydra.utils import get_object

from ucon.configuration import old_names
from ucon.configuration.arguments import arguments_of
from ucon.configuration.old_names import GONE, MOVED, REMOVED, RENAMED, in_todays_names
from ucon.core.errors import DataError

RESULTS = Path(__file__).resolve().parents[2] / "results"
STORED = sorted(RESULTS.glob("*/config.yaml"))


def targets(node: object) -> set[str]:
    if isinstance(node, list):
        return {name for inner in node for name in targets(inner)}
    if not isinstance(node, dict):
        return set()
    own = {node["_target_"]} if "_target_" in node else set()
    return own | {name for inner in node.values() for name in targets(inner)}


def test_every_new_name_is_there_and_no_old_one_is() -> None:
    for old, new in MOVED.items():
        assert callable(get_object(new))
        assert new not in MOVED
        with pytest.raises(Exception, match=r"(?i)locat|import|module"):
            get_object(old)


def test_every_renamed_argument_has_its_new_name_alone() -> None:
    for target, names in RENAMED.items():
        known = arguments_of(target).keys()
        assert set(names.values()) <= known
        assert not names.keys() & known


def test_every_argument_that_is_gone_is_gone() -> None:
    for target, arguments in GONE.items():
        assert not arguments.keys() & inspect.signature(get_object(target)).parameters.keys()


@pytest.mark.parametrize("path", STORED, ids=lambda path: path.parent.name)
def test_what_results_name_is_there(path: Path) -> None:
    config = in_todays_names(yaml.safe_load(path.read_text()), str(path))
    assert [name for name in sorted(targets(config)) if not callable(get_object(name))] == []


def test_at_any_depth(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(old_names, "MOVED", {"a.Old": "b.New"})
    monkeypatch.setattr(old_names, "GONE", {"b.New": {"shape": "round"}})
    stored = {"x": [{"_target_": "a.Old", "shape": "round", "size": {"_target_": "c.Kept"}}], "y": 1}
    monkeypatch.setattr(old_names, "RENAMED", {"b.New": {"length": "size"}})
    assert in_todays_names({"_target_": "b.New", "length": 2}, "f") == {"_target_": "b.New", "size": 2}
    assert in_todays_names(stored, "f") == {"x": [{"_target_": "b.New", "size": {"_target_": "c.Kept"}}], "y": 1}
    with pytest.raises(DataError, match=r"^f: shape=square of b.New was removed"):
        in_todays_names({"x": {"_target_": "a.Old", "shape": "square"}}, "f")


def test_a_constructor_that_is_gone_says_why() -> None:
    for old in REMOVED:
        with pytest.raises(DataError, match=rf"^f: {old} is gone \(.*; play the run with the commit"):
            in_todays_names({"env": {"detector": {"rates": {"_target_": old}}}}, "f")
