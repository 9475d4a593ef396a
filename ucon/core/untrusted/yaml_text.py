"""Checks of YAML from untrusted sources."""

from __future__ import annotations

from typing import Final

import yaml

#: Largest text, characters; a run's configuration has some thousands.
MOST_BYTES: Final = 1 << 20


def without_aliases(text: str) -> str:
    """The text itself, after checking its size and that it has no aliases.

    Ten lines of aliases can expand to gigabytes.

    Raises:
        ValueError: it is too long, or has aliases.
        yaml.YAMLError: it is not YAML.
    """
    if len(text) > MOST_BYTES:
        raise ValueError(f"{len(text)} letters, expected at most {MOST_BYTES}")
    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    if any(isinstance(event, yaml.AliasEvent) for event in yaml.parse(text, Loader=loader)):
        raise ValueError("aliases")
    return text
