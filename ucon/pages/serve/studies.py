"""Studies on disk: a key, and for every rater the sheet that ``habits survey score`` reads.

With every answer, the rater's whole sheet is written again atomically, so that nothing is lost or half written.
"""

from __future__ import annotations

import threading
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from ucon.core.errors import ConfigError, UconError
from ucon.core.files import write_atomic
from ucon.evaluation.datasets.survey import (
    LOOK,
    RatedHabit,
    Rating,
    draw_items,
    key_csv,
    read_key,
    read_sheet,
    sheet_csv,
)
from ucon.evaluation.datasets.survey_score import score_survey
from ucon.habits import HabitDataset
from ucon.pages.serve.desk import checked_name, is_name

_KEY: Final = "key.csv"
#: Largest numbers of studies and raters listed, and the longest sentence: Python's CSV reader takes no longer cell.
_MOST, _LONGEST = 200, 100_000


class Studies:
    """The studies below a folder."""

    def __init__(self, folder: Path, dataset: HabitDataset) -> None:
        """Studies of a dataset.

        Args:
            folder: of all studies.
            dataset: new ones are drawn from it.
        """
        self._folder, self._dataset = folder, dataset
        self._lock = threading.Lock()

    def all(self) -> list[dict[str, Any]]:
        """Name, number of items and raters of every study, newest first."""
        keys = [path for path in self._folder.glob(f"*/{_KEY}") if is_name(path.parent.name)]
        found: list[dict[str, Any]] = []
        for path in sorted(keys, key=_written_s, reverse=True)[:_MOST]:
            try:
                raters = self._raters(path.parent)[:_MOST]
                found.append({"name": path.parent.name, "items": len(read_key(path)), "raters": raters})
            except UconError:  # a damaged key is reported where the study is opened
                found.append({"name": path.parent.name, "items": None, "raters": []})
        return found

    def make(self, name: str, n: int, seed: int) -> None:
        """Draw a study.

        Args:
            name: of the study.
            n: number of items.
            seed: of the draw.

        Raises:
            ConfigError: there is one of this name, or the dataset has fewer items.
            OSError: it cannot be written.
        """
        path = self._folder / checked_name(name, "study") / _KEY
        items = draw_items(self._dataset, n, seed)
        if (longest := max(len(one.habit) for one in items)) > _LONGEST:
            raise ConfigError(
                f"a sentence of {longest} characters is too long to rate; give another seed, or other habits"
            )
        with self._lock:
            if path.exists():
                raise ConfigError(f"a study '{name}' already exists; open it, or give another name")
            write_atomic(path, key_csv(items))

    def key(self, name: str) -> dict[int, RatedHabit]:
        """The items of a study.

        Args:
            name: of the study.

        Raises:
            ConfigError: there is none of this name.
            DataError: its key is damaged.
        """
        path = self._folder / checked_name(name, "study") / _KEY
        if not path.is_file():
            raise ConfigError(f"there is no study '{name}'; create it first")
        return read_key(path)

    def answers(self, name: str, rater: str) -> dict[int, Rating]:
        """What a rater has answered so far, by item.

        Args:
            name: of the study.
            rater: who answers.

        Raises:
            ConfigError: no such study, or a name that cannot be one.
            DataError: the sheet is damaged.
        """
        path, key = self.sheet(name, rater), self.key(name)
        if not path.is_file():
            return {}
        return {one.item: one for one in read_sheet(path, key)}

    def answer(self, name: str, rater: str, item: int, real: int | None, look: str | None) -> dict[int, Rating]:
        """Store an answer.

        Args:
            name: of the study.
            rater: who answers.
            item: number of the item.
            real: 1 to 5, or None for no answer.
            look: yes, no, unsure, or None for no answer.

        Returns:
            All of the rater's answers.

        Raises:
            ConfigError: no such study or item, or no such answer.
            DataError: the sheet is damaged.
            OSError: it cannot be written; the answer does not count then.
        """
        if real not in (None, 1, 2, 3, 4, 5) or look not in (None, *LOOK):
            raise ConfigError("expected 1 to 5 and yes, no or unsure, or no answer")
        with self._lock:
            key = self.key(name)
            if item not in key:
                raise ConfigError(f"item {item}: not in the study '{name}'")
            said = self.answers(name, rater) | {item: Rating(item, rater, real, look)}
            path = self.sheet(name, rater)
            if any(one.real is not None or one.look for one in said.values()):
                write_atomic(path, sheet_csv(list(key.values()), said))
            else:
                path.unlink(missing_ok=True)  # a sheet without answers is not kept
            return said

    def figures(self, name: str) -> Mapping[str, Any] | None:
        """Means, intervals and agreement of all raters; None before the first answer.

        Args:
            name: of the study.

        Raises:
            ConfigError: no such study.
            DataError: key or sheets are damaged.
        """
        key, folder = self.key(name), self._folder / name
        answers = [one for rater in self._raters(folder) for one in read_sheet(self.sheet(name, rater), key)]
        return score_survey(key, answers) if answers else None

    def sheet(self, name: str, rater: str) -> Path:
        """Where a rater's sheet is.

        Args:
            name: of the study.
            rater: who answers.

        Raises:
            ConfigError: a name that cannot be one.
        """
        return self._folder / checked_name(name, "study") / "sheets" / f"{checked_name(rater, 'name')}.csv"

    def key_file(self, name: str) -> Path:
        """Where the key of a study is.

        Args:
            name: of the study.
        """
        return self._folder / checked_name(name, "study") / _KEY

    def _raters(self, folder: Path) -> list[str]:
        """All raters who have a sheet; other files, such as ``ann copy.csv``, do not count."""
        return sorted(path.stem for path in (folder / "sheets").glob("*.csv") if is_name(path.stem))


def _written_s(path: Path) -> float:
    """When a file was last written; 0 where it was removed in between."""
    try:
        return path.stat().st_mtime
    except OSError:
        return 0.0
