"""Outcome of all mutants: a table by part, and the survivors."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import yaml

from tests.mutants.places import Mutation
from tests.mutants.sample import PARTS, part_of

EQUIVALENT: Final = Path(__file__).with_name("equivalent.yaml")


@dataclass(frozen=True)
class Outcome:
    """The outcome of one mutant."""

    mutation: Mutation
    after: str
    """The mutated line."""
    killed: bool
    by: str


def known(path: Path = EQUIVALENT) -> dict[tuple[str, str, str, str], str]:
    """Reasons why mutants are equivalent, by file, function, line and mutated line."""
    rows = yaml.safe_load(path.read_text())
    return {(row["file"], row["function"], row["before"], row["after"]): row["reason"] for row in rows}


def reason(outcome: Outcome, equivalent: Mapping[tuple[str, str, str, str], str]) -> str | None:
    """Why a surviving mutant is equivalent; None if it is not listed."""
    mutation = outcome.mutation
    return equivalent.get((mutation.file, mutation.function, mutation.text, outcome.after))


def report(outcomes: Sequence[Outcome], equivalent: Mapping[tuple[str, str, str, str], str]) -> str:
    """The table by part, then every surviving mutant."""
    rows = [("part", "mutants", "killed", "equivalent", "to look at")]
    for name in (*PARTS, "all"):
        of = [one for one in outcomes if name in ("all", part_of(one.mutation.file))]
        lived = [one for one in of if not one.killed]
        excused = sum(reason(one, equivalent) is not None for one in lived)
        rows.append((name, *map(str, (len(of), len(of) - len(lived), excused, len(lived) - excused))))
    table = "\n".join(f"{row[0]:12s}" + "".join(f"{cell:>12s}" for cell in row[1:]) for row in rows)
    return "\n".join([table, *_survivors(outcomes, equivalent)])


def _survivors(outcomes: Iterable[Outcome], equivalent: Mapping[tuple[str, str, str, str], str]) -> list[str]:
    out = []
    for one in outcomes:
        if one.killed:
            continue
        mutation, why = one.mutation, reason(one, equivalent)
        out.append(f"\n{mutation.file}:{mutation.line} {mutation.function}  ({one.by})")
        out += [f"  - {mutation.text}", f"  + {one.after}", f"  {'equivalent: ' + why if why else 'to look at'}"]
    return out


def killed_share(outcomes: Sequence[Outcome]) -> float:
    """Share of all mutants that were killed; survivors listed as equivalent count as alive."""
    return sum(one.killed for one in outcomes) / len(outcomes)
