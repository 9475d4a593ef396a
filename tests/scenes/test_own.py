"""The user's own homes by name: one name, one home; kept for other processes."""

from __future__ import annotations

from pathlib import Path

import pytest

from ucon.core.errors import DataError
from ucon.scenes import home_spec, own, scene_split
from ucon.scenes.own import keep_program, own_program
from ucon.scenes.procedural import procedural_program

PROGRAM = procedural_program("flat", 3)


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("UCON_CACHE", str(tmp_path))
    monkeypatch.setattr(own, "_KNOWN", {})
    return tmp_path


def test_a_program_is_found_by_its_name_in_another_process(monkeypatch: pytest.MonkeyPatch) -> None:
    name = keep_program("Gran's flat!", PROGRAM, 7)
    assert name.startswith("own:gran_s_flat:")
    monkeypatch.setattr(own, "_KNOWN", {})  # as in another process
    assert own_program(name) == (PROGRAM, 7)
    assert home_spec(name).name == name
    assert scene_split(name) == "unseen"
    assert keep_program("Gran's flat!", PROGRAM, 8) != name


def test_names_hold_what_can_be_a_file() -> None:
    for called in ("", "../../x", "日本", "a" * 300, "a/b:c"):
        assert own._NAME.fullmatch(keep_program(called, PROGRAM, 0))


def test_what_is_not_kept_says_what_to_do(cache: Path) -> None:
    with pytest.raises(DataError, match=r"not stored on this machine; give its file again \(python -m ucon home check"):
        own_program("own:my_flat:0123456789ab")
    for odd in ("own:x", "own:../../etc/passwd:0123456789ab", "own:a:0123456789ab/../x"):
        with pytest.raises(DataError, match="expected own:<name>"):
            own_program(odd)


def test_what_was_altered_is_refused(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    name = keep_program("flat", PROGRAM, 0)
    monkeypatch.setattr(own, "_KNOWN", {})
    (file,) = (cache / "own").glob("*.json")
    file.write_text(file.read_text().replace("flat", "house"))
    with pytest.raises(DataError, match="was altered; give its file again"):
        own_program(name)
