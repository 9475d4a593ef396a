"""YAML of a folder that somebody else made."""

from __future__ import annotations

from typing import Final

import yaml

#: A run's configuration has some kilobytes.
MOST_BYTES: Final = 1 << 20


def without_aliases(text: str) -> str:
    """``text``, if it is of a bearable size and names no node twice: ten lines of aliases describe gigabytes.

    Raises:
        ValueError: it is too long, or has aliases.
        yaml.YAMLError: it is no YAML.
    """
    if len(text) > MOST_BYTES:
        raise ValueError(f"{len(text)} letters, expected at most {MOST_BYTES}")
    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    if any(isinstance(event, yaml.AliasEvent) for event in yaml.parse(text, Loader=loader)):
        raise ValueError("aliases")
    return text
