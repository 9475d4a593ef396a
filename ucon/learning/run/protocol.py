"""The interface between a training run and a learner: the state, the model card and the learner itself."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final, Protocol

from ucon.core.errors import DataError, brief

if TYPE_CHECKING:
    from torch import Tensor

Figures = dict[str, float]
#: Name of the shipped habit dataset.
BOOK: Final = "book"
#: Upper bound of counters in a state; seeds are derived from them.
_MOST_COUNTED: Final = 1 << 53


@dataclass(frozen=True)
class State:
    """Everything that decides how a learner continues: tensors by name, and plain values that JSON can hold."""

    tensors: Mapping[str, Tensor]
    values: Mapping[str, Any] = field(default_factory=dict)

    def count(self, name: str) -> int:
        """Value ``name`` as a count, from 0 up.

        Raises:
            DataError: it is missing, or no whole number in range.
        """
        found = self.values.get(name)
        if type(found) is not int or not 0 <= found < _MOST_COUNTED:
            raise DataError(f"state of another learner: {name} is {brief(found)}, expected a whole number")
        return found


@dataclass(frozen=True)
class Card:
    """A learner's part of the model card; figures, files and hashes are added by the run."""

    title: str
    text: str
    """Markdown: the network, its training data, how to use it, and its limits."""
    habits: str = BOOK
    """Name of the habit dataset that it was trained on; the licence of the weights follows from it."""

    @property
    def licence(self) -> str:
        """Licence of the weights, in a sentence or two."""
        if self.habits == BOOK:
            return "CC BY 4.0, as the habit book that they were learned from; the code is MIT."
        return (
            f"That of the habits `{self.habits}` that they were learned from. The official release of UcON states "
            "none: weights learned from it are not to be passed on."
        )


class Learner(Protocol):
    """Trains by steps. From equal states it takes equal steps: neither time nor earlier calls may matter.

    All randomness of step n is a function of seed and n, so the state holds no random generators.
    """

    @property
    def identity(self) -> Mapping[str, str]:
        """Hashes of the training data and of the initial weights, by name.

        A checkpoint with other hashes is refused.
        """
        ...

    def step(self) -> Figures:
        """Do one update (for PPO: one collection and its updates).

        Returns:
            Figures to log, by name; finite numbers.

        Raises:
            DivergedError: a loss or gradient that is not finite.
        """
        ...

    def validate(self) -> Figures:
        """Measure the present state on validation data, without changing it.

        Returns:
            Figures by name; among them ``score``, larger is better, which chooses the best checkpoint.
        """
        ...

    def state_dict(self) -> State:
        """The present state. Tensors may be references, so it has to be written before the next step."""
        ...

    def load_state_dict(self, state: State) -> None:
        """Restore a state of :meth:`state_dict`.

        Raises:
            DataError: the state is not one of this learner.
        """
        ...

    def lengthen(self, steps: int) -> bool:
        """Stretch the schedules to a run of ``steps`` steps, from the next step on.

        The length is not part of the state: an extended run calls this again after loading a state.

        Returns:
            False where no schedule depends on the number of steps.
        """
        ...

    def product(self) -> Mapping[str, bytes]:
        """Files of what was learned, by name, as an agent or retriever loads them."""
        ...

    def card(self) -> Card:
        """Title, text and dataset for the model card."""
        ...

    def close(self) -> None:
        """End worker processes and close environments; if training continues, new ones are made."""
        ...
