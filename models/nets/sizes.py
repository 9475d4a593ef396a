"""Sizes of networks, which configurations give."""

from __future__ import annotations

from ucon.core.errors import ConfigError, brief

_MOST = 10_000


def check_sizes(owner: str, **sizes: int) -> None:
    """Refuse sizes below 1 or beyond any network's; ``owner`` is where they are given, such as ``agent.policy``.

    Raises:
        ConfigError: naming the size.
    """
    for name, value in sizes.items():
        if type(value) is not int or not 1 <= value <= _MOST:
            raise ConfigError(f"{owner}.{name}={brief(value)}: expected a whole number from 1 to {_MOST:,}")


def check_heads(owner: str, width: int, heads: int) -> None:
    """Refuse a width that the heads of an attention cannot share.

    Raises:
        ConfigError: naming both.
    """
    check_sizes(owner, width=width, heads=heads)
    if width % heads:
        raise ConfigError(f"{owner}.width={width}: must be a multiple of heads={heads}")
