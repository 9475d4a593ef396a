"""Sizes of networks, which configurations give."""

from __future__ import annotations

from ucon.core.errors import ConfigError, brief


def check_sizes(owner: str, **sizes: int) -> None:
    """Refuse sizes below 1; ``owner`` is where they are given, such as ``agent.policy``.

    Raises:
        ConfigError: naming the size.
    """
    for name, value in sizes.items():
        if type(value) is not int or value < 1:
            raise ConfigError(f"{owner}.{name}={brief(value)}: expected a whole number from 1 up")


def check_heads(owner: str, width: int, heads: int) -> None:
    """Refuse a width that the heads of an attention cannot share.

    Raises:
        ConfigError: naming both.
    """
    check_sizes(owner, width=width, heads=heads)
    if width % heads:
        raise ConfigError(f"{owner}.width={width}: must be a multiple of heads={heads}")
