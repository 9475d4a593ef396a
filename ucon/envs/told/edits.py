"""Edits: single sentences that are left out or replaced in single episodes. Read from a file, which is checked.

A line of the file is a JSON object, such as
``{"episode": "test/seen_category/seen_scene/003", "habit": "Tea bags live by the tea set.", "instead": null}``; null
leaves the sentence out.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import DataError, EpisodeError, brief
from ucon.core.files import canonical_json, sha256_bytes, write_atomic
from ucon.core.sharing import Shared
from ucon.core.text import is_shown
from ucon.core.untrusted.plain_file import read_plain
from ucon.core.untrusted.typed import parse_line, read_as

_MOST_BYTES: Final = 1 << 24
_MOST_CHARACTERS: Final = 1000
_FORM: Final = "expected lines with episode, habit and instead"


@dataclass(frozen=True, slots=True)
class Edit:
    """One sentence that is left out or replaced in one episode."""

    episode: str
    """Id of the episode."""
    habit: str
    """The sentence, which must be among those that the agent would be given."""
    instead: str | None
    """Sentence given in its place; None: nothing."""

    def to_line(self) -> str:
        """One line of canonical JSON, without the line break."""
        return canonical_json(asdict(self))


@dataclass(frozen=True, eq=False)
class Edits(Shared):
    """The edits of a file."""

    edits: tuple[Edit, ...]
    where: str
    """The file, for errors."""

    @classmethod
    def read(cls, path: str | Path) -> Edits:
        """Read a file of edits.

        Args:
            path: path of the file, whose content is not trusted.

        Raises:
            DataError: there is no such file, it is empty, or a line is not an edit, repeats a sentence, or holds
                unprintable text.
        """
        where = str(path)
        if not Path(path).is_file():
            raise DataError(f"{where}: no such file of edits; {_FORM}, or leave env.source.edits out")
        found: list[Edit] = []
        seen: set[tuple[str, str]] = set()
        for number, line in enumerate(read_plain(Path(path), _MOST_BYTES).splitlines(), 1):
            at = f"{where}:{number}"
            edit = read_as(Edit, parse_line(line, at, f"{_FORM}; fix the line"), at, "an edit", remedy="fix the line")
            for text in (edit.episode, edit.habit, *(() if edit.instead is None else (edit.instead,))):
                if not text.strip() or len(text) > _MOST_CHARACTERS or not is_shown(text):
                    raise DataError(f"{at}: expected plain text of 1 to {_MOST_CHARACTERS} characters; fix the line")
            if (edit.episode, edit.habit) in seen:
                raise DataError(f"{at}: a second edit of the same sentence of {brief(edit.episode)}; keep one")
            seen.add((edit.episode, edit.habit))
            found.append(edit)
        if not found:
            raise DataError(f"{where}: empty; {_FORM}")
        return cls(tuple(found), where)

    @cached_property
    def texts(self) -> tuple[str, ...]:
        """The T sentences that are given in place of others, each once."""
        return tuple(dict.fromkeys(edit.instead for edit in self.edits if edit.instead is not None))

    @cached_property
    def episodes(self) -> frozenset[str]:
        """Ids of the episodes that are edited."""
        return frozenset(edit.episode for edit in self.edits)

    @cached_property
    def sha256(self) -> str:
        """SHA-256 of the edits, in hexadecimal."""
        return sha256_bytes("\n".join(edit.to_line() for edit in self.edits).encode())

    def applied(self, episode: str, rows: NDArray[np.int32], texts: Sequence[str], first: int) -> NDArray[np.int32]:
        """The rows that an agent is given after the edits.

        Args:
            episode: id of the episode.
            rows: (n,) rows of the sentences before the edits.
            texts: these sentences.
            first: row of the first of :attr:`texts`, which is the number of rows of the dataset.

        Returns:
            (m,) int32, in the same order; rows from ``first`` on are those of :attr:`texts`.

        Raises:
            EpisodeError: a sentence to edit is not among ``texts``.
        """
        out: list[int | None] = rows.tolist()
        for edit in self._by_episode.get(episode, ()):
            if edit.habit not in texts:
                raise EpisodeError(
                    f"{self.where}: episode {episode} is not given '{brief(edit.habit)}'; expected one of its "
                    f"{len(texts)} habits at this level"
                )
            place = list(texts).index(edit.habit)
            out[place] = None if edit.instead is None else first + self.texts.index(edit.instead)
        return np.array([row for row in out if row is not None], np.int32)

    @cached_property
    def _by_episode(self) -> dict[str, list[Edit]]:
        found: dict[str, list[Edit]] = {}
        for edit in self.edits:
            found.setdefault(edit.episode, []).append(edit)
        return found


def save_edits(edits: Iterable[Edit], path: Path) -> None:
    """Write edits in the form that :meth:`Edits.read` reads."""
    write_atomic(path, "".join(f"{edit.to_line()}\n" for edit in edits).encode())
