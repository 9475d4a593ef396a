"""Checks of network sizes that configurations give."""

from __future__ import annotations

from typing import Final

from ucon.core.errors import ConfigError, brief

#: Upper bound of any size.
MOST: Final = 4096


def check_sizes(owner: str, **sizes: int) -> None:
    """Refuse sizes that are not whole numbers from 1 to 4096.

    Args:
        owner: where they are given, such as ``agent.policy``.
        sizes: by name.

    Raises:
        ConfigError: naming the size.
    """
    for name, value in sizes.items():
        if type(value) is not int or not 1 <= value <= MOST:
            raise ConfigError(f"{owner}.{name}={brief(value)}: expected a whole number from 1 to {MOST}")


def check_heads(owner: str, width: int, heads: int) -> None:
    """Refuse a width that the number of attention heads does not divide.

    Args:
        owner: where they are given, such as ``agent.policy``.
        width: of the tokens.
        heads: of attention.

    Raises:
        ConfigError: naming both.
    """
    check_sizes(owner, width=width, heads=heads)
    if width % heads:
        raise ConfigError(f"{owner}.width={width}: must be a multiple of heads={heads}")
