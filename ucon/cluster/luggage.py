"""What a worker on another machine is sent before it begins: hash of the code, package versions, homes and sets."""

from __future__ import annotations

import os
import platform
import tempfile
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from ucon.core.errors import ConfigError
from ucon.core.files import sha256_bytes, user_cache, write_atomic
from ucon.evaluation.figures.report import code_hash, versions
from ucon.sim import cache
from ucon.task import sets


@dataclass(frozen=True)
class Luggage:
    """What each worker is sent once.

    Attributes:
        code: hash of ``ucon`` and ``models``.
        versions: of Python and the packages that can change a record.
        folder: working folder of the sender, which relative paths in configurations refer to.
        pack: files of a pack by their path within it; empty for none.
    """

    code: str
    versions: Mapping[str, str]
    folder: str
    pack: Mapping[str, bytes]

    @classmethod
    def packed(cls, homes: Iterable[str] = (), episodes: Iterable[str] = (), *, here: bool = False) -> Luggage:
        """Pack for work in some homes.

        Args:
            homes: names of homes; those that are not compiled yet are compiled now.
            episodes: names of sets that the work loads.
            here: True if the workers are on this machine: they find homes and sets, so nothing is packed.
        """
        if here:
            homes = episodes = ()
        with tempfile.TemporaryDirectory() as made:
            folder, names = Path(made), sorted(set(homes))
            if names:
                cache.pack_homes(names, folder / cache.IN_PACK, fresh=False)
            if named := sorted(set(episodes)):
                sets.pack_sets(named, folder / sets.IN_PACK)
            files = sorted(path for path in folder.rglob("*") if path.is_file())
            pack = {path.relative_to(folder).as_posix(): path.read_bytes() for path in files}
        return cls(code_hash(), versions(), str(Path.cwd()), pack)

    def unpack(self) -> None:
        """Prepare this process: compare its code, enter the sender's folder if it is here, and lay out the pack.

        Raises:
            ConfigError: the code or the versions of packages differ.
        """
        host = platform.node()
        if code_hash() != self.code:
            raise ConfigError(
                f"{host}: its ucon ({code_hash()[:12]}) differs from that of this command ({self.code[:12]}); "
                "all machines need the same code, best in a shared folder"
            )
        if others := {name: v for name, v in versions().items() if self.versions.get(name) != v}:
            told = ", ".join(f"{name} {there} instead of {self.versions.get(name)}" for name, there in others.items())
            raise ConfigError(f"{host}: {told}; records can depend on it; install the same versions (constraints.txt)")
        if Path(self.folder).is_dir():
            os.chdir(self.folder)
        if self.pack:
            os.environ["UCON_PACK"] = str(self._laid_out())

    def _laid_out(self) -> Path:
        """Folder that the pack is written to: in the user's cache, or a temporary one if that cannot be written."""
        key = sha256_bytes("".join(f"{name} {sha256_bytes(data)}\n" for name, data in self.pack.items()).encode())
        folder = user_cache() / "packs" / key[:16]
        try:
            self._write(folder)
        except OSError:
            folder = Path(tempfile.mkdtemp(prefix="ucon-pack-"))
            self._write(folder)
        return folder

    def _write(self, folder: Path) -> None:
        for name, data in self.pack.items():
            if not ((path := folder / name).is_file() and path.read_bytes() == data):
                write_atomic(path, data)
