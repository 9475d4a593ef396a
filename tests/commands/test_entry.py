"""The one-line error when the disk fills up in the middle of ``eval.py`` or ``train.py``."""

from __future__ import annotations

from pathlib import Path

import pytest

from ucon.programs.errors import USER_ERROR, one_line_errors

FULL = Path("/dev/full")


@pytest.mark.skipif(not FULL.exists(), reason="no /dev/full here")
@pytest.mark.parametrize(("program", "again"), [("eval", "the same out="), ("train", "resume=RUN")])
def test_a_full_disk_is_one_line_that_says_how_to_go_on(
    program: str, again: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended, one_line_errors(program):
        FULL.write_bytes(b"a record\n")
    told = capsys.readouterr().err
    assert ended.value.code == USER_ERROR
    assert told.count("\n") == 1
    assert "No space left on device" in told
    assert again in told


def test_a_file_that_our_own_code_lost_is_a_bug_and_keeps_its_traceback() -> None:
    with pytest.raises(FileNotFoundError), one_line_errors("eval"):
        Path("there/is/no/such/file").read_text(encoding="utf-8")
