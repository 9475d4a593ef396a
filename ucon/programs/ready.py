"""Imported first by ``eval.py`` and ``train.py``: says what to do if Python is too old or a package is missing.

It uses only the standard library, and only syntax that old versions of Python can parse.
"""

import importlib.util
import sys

LEAST = (3, 10)
#: Modules that are looked for; the first missing one is named.
NEEDED = ("hydra", "numpy", "gymnasium", "torch")
_HOW = "run `make setup`, then `source .venv/bin/activate`"


def problem(version, needed=NEEDED):  # type: ignore[no-untyped-def]  # (an old Python imports this)
    """What is wrong with this environment, in one line; None where nothing is.

    Args:
        version: of Python, at least major and minor.
        needed: names of modules.
    """
    if tuple(version[:2]) < LEAST:
        return "Python {}.{} is too old, expected {}.{} or newer; {}".format(*version[:2], *LEAST, _HOW)
    missing = [name for name in needed if importlib.util.find_spec(name) is None]
    return f"the module {missing[0]} is not installed in this Python; {_HOW}" if missing else None


_found = problem(sys.version_info)
if _found is not None:
    sys.stderr.write(f"error: {_found}\n")
    sys.exit(2)
