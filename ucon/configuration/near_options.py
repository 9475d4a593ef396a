"""The option that a misspelt one may have meant: one of the same group, where there is one."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from typing import Final

from ucon.core.errors import brief, unknown_name

#: Most options of a group that are listed.
_LISTED: Final = 12


def unknown_option(name: str, known: Iterable[str]) -> str:
    """The message for an option that does not exist.

    Args:
        name: dotted name of the unknown option.
        known: dotted names of those that exist.
    """
    names = sorted(known)
    group, _, rest = name.partition(".")
    own = [one.removeprefix(f"{group}.") for one in names if one.startswith(f"{group}.")]
    if not rest or not (own or group in names):
        return unknown_name("option", name, names)
    close = difflib.get_close_matches(rest, own, n=3)
    last = rest.rpartition(".")[2]
    near = [f"{group}.{one}" for one in close] or [one for one in names if one.rpartition(".")[2] == last]
    if near:
        hint = f"did you mean {', '.join(near[:3])}?"
    elif not own:
        hint = f"the choice for {group} has no options in its file in configs/{group}/"
    else:
        more = ", ..." if len(own) > _LISTED else ""
        hint = f"expected one of {', '.join(f'{group}.{one}' for one in own[:_LISTED])}{more}"
    return f"unknown option '{brief(name)}': {hint}"
