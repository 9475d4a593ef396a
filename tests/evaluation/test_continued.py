"""A run that was interrupted and continued leaves the same bytes as one that was not, except for its seconds."""

import shutil

import pytest

from tests.models.playing import config_of
from ucon.evaluation.kept.folder import RunFolder
from ucon.evaluation.kept.seal import CONFIG, DECISIONS, PARTIAL, RECORDS, SECONDS, SUMMARY, TIMING
from ucon.programs.evaluating import Evaluation

EQUAL = (RECORDS, DECISIONS, SUMMARY)


def play(out, workers=0):
    options = ("limit=4", "pictures=0", "progress=false", f"workers={workers}", f"out={out}")
    run = Evaluation(config_of("lgx", "habit_level=retrieval", *options), out)
    run.play()
    return run.n_new


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The moved folder of an uninterrupted run; next to it, its partial file as it was at the end."""
    base, patch = tmp_path_factory.mktemp("continued"), pytest.MonkeyPatch()
    finish = RunFolder.finish

    def keep_partial(self, *arguments):
        shutil.copy(self.path / PARTIAL, base / PARTIAL)
        finish(self, *arguments)

    with patch.context() as patched:
        patched.setattr(RunFolder, "finish", keep_partial)
        assert play(base / "run") == 4
    return (base / "run").rename(base / "whole")


@pytest.mark.parametrize(("kept", "cut", "workers"), [(0, 0, 0), (1, 30, 0), (2, 1, 2), (3, 900, 0), (4, 0, 2)])
def test_interrupted_anywhere_and_continued_it_is_the_same_run(whole, kept, cut, workers):
    lines = (whole.parent / PARTIAL).read_bytes().splitlines(keepends=True)
    out = whole.parent / "run"
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir()
    rest = lines[kept + 1][:cut] if kept < 4 else b""
    (out / PARTIAL).write_bytes(b"".join(lines[: kept + 1]) + rest)
    assert play(out, workers) == 4 - kept
    names = {path.name for path in whole.iterdir()}
    assert names == {path.name for path in out.iterdir()} == {*EQUAL, CONFIG, TIMING, SECONDS}
    for name in (*EQUAL, *(() if workers else (CONFIG,))):
        assert (out / name).read_bytes() == (whole / name).read_bytes(), name
