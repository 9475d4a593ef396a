"""Compiled kernels are kept by the content of every file that defines one."""

from __future__ import annotations

from pathlib import Path

from ucon.core.jit import kernel_folder, sources_hash

MARKED = "from ucon.core.jit import jit\n"


def test_any_kernel_file_changes_the_folder(tmp_path: Path) -> None:
    (tmp_path / "a.py").write_text(MARKED + "A = 1\n")
    (tmp_path / "b.py").write_text(MARKED + "B = 1\n")
    (tmp_path / "c.py").write_text("C = 1\n")
    before = sources_hash(tmp_path)
    (tmp_path / "c.py").write_text("C = 2\n")
    assert sources_hash(tmp_path) == before, "a file without kernels changes nothing"
    (tmp_path / "b.py").write_text(MARKED + "from ucon.c import C\nB = 2\n")
    changed = sources_hash(tmp_path)
    assert changed != before
    (tmp_path / "c.py").write_text("C = 3\n")
    assert sources_hash(tmp_path) != changed, "constants are compiled into kernels"


def test_kernels_are_kept_there() -> None:
    from ucon.perception.views import view_kernels

    assert view_kernels.place_gain.stats.cache_path.startswith(str(kernel_folder()))  # type: ignore[attr-defined]
