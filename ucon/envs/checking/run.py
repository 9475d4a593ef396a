"""Which checks apply to which environment, and a function that runs them one after the other."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Final

from ucon.core.errors import brief
from ucon.envs.checking import choices, contract, knowledge, outcomes, senses
from ucon.envs.checking.findings import Finding
from ucon.envs.checking.subject import Subject

Check = Callable[[Subject], Finding]

_ALL: Final[tuple[Check, ...]] = (
    contract.spaces, contract.seeds, contract.episodes, contract.copies, contract.actions, contract.after_the_end,
    contract.last_step, contract.frames, knowledge.habits, knowledge.target, knowledge.no_secrets,
)  # fmt: skip
_SEVEN: Final[tuple[Check, ...]] = (senses.frame, senses.touch, senses.memory, senses.camera, choices.all_actions)
_OF: Final[dict[str, Sequence[Check]]] = {
    "UcON-v0": (*_ALL, knowledge.unseen_target, *_SEVEN, outcomes.done, outcomes.rewards, outcomes.figures),
    "UcONSearch-v0": (*_ALL, knowledge.unseen_target, choices.masks, outcomes.figures_of_choices),
    # The goal is an image here: the episode's target has no meaning, and may be visible in the image.
    "UcONImageGoal-v0": (*_ALL, *_SEVEN, outcomes.image_goal),
}


def check(subject: Subject) -> Iterator[Finding]:
    """Run every check that applies to a subject.

    An exception inside a check counts as a failed finding.

    Yields:
        One finding per check.
    """
    for one in _OF[subject.ours]:
        try:
            yield one(subject)
        except Exception as error:  # any exception of a user's environment is a finding
            name, said = one.__name__.replace("_", " "), f"{type(error).__name__}: {brief(str(error))}"
            yield Finding(name, False, _first_line(one), said)


def _first_line(check: Check) -> str:
    """The promise that a check tests: the first line of its docstring."""
    return (check.__doc__ or "").split("\n")[0].rstrip(".")
