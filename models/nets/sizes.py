"""Sizes of networks, which configurations give."""

from __future__ import annotations

from typing import Final

from ucon.core.errors import ConfigError, brief

#: Far beyond what a machine holds or would build in an hour.
MOST: Final = 4096


def check_sizes(owner: str, **sizes: int) -> None:
    """Refuse sizes below 1 or beyond all bounds; ``owner`` is where they are given, such as ``agent.policy``.

    Raises:
        ConfigError: naming the size.
    """
    for name, value in sizes.items():
        if type(value) is not int or not 1 <= value <= MOST:
            raise ConfigError(f"{owner}.{name}={brief(value)}: expected a whole number from 1 to {MOST}")


def check_heads(owner: str, width: int, heads: int) -> None:
    """Refuse a width that the heads of an attention cannot share.

    Raises:
        ConfigError: naming both.
    """
    check_sizes(owner, width=width, heads=heads)
    if width % heads:
        raise ConfigError(f"{owner}.width={width}: must be a multiple of heads={heads}")
