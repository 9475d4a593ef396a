"""The second hop: where a thing is that lies by something which has been moved itself.

b(target at x) = sum over anchors a of p(a) b_a(x), where b_a is the belief about a movable anchor. Three hops at most;
what was followed once is not followed again, so cycles ("the cup is by the book, the book is by the cup") end.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence

DEPTH = 3
#: Mass below which an anchor is not worth asking for.
LEAST = 0.01
Beliefs = Callable[[Sequence[str]], Sequence[Mapping[str, float]]]
"""Where things may be, for several at once: probability by anchor."""


def compose(
    target: str,
    belief: Mapping[str, float],
    movable: Collection[str],
    beliefs: Beliefs,
    depth: int = DEPTH,
    least: float = LEAST,
) -> dict[str, float]:
    """Probability by anchor after the mass of movable anchors went on to where these may be.

    Args:
        target: what is looked for; nothing is by it.
        belief: its own belief over anchors; need not add up to 1, the sum is kept.
        movable: anchors that may have been moved themselves.
        beliefs: asked once a hop, for all anchors to be followed.
        depth: hops; 0 gives ``belief`` back.
        least: mass below which an anchor keeps what it has.
    """
    mass = dict(belief)
    visited = {target}
    for _ in range(depth):
        follow = [name for name in mass if name in movable and name not in visited and mass[name] >= least]
        if not follow:
            break
        visited.update(follow)
        for name, found in zip(follow, beliefs(follow), strict=True):
            _pass_on(mass, name, {x: p for x, p in found.items() if x not in visited and p > 0})
    return mass


def _pass_on(mass: dict[str, float], name: str, found: Mapping[str, float]) -> None:
    """Give an anchor's mass to where it may be, in proportion; it keeps it where that is nowhere."""
    total = sum(found.values())
    if total <= 0:
        return
    given = mass.pop(name)
    for x, p in found.items():
        mass[x] = mass.get(x, 0.0) + given * p / total
