"""A full disk at any point of a run: saved files stay whole, and the continued run gives the same bytes."""

import errno
import sys
from contextlib import contextmanager

import pytest

from tests.learning.test_run import PLAN, begun, files
from tests.learning.tiny import Line
from ucon.learning.run.checkpoints import LATEST
from ucon.learning.run.training_run import METRICS, TrainingRun

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="limits on files differ elsewhere")


@contextmanager
def room_for(size: int):
    """Limit this process's files to ``size`` bytes, so that writing fails midway, as on a full disk."""
    import resource  # not available on Windows

    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs") / "whole"
    begun(folder).run()
    return folder


def saved(folder):
    """Step of the checkpoint that ``latest`` names, which must be whole; None if nothing was saved yet."""
    again = TrainingRun(folder, Line(), PLAN, {"config": "x"})
    return again.checkpoints.load()[0] if (again.checkpoints.folder / LATEST).exists() else None


def test_a_run_without_room_keeps_what_it_saved_and_goes_on_to_the_same_bytes(whole, tmp_path):
    """The limits are multiples of a twentieth of the longest file: metrics, state or tensors are cut off."""
    longest = max(len(content) for content in files(whole).values())
    stopped_at = set()
    for part in range(1, 20):
        folder = tmp_path / str(part)
        run = begun(folder)
        with pytest.raises(OSError, match="File too large") as caught, room_for(longest * part // 20):
            run.run()
        assert caught.value.errno == errno.EFBIG
        assert not list(folder.rglob(".*")), "half a file under a temporary name takes room"
        step = saved(folder)
        stopped_at.add(step)
        if step is None:
            assert not (folder / "checkpoints").exists() or not run.checkpoints.all()
            continue
        assert run.step - PLAN.save_every <= step <= run.step
        again = TrainingRun(folder, Line(), PLAN, {"config": "x"})
        again.resume()
        again.run()
        assert files(folder) == files(whole)
    assert len(stopped_at) > 4, stopped_at


def test_there_is_room_again_in_the_middle_of_a_save(whole, tmp_path):
    """The same process can continue: a failed save has changed nothing."""
    run = begun(tmp_path / "run")
    with pytest.raises(OSError, match="File too large"), room_for(64):
        run.run()
    assert (tmp_path / "run" / METRICS).stat().st_size <= 64
    with room_for(1 << 20):
        begun(tmp_path / "other").run()
    assert files(tmp_path / "other") == files(whole)
