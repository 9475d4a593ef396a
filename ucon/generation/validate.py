"""Step 2 of the pipeline: every placement is tried in PyBullet in every named home that has its anchor.

An anchor that no named home has is added to two homes, chosen by the triple's name.

A trial puts the object at up to :data:`ANCHORS_TRIED` instances of the anchor in the otherwise unchanged home, lets it
settle, and tests whether an agent within reach could see it. If no instance works, the triple is refused with the last
reason. Trials are independent and seeded by what they try, so verdicts depend neither on their order nor on the number
of processes. Finished blocks are kept on disk, so that an interrupted call is continued.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Final

import ucon
from ucon.core.errors import DataError
from ucon.core.files import canonical_json, require_writable, sha256_bytes, write_atomic
from ucon.core.pool import Pool
from ucon.core.rng import stream
from ucon.core.untrusted.plain_file import read_bounded
from ucon.core.untrusted.strict_json import MAX_BYTES, parse_json
from ucon.habits.types import HabitDataset
from ucon.habits.verdicts import NEVER_SEEN, Triple, Verdict, Verdicts
from ucon.scenes import SCENES
from ucon.sim.arrangement import Arrangement
from ucon.sim.cache import fingerprint, load_house
from ucon.sim.house import House
from ucon.sim.placement import RefusedError, implausible, import_anchor, place, with_object
from ucon.sim.render import RasterRenderer
from ucon.sim.state import SceneState
from ucon.task.rules import PAPER
from ucon.task.solve import Solver

ANCHORS_TRIED = 4
HOMES_IMPORTED_INTO = 2
_BLOCK = 200
_DECIDES: Final = (
    *("sim/placement", "sim/render", "task/rules.py", "task/search.py", "task/solve.py"),
    "generation/validate.py",
)

Progress = Callable[[int, int], None]


@dataclass(frozen=True, slots=True)
class Trials:
    """Triples to try in one home; an absent anchor is put at up to ``spots`` places."""

    home: str
    triples: tuple[Triple, ...]
    spots: int = 1

    @property
    def key(self) -> str:
        """Hash of what is tried, of the home, and of the code that decides; names the file of the results."""
        what = [self.home, load_house(self.home).spec.hash, self.triples, self.spots, code_version()]
        return sha256_bytes(canonical_json(what).encode())[:24]


@lru_cache(maxsize=1)
def code_version() -> str:
    """SHA-256 of all sources that decide a trial, so that verdicts of other versions are not used."""
    root = Path(ucon.__file__).parent
    sources = [root / name for name in _DECIDES]
    files = [path for source in sources for path in (sorted(source.rglob("*.py")) if source.is_dir() else [source])]
    return sha256_bytes("\n".join([fingerprint(), *(sha256_bytes(path.read_bytes()) for path in files)]).encode())


def dataset_triples(dataset: HabitDataset) -> dict[str, list[Triple]]:
    """The triples to try, by home: an entry's own scene if it is bound to one, else every home with the anchor."""
    found: dict[str, set[Triple]] = {home: set() for home in SCENES}
    free: set[Triple] = set()
    for entry in dataset.entries:
        triples = {(entry.category, place.relation, place.anchor) for place in entry.placements}
        if entry.scene is None:
            free |= triples
        elif entry.scene in found:
            found[entry.scene] |= triples
    present = {home: frozenset(load_house(home).categories) for home in SCENES}
    for triple in free:
        homes = [home for home in SCENES if triple[2] in present[home]]
        if not homes:
            order = stream(0, "validate", "import", *triple).permutation(len(SCENES))
            homes = [SCENES[k] for k in order[:HOMES_IMPORTED_INTO]]
        for home in homes:
            found[home].add(triple)
    return {home: sorted(triples) for home, triples in found.items()}


def validate(
    wanted: dict[str, list[Triple]],
    folder: Path,
    *,
    workers: int = 2,
    spots: int = 1,
    progress: Progress | None = None,
) -> Verdicts:
    """Try triples in their homes.

    Args:
        wanted: triples by home, see :func:`dataset_triples`.
        folder: of finished blocks, which are not tried again.
        workers: processes; 0 or 1 tries everything in this one.
        spots: most places at which an absent anchor is put, one after the other.
        progress: called with (trials done, trials in all).
    """
    blocks = [
        Trials(home, tuple(triples[start : start + _BLOCK]), spots)
        for home, triples in wanted.items()
        for start in range(0, len(triples), _BLOCK)
    ]
    total, done = sum(len(block.triples) for block in blocks), 0
    refused: defaultdict[Triple, dict[str, str]] = defaultdict(dict)
    tried: defaultdict[Triple, int] = defaultdict(int)
    for block, reasons in _results(blocks, folder, workers):
        for triple, reason in zip(block.triples, reasons, strict=True):
            tried[triple] += 1
            if reason is not None:
                refused[triple][block.home] = reason
        done += len(block.triples)
        if progress:
            progress(done, total)
    return Verdicts({triple: Verdict(count, dict(sorted(refused[triple].items()))) for triple, count in tried.items()})


def try_triple(house: House, triple: Triple, eyes: RasterRenderer, spots: int = 1) -> str | None:
    """Try one triple in a home.

    Args:
        house: the home.
        triple: category, relation, anchor.
        eyes: a renderer.
        spots: most places at which an absent anchor is put.

    Returns:
        None where the object can be placed and seen, else the reason.
    """
    reason: str | None = None
    for spot in range(1 if triple[2] in house.categories else spots):
        reason = _try_at(house, triple, eyes, spot)
        if reason is None or implausible(*triple) is not None:  # type: ignore[arg-type]
            break
    return reason


def _try_at(house: House, triple: Triple, eyes: RasterRenderer, spot: int) -> str | None:
    """One trial; ``spot`` is the number of places tried before for an absent anchor."""
    category, relation, anchor = triple
    home, again = house.spec.name, (f"spot {spot}",) if spot else ()
    try:
        before, instances = _with_anchor(house, anchor, again)
    except RefusedError as error:
        return error.reason
    reason: str = "absent_anchor"
    for k in stream(0, "validate", home, *triple, *again).permutation(instances)[:ANCHORS_TRIED]:
        size = house.spec.items[k].size if k < house.n_items else None
        if (refusal := implausible(category, relation, anchor, size)) is not None:  # type: ignore[arg-type]
            reason = refusal[0]
            continue
        try:
            rng = stream(0, "validate", home, *triple, *again, int(k))
            placed = place(house, before, category, relation, int(k), rng)  # type: ignore[arg-type]
        except RefusedError as error:
            reason = error.reason
            continue
        arrangement = with_object(house, before, placed)
        eyes.load(house, arrangement)
        target = house.n_instances + len(before.objects)
        if Solver(SceneState(house, arrangement), eyes, target, PAPER).findable:
            return None
        reason = NEVER_SEEN
    return reason


def _with_anchor(house: House, anchor: str, again: tuple[str, ...]) -> tuple[Arrangement, list[int]]:
    """The arrangement with the anchor (added if the home lacks one), and the anchor's instances."""
    there = [k for k, name in enumerate(house.categories) if name == anchor]
    if there:
        return Arrangement(), there
    rng = stream(0, "validate", "import", house.spec.name, anchor, *again)
    brought = import_anchor(house, Arrangement(), anchor, rng)
    return with_object(house, Arrangement(), brought), [house.n_instances]


def _results(blocks: Sequence[Trials], folder: Path, workers: int) -> Iterator[tuple[Trials, list[str | None]]]:
    """Reasons of every block in order: those on disk at once, the others as they finish."""
    missing = [block for block in blocks if not _path(folder, block).is_file()]
    there = set(blocks) - set(missing)
    if missing:
        require_writable(_path(folder, missing[0]))
    for block in blocks:
        if block in there:
            yield block, _read(_path(folder, block), block)
    if workers <= 1:
        computed: Iterable[list[str | None]] = map(_try_block, missing)
        yield from _kept(missing, computed, folder)
        return
    with Pool(workers) as pool:
        yield from _kept(missing, pool.map(_try_block, missing), folder)


def _kept(
    blocks: Sequence[Trials], computed: Iterable[list[str | None]], folder: Path
) -> Iterator[tuple[Trials, list[str | None]]]:
    for block, reasons in zip(blocks, computed, strict=True):
        write_atomic(_path(folder, block), canonical_json(reasons))
        yield block, reasons


def _try_block(block: Trials) -> list[str | None]:
    house, eyes = load_house(block.home), RasterRenderer()
    return [try_triple(house, triple, eyes, block.spots) for triple in block.triples]


def _path(folder: Path, block: Trials) -> Path:
    return folder / f"{block.home}-{block.key}.json"


def _read(path: Path, block: Trials) -> list[str | None]:
    try:
        reasons = parse_json(read_bounded(path, MAX_BYTES))
        whole = isinstance(reasons, list) and len(reasons) == len(block.triples)
        if whole and all(r is None or isinstance(r, str) for r in reasons):
            return list(reasons)
    except (OSError, ValueError):
        pass
    raise DataError(f"{path}: not the verdicts of {len(block.triples)} triples; remove the file and it is made again")
