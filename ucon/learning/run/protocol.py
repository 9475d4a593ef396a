"""What training asks of a learner."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final, Protocol

from ucon.core.errors import DataError, brief

if TYPE_CHECKING:
    from torch import Tensor

Figures = dict[str, float]
#: Name of the habit dataset that is shipped.
BOOK: Final = "book"
#: Far more steps or frames than anybody takes; seeds are made of such numbers.
_MOST_COUNTED: Final = 1 << 53


@dataclass(frozen=True)
class State:
    """All that decides how a learner goes on: tensors by name, and plain values that JSON can hold."""

    tensors: Mapping[str, Tensor]
    values: Mapping[str, Any] = field(default_factory=dict)

    def count(self, name: str) -> int:
        """A number of something among the values.

        Raises:
            DataError: there is none.
        """
        found = self.values.get(name)
        if type(found) is not int or not 0 <= found < _MOST_COUNTED:
            raise DataError(f"state of another learner: {name} is {brief(found)}, expected a whole number")
        return found


@dataclass(frozen=True)
class Card:
    """What a model card says about a learner beside its figures."""

    title: str
    text: str
    """Markdown: what was learned, from what, how to use it, and what it must not be taken for."""
    habits: str = BOOK
    """Name of the dataset that was learned from; its licence is that of the weights."""

    @property
    def licence(self) -> str:
        """Under what the weights may be used, in a sentence."""
        if self.habits == BOOK:
            return "CC BY 4.0, as the habit book that they were learned from; the code is MIT."
        return (
            f"That of the habits `{self.habits}` that they were learned from. The official release of UcON states "
            "none: weights learned from it are not to be passed on."
        )


class Learner(Protocol):
    """Learns by steps. Equal states take equal steps: nothing else may decide, neither time nor earlier calls.

    Randomness of step n is a function of seed and n, so the state holds no random generators.
    """

    @property
    def identity(self) -> Mapping[str, str]:
        """Hashes of what it learns from and starts from; a checkpoint of other hashes is refused."""
        ...

    def step(self) -> Figures:
        """One update; the figures to log."""
        ...

    def validate(self) -> Figures:
        """Figures on validation data. Must not change the state."""
        ...

    def state_dict(self) -> State:
        """The state, to be written at once."""
        ...

    def load_state_dict(self, state: State) -> None:
        """Go on from a state; raises :class:`~ucon.core.errors.DataError` where it does not fit."""
        ...

    def lengthen(self, steps: int) -> bool:
        """Follow, from the next step on, the schedules of a run of so many steps; False where it has none.

        A state does not hold it: whoever extends a run says it again after loading one.
        """
        ...

    def product(self) -> Mapping[str, bytes]:
        """Files of what was learned, by name: what is used afterwards."""
        ...

    def card(self) -> Card:
        """For the model card."""
        ...

    def close(self) -> None:
        """End the processes and close the environments that it plays in; it makes new ones if it goes on."""
        ...
