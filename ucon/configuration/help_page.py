"""Text of ``eval.py --help`` and ``train.py --help``: the options, with the comments in ``configs/``."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Final, NamedTuple

_WIDTH: Final = 80
_KEY = re.compile(r"( *)([\w/]+):(?: +([^#\n]*?))? *(?:#.*)?$")
_PACKAGE = re.compile(r"# @package (\S+)")
_GROUP = re.compile(r" *- (\w+): *([\w/${}]+)")
#: Keys that are not options for users.
_LEFT_OUT: Final = ("defaults", "hydra", "_target_")


class HelpEntry(NamedTuple):
    """An option with its comment."""

    name: str
    """Dotted name."""
    value: str
    comment: str
    """Prose without line breaks; code keeps its lines, which start with two spaces."""


def help_page(configs: Path, name: str, words: Sequence[str] = ()) -> str:
    """The help page of ``configs/NAME.yaml``.

    Args:
        configs: folder of the configurations.
        name: name of the main file.
        words: other words of the command line; ``agent=lgx`` adds the options of that file.
    """
    text = (configs / f"{name}.yaml").read_text(encoding="utf-8")
    lines = [*_head(text), "", "Options (name=value):", ""]
    for option in options_of(text):
        lines += _entry_lines(f"{option.name}={option.value}", option.comment)
    lines += ["", "Groups (GROUP=NAME); `GROUP=NAME --help` also lists the options of that choice:"]
    for group, chosen in _groups(text):
        lines += ["", f"{group}={chosen}"]
        for path in sorted((configs / group).glob("*.yaml")):
            lines += _entry_lines(path.stem, _first_sentence(_comment(path)))
    for word in words:
        group, _, one = word.partition("=")
        path = configs / group / f"{one}.yaml"
        if re.fullmatch(r"\w+", group) and re.fullmatch(r"\w+", one) and path.is_file():
            lines += ["", f"Options of {word}:", ""]
            text = path.read_text(encoding="utf-8")
            for option in options_of(text):
                lines += _entry_lines(f"{_prefix(text, group)}{option.name}={option.value}", option.comment)
    return "\n".join(lines) + "\n"


def options_of(text: str) -> Iterator[HelpEntry]:
    """Keys of a YAML file that have a comment directly above them, other than the comment at the start of the file.

    Args:
        text: text of the file.
    """
    above: list[str] = []
    path: list[tuple[int, str]] = []
    for line in text.splitlines()[len(_head(text)) :]:
        if line.lstrip().startswith("#"):
            above.append(_uncommented(line.lstrip()))
            continue
        if (match := _KEY.fullmatch(line)) is not None:
            indent = len(match[1])
            path = [(depth, key) for depth, key in path if depth < indent] + [(indent, match[2])]
            keys = [key for _, key in path]
            if above and keys[0] not in _LEFT_OUT and keys[-1] not in _LEFT_OUT:
                yield HelpEntry(".".join(keys), match[3] or "...", _joined(above))
        above = []


def _prefix(text: str, group: str) -> str:
    """What precedes the keys of a group's file on the command line: its Hydra package and a dot; "" for the root."""
    package = _PACKAGE.match(text)
    name = group if package is None else package[1]
    return "" if name == "_global_" else f"{name}."


def _head(text: str) -> list[str]:
    """Lines of the comment at the start of a file."""
    out = []
    for line in text.splitlines():
        if not line.startswith("#"):
            break
        out.append(_uncommented(line))
    return out


def _uncommented(line: str) -> str:
    return line.removeprefix("#").removeprefix(" ").rstrip()


def _joined(lines: Iterable[str]) -> str:
    """A comment's lines as one text: prose is joined, lines of code (indented) stay lines."""
    text = ""
    for line in lines:
        code = line.startswith("  ")
        broken = code or text.rpartition("\n")[2].startswith("  ")
        text += ("\n" if broken else " ") + (line if code else line.strip()) if text else line.strip()
    return text


def _groups(text: str) -> Iterator[tuple[str, str]]:
    """Groups of the defaults list, and the default choice of each."""
    for line in text.partition("\ndefaults:")[2].splitlines():
        if line and not line.startswith(" "):
            return
        if (match := _GROUP.match(line)) is not None:
            yield match[1], match[2]


def _comment(path: Path) -> str:
    lines = [line for line in _head(path.read_text(encoding="utf-8")) if not line.startswith("@package")]
    return _joined(lines)


def _first_sentence(text: str) -> str:
    """The first sentence of a comment, with the code lines that follow it."""
    return re.split(r"(?<=\.)\s|\n(?!  )", text, maxsplit=1)[0]


def _entry_lines(name: str, comment: str) -> list[str]:
    """Lines of an option or choice and its comment, which follows on the same line, or below a long name.

    Code is not wrapped.
    """
    column = 24
    body: list[str] = []
    for part in comment.split("\n"):
        if part.startswith("  "):
            body.append(f"    {part.strip()}")
        else:
            prose = textwrap.wrap(part, _WIDTH - column, break_long_words=False, break_on_hyphens=False)
            body += [" " * column + line for line in prose]
    first = f"  {name}"
    if len(first) > column - 2 or not body:
        return [first, *body]
    return [f"{first:<{column}}{body[0][column:]}", *body[1:]]
