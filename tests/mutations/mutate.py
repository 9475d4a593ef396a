"""Changes to files: flipped bits, truncation, edits by people, and attacks.

A mutation depends only on a seed, so that findings can be repeated.
"""

import random
import re
from collections.abc import Callable
from pathlib import Path

Change = Callable[[bytes, random.Random, bytes], bytes]

_TOKEN = re.compile(rb'(?<=[:,\[\s(])(?:-?\d+(?:\.\d+)?(?:e-?\d+)?|"[^"\n]*"|true|false|null)(?=[,\]}\s)]|$)')
_KEY = re.compile(rb'"\w+":')
VALUES = (
    *(b"-1", b"0", b"1", b"999", b"1.5", b"-0.0", b"1e308", b"1e999", b"NaN", b"Infinity", b"true", b"no", b"null"),
    *(
        b'""',
        b'"x"',
        b"[]",
        b"{}",
        b"[[]]",
        b'{"a":1}',
        b"9223372036854775807",
        b"9223372036854775808",
        b"1" + b"0" * 400,
    ),
    *(b"9" * 5000, b"[" * 100_000 + b"]" * 100_000, b"[" * 70 + b"]" * 70, b'"\\ud83d"', b'"a\\u0000b"', b'"\\u202e"'),
    *(
        b'"' + b"x" * 100_000 + b'"',
        "\U0001f469\u200d\U0001f373".encode(),
        b'"../../../etc/passwd"',
        b"!!python/name:os.system",
    ),
)


def _flip(raw: bytes, rng: random.Random, other: bytes) -> bytes:
    changed = bytearray(raw)
    changed[rng.randrange(len(raw))] ^= 1 << rng.randrange(8)
    return bytes(changed)


def _cut(raw: bytes, rng: random.Random, other: bytes) -> bytes:
    return raw[: rng.randrange(len(raw))]


def _cut_start(raw: bytes, rng: random.Random, other: bytes) -> bytes:
    return raw[rng.randrange(1, len(raw)) :]


def _insert(raw: bytes, rng: random.Random, other: bytes) -> bytes:
    at, what = (
        rng.randrange(len(raw) + 1),
        rng.choice((b"\0", b"\xff\xfe", b"\r", b"\n", b'"', b",", b"0", rng.randbytes(9))),
    )
    return raw[:at] + what + raw[at:]


def _append(raw: bytes, rng: random.Random, other: bytes) -> bytes:
    return raw + rng.choice((b"\0", b"\n", b"{}\n", b"more", raw, other, rng.randbytes(300)))


def _noise(raw: bytes, rng: random.Random, other: bytes) -> bytes:
    return rng.randbytes(rng.choice((1, 40, len(raw))))


def _empty(raw: bytes, rng: random.Random, other: bytes) -> bytes:
    return rng.choice((b"", b"\n", b"{}", b"[]", b"null", b"0"))


def _mark(raw: bytes, rng: random.Random, other: bytes) -> bytes:
    return rng.choice(
        (b"\xef\xbb\xbf" + raw, raw.replace(b"\n", b"\r\n"), raw.replace(b"\n", b"\r"), raw.rstrip(b"\n"))
    )


def _lines(raw: bytes, rng: random.Random, other: bytes) -> bytes:
    lines = raw.splitlines(keepends=True)
    a, b = rng.randrange(len(lines)), rng.randrange(len(lines))
    how = rng.randrange(4)
    if how == 0:
        del lines[a]
    elif how == 1:
        lines.insert(b, lines[a])
    elif how == 2:
        lines[a], lines[b] = lines[b], lines[a]
    else:
        lines[a] = lines[a].rstrip(b"\n")
    return b"".join(lines)


def _value(raw: bytes, rng: random.Random, other: bytes) -> bytes:
    found = list(_TOKEN.finditer(raw))
    if not found:
        return _flip(raw, rng, other)
    one = rng.choice(found)
    return raw[: one.start()] + rng.choice(VALUES) + raw[one.end() :]


def _swapped_values(raw: bytes, rng: random.Random, other: bytes) -> bytes:
    found = list(_TOKEN.finditer(raw))
    if not found:
        return _flip(raw, rng, other)
    one, another = rng.choice(found), rng.choice(found)
    return raw[: one.start()] + another[0] + raw[one.end() :]


def _key(raw: bytes, rng: random.Random, other: bytes) -> bytes:
    found = list(_KEY.finditer(raw))
    if not found:
        return _lines(raw, rng, other)
    one = rng.choice(found)
    what = rng.choice((b"", b'"unknown":', b'"__class__":', one[0] + b"1," + one[0], rng.choice(found)[0]))
    return raw[: one.start()] + what + raw[one.end() :]


def _of_other(raw: bytes, rng: random.Random, other: bytes) -> bytes:
    """Use content of another run or file of the same kind."""
    lines, others = raw.splitlines(keepends=True), other.splitlines(keepends=True)
    if not others or rng.random() < 0.3:
        return other
    lines[rng.randrange(len(lines))] = rng.choice(others)
    return b"".join(lines)


def _directory(path: Path) -> None:
    path.mkdir()


def _loop(path: Path) -> None:
    path.symlink_to(path)


def _dangling(path: Path) -> None:
    path.symlink_to(path.with_name("nothing-there"))


def _endless(path: Path) -> None:
    path.symlink_to("/dev/zero")


def _gone(path: Path) -> None:
    """Leave the file missing."""


def _large(path: Path) -> None:
    with path.open("wb") as file:
        file.truncate(1 << 41)  # a sparse file of two terabytes


BYTES: dict[str, Change] = {
    change.__name__.strip("_"): change
    for change in (
        *(_flip, _cut, _cut_start, _insert, _append, _noise, _empty, _mark, _lines),
        *(_value, _swapped_values, _key, _of_other),
    )
}
#: Mutations that are also made inside packed content.
INSIDE = ("flip", "cut", "insert", "mark", "lines", "value", "swapped_values", "key", "of_other")
PLACES: dict[str, Callable[[Path], None]] = {
    place.__name__.strip("_"): place for place in (_directory, _loop, _dangling, _endless, _gone, _large)
}
