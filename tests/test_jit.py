"""Compiled kernels are cached by the content of every file that defines one."""

from __future__ import annotations

from pathlib import Path

from ucon.core.jit import kernel_folder, sources_hash

MARKED = "from ucon.core.jit import jit\n"


def test_any_kernel_file_changes_the_folder(tmp_path: Path) -> None:
    package = tmp_path / "rooms"
    package.mkdir()
    (package / "a.py").write_text(MARKED + "A = 1\n")
    (package / "b.py").write_text(MARKED + "B = 1\n")
    (package / "c.py").write_text("C = 1\n")
    before = sources_hash(package)
    (package / "c.py").write_text("C = 2\n")
    assert sources_hash(package) == before, "a file without kernels changes nothing"
    (package / "b.py").write_text(MARKED + "from rooms.c import C\nB = 2\n")
    changed = sources_hash(package)
    assert changed != before
    (package / "c.py").write_text("C = 3\n")
    assert sources_hash(package) != changed, "constants are compiled into kernels"


def test_kernels_are_kept_beside_the_code_of_their_package() -> None:
    from models.nets.end_to_end import way_kernels
    from ucon.perception.views import view_kernels

    assert view_kernels.place_gain.stats.cache_path.startswith(str(kernel_folder()))  # type: ignore[attr-defined]
    kernels = [value for value in vars(way_kernels).values() if hasattr(value, "stats")]
    models = Path(way_kernels.__file__).parents[2]
    assert kernels
    assert kernel_folder(models) != kernel_folder()
    assert all(one.stats.cache_path.startswith(str(kernel_folder(models))) for one in kernels)
