"""What a run's hashes cover."""

from __future__ import annotations

from pathlib import Path

import pytest

from ucon.evaluation import report


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A clone in small."""
    monkeypatch.setattr(report.ucon, "__file__", str(tmp_path / "ucon" / "__init__.py"))
    for name in (
        "ucon/__init__.py",
        "ucon/retrieval/data/reader.npz",
        "models/vtn.py",
        "models/agents/prompts/lgx.txt",
    ):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("as it was")
    return tmp_path


def hashed() -> str:
    report.code_hash.cache_clear()
    try:
        return report.code_hash()
    finally:
        report.code_hash.cache_clear()


@pytest.mark.parametrize("name", ["ucon/retrieval/data/reader.npz", "models/vtn.py", "models/agents/prompts/lgx.txt"])
def test_data_and_prompts_count_as_code_does(package: Path, name: str) -> None:
    before = hashed()
    (package / name).write_text("otherwise")
    assert hashed() != before


@pytest.mark.parametrize("name", ["ucon/__pycache__/x.pyc", "ucon/data/.x.swp", "models/runs/weights.safetensors"])
def test_what_is_not_shipped_does_not(package: Path, name: str) -> None:
    before = hashed()
    (package / name).parent.mkdir(parents=True, exist_ok=True)
    (package / name).write_text("new")
    assert hashed() == before
