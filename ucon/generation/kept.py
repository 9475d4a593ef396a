"""Verdicts of imported datasets, kept in the user's cache, so that nothing is tried twice.

They are stored by home and triple, so that the release's files, which have most locations in common, share them; and
separately for every version of the code that decides them.
"""

from __future__ import annotations

from pathlib import Path

from ucon.core.errors import DataError
from ucon.core.files import canonical_json, user_cache, write_atomic
from ucon.core.untrusted.plain_file import read_bounded
from ucon.core.untrusted.strict_json import MAX_BYTES, parse_json
from ucon.generation.validate import ANCHORS_TRIED, Progress, code_version, dataset_triples, validate
from ucon.habits.types import HabitDataset
from ucon.habits.verdicts import Triple, Verdict, Verdicts
from ucon.task.making.placeable import refusal

Tried = dict[Triple, str | None]
"""Why one home refuses a triple, by triple; None where it accepts it."""


def tried(dataset: HabitDataset, *, workers: int = 2, progress: Progress | None = None) -> Verdicts:
    """Verdicts on all placements of a dataset, found by trying them; those with a known verdict are not tried again.

    An anchor that a home lacks is put at as many places as instances of an existing anchor are tried.

    Args:
        dataset: entries, bound to scenes or not.
        workers: processes.
        progress: called with (trials done, trials in all) of those that are not known yet.
    """
    wanted, folder = dataset_triples(dataset), kept_folder()
    known = {home: _read(_path(folder, home)) for home, triples in wanted.items() if triples}
    missing = {home: [t for t in wanted[home] if t not in found] for home, found in known.items()}
    if any(missing.values()):
        found = validate(missing, folder / "blocks", workers=workers, spots=ANCHORS_TRIED, progress=progress)
        for home, triples in missing.items():
            known[home] |= {triple: found.of[triple].refused.get(home) for triple in triples}
            write_atomic(_path(folder, home), canonical_json([[*t, why] for t, why in sorted(known[home].items())]))
    return _verdicts({home: {t: found[t] for t in wanted[home]} for home, found in known.items()})


def shape_verdicts(dataset: HabitDataset) -> Verdicts:
    """Verdicts by shapes alone, the same on every machine."""
    wanted = dataset_triples(dataset)
    return _verdicts({home: {t: refusal(home, t) for t in triples} for home, triples in wanted.items()})


def kept_folder() -> Path:
    """Folder of the verdicts of this version of the code."""
    return user_cache() / "validate" / f"imported-{code_version()[:16]}"


def _verdicts(by_home: dict[str, Tried]) -> Verdicts:
    tried_in: dict[Triple, int] = {}
    refused: dict[Triple, dict[str, str]] = {}
    for home, found in by_home.items():
        for triple, reason in found.items():
            tried_in[triple] = tried_in.get(triple, 0) + 1
            if reason is not None:
                refused.setdefault(triple, {})[home] = reason
    return Verdicts({triple: Verdict(count, refused.get(triple, {})) for triple, count in tried_in.items()})


def _path(folder: Path, home: str) -> Path:
    return folder / f"{home}.json"


def _read(path: Path) -> Tried:
    try:
        rows = parse_json(read_bounded(path, MAX_BYTES))
        found: Tried = {(c, r, a): why for c, r, a, why in rows}
        if not all(isinstance(text, str) for triple, why in found.items() for text in (*triple, why or "")):
            raise TypeError("texts")
    except FileNotFoundError:
        return {}
    except (OSError, ValueError, TypeError):
        raise DataError(f"{path}: not a list of verdicts; remove the file and it is made again") from None
    return found
