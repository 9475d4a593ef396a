"""Which mutations are tried: a random sample that changes only where the code changes.

Every place in the code has a rank, a hash of the seed and of the code there. Each part contributes its places of lowest
rank, in proportion to its number of places, and each place one of its mutations, again by rank. Places are sampled
rather than mutations, because ``a + b`` can be mutated in twelve ways, most of them type errors, and ``and`` in one.
"""

from __future__ import annotations

import contextlib
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from itertools import islice
from pathlib import Path
from typing import Final

from tests.mutants.places import Mutation, mutated, mutations, rank

#: Parts by name: the folder of the code, and that of its own tests.
PARTS: Final[Mapping[str, tuple[str, str]]] = {
    **{
        name: (f"ucon/{name}", f"tests/{name}")
        for name in ("task", "retrieval", "evaluation", "perception", "envs", "learning")
    },
    "readers": ("ucon/readers", "tests/retrieval"),
    "search": ("ucon/search", "tests/envs"),
    "models": ("models", "tests/models"),
}


def part_of(file: str) -> str:
    """Name of the part that a file belongs to."""
    return next(name for name, (folder, _) in PARTS.items() if file.startswith(f"{folder}/"))


def sampled(root: Path, count: int, seed: int) -> list[Mutation]:
    """``count`` mutations of the tree at ``root``, grouped by part."""
    places = {name: _places(root, folder) for name, (folder, _) in PARTS.items()}
    shares = allotted({name: len(found) for name, found in places.items()}, count)
    out: list[Mutation] = []
    for name, found in places.items():
        ranked = sorted(found, key=lambda place: rank(seed, place))
        drawn = (_drawn(root, found[place], seed) for place in ranked)
        out += islice((mutation for mutation in drawn if mutation), shares[name])
    return out


def _drawn(root: Path, found: Sequence[Mutation], seed: int) -> Mutation | None:
    """The mutation of lowest rank that is valid Python; not every ``*`` is an operator (``def f(*, x)``)."""
    for mutation in sorted(found, key=lambda mutation: rank(seed, mutation.key)):
        with contextlib.suppress(SyntaxError):
            compile(mutated((root / mutation.file).read_text(), mutation), mutation.file, "exec")
            return mutation
    return None


def allotted(sizes: Mapping[str, int], count: int) -> dict[str, int]:
    """``count`` divided in proportion to sizes into whole numbers, rounding up the largest remainders."""
    exact = {name: count * size / sum(sizes.values()) for name, size in sizes.items()}
    out = {name: int(share) for name, share in exact.items()}
    for name in sorted(exact, key=lambda name: out[name] - exact[name])[: count - sum(out.values())]:
        out[name] += 1
    return out


def _places(root: Path, folder: str) -> dict[str, list[Mutation]]:
    files = sorted(path.relative_to(root).as_posix() for path in (root / folder).rglob("*.py"))
    return _by_place(mutation for file in files for mutation in mutations(root, file))


def _by_place(found: Iterable[Mutation]) -> dict[str, list[Mutation]]:
    out: dict[str, list[Mutation]] = defaultdict(list)
    for mutation in found:
        out[mutation.place].append(mutation)
    return out
