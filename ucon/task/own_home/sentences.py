"""The habit sentences of a home file: where they are, and which of the requested things each is about."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Final

from ucon.core.errors import brief
from ucon.core.untrusted.marked_yaml import Marked
from ucon.core.untrusted.plain_file import read_bounded
from ucon.habits.rules import OWN_LIMITS, habit_fault, line_fault
from ucon.language.lexicon import Lexicon
from ucon.task.own_home.wish import Sentence

#: Largest file of habits, bytes.
_MOST_BYTES: Final = 1 << 20
#: Start of comment lines in such a file.
_REMARK: Final = "#"
Fault = Callable[[str, str], None]


def read_habits(node: Marked | None, folder: Path | None, fault: Fault) -> list[Sentence] | None:
    """The sentences of the key ``habits``: a list, or the name of a text file beside the home's.

    Args:
        node: the value of the key.
        folder: folder of the home file; None where the home is given as a dict.
        fault: called with the place and the text of each fault.

    Returns:
        The sentences; None where they cannot be read.
    """
    if node is None or node.value is None:
        return []
    if isinstance(node.value, list):
        found = [Sentence(one.value, one.where) for one in node.value if _is_sentence(one, fault)]
        if len(found) < len(node.value):
            return None
    elif isinstance(node.value, str) and folder is not None:
        lines = _of_file(node.value, node.where, folder, fault)
        if lines is None:
            return None
        found = lines
    else:
        expected = "a list of sentences" if folder is None else "a list of sentences, or a file beside this one"
        fault(node.where, f"habits: {node.told}, expected {expected}")
        return None
    if len(found) > (most := OWN_LIMITS.habits[1]):
        fault(found[most].where, f"{len(found):,} sentences, expected at most {most:,}")
    for one in found[:most]:
        if (wrong := line_fault(one.text) or habit_fault(one.text, (), 1, OWN_LIMITS)) is not None:
            fault(one.where, wrong)
    return found[:most]


def shared_out(sentences: Sequence[Sentence], targets: Sequence[str]) -> dict[str, list[Sentence]]:
    """Group sentences by the thing they are about.

    A sentence is about the thing that it names, by its name or a synonym. A sentence that names none is about the same
    thing as the sentence before it, as in running text; at the beginning it is about the first thing that any sentence
    names, or else about the first target.

    Args:
        sentences: the sentences in order.
        targets: categories of the requested things.
    """
    about: dict[str, list[Sentence]] = {target: [] for target in targets}
    if not targets:
        return about
    lexicon = Lexicon(targets)
    named = [_named(one.text, targets, lexicon) for one in sentences]
    current = next((target for target in named if target is not None), targets[0])
    for sentence, target in zip(sentences, named, strict=True):
        current = target or current
        about[current].append(sentence)
    return about


def _named(text: str, targets: Sequence[str], lexicon: Lexicon) -> str | None:
    """The target that a sentence names most plainly; None where it names none."""
    ids, features = lexicon.matches(text)
    if not len(ids):
        return None
    weight = features @ [4.0, 3.0, 2.0, 1.0]
    return targets[int(ids[int(weight.argmax())])]


def _is_sentence(node: Marked, fault: Fault) -> bool:
    if isinstance(node.value, str):
        return True
    fault(node.where, f"habits: {node.told}, expected a sentence (in quotes where it holds ': ')")
    return False


def _of_file(name: str, where: str, folder: Path, fault: Fault) -> list[Sentence] | None:
    path = folder / name
    if Path(name).is_absolute() or not path.resolve().is_relative_to(folder.resolve()):
        fault(where, f"habits: '{brief(name)}', expected a text file in the folder of this one, such as habits.txt")
        return None
    try:
        raw = read_bounded(path, _MOST_BYTES)
        text = raw.decode("utf-8-sig")
    except OSError as error:
        why = error.strerror
        fault(where, f"habits: {brief(name)} cannot be read ({why}); expected a text file, or a list of sentences")
        return None
    except UnicodeDecodeError as error:
        fault(f"{path}:{raw.count(10, 0, error.start) + 1}", f"not UTF-8 ({error.reason}); save the file as UTF-8")
        return None
    if len(raw) > _MOST_BYTES:
        fault(where, f"habits: {brief(name)} has more than {_MOST_BYTES:,} bytes; expected one sentence a line")
        return None
    lines = enumerate(text.replace("\r\n", "\n").split("\n"), 1)
    said = [(number, line.strip(" ")) for number, line in lines if line.strip() and not line.startswith(_REMARK)]
    return [Sentence(line, f"{path}:{number}") for number, line in said]
