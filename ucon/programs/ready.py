"""Imported first by ``eval.py`` and ``train.py``: says what to do where Python or what they need is missing.

It uses nothing but the standard library, and no syntax that an old Python does not know.
"""

import importlib.util
import sys

LEAST = (3, 10)
#: The first that is missing is named: one of each kind of what is installed.
NEEDED = ("hydra", "numpy", "gymnasium", "torch")
_HOW = "run `make setup`, then `source .venv/bin/activate`"


def problem(version, needed=NEEDED):  # type: ignore[no-untyped-def]  # (an old Python imports this)
    """What is wrong with this environment, in one line; None where nothing is."""
    if tuple(version[:2]) < LEAST:
        return "Python {}.{} is too old, expected {}.{} or newer; {}".format(*version[:2], *LEAST, _HOW)
    missing = [name for name in needed if importlib.util.find_spec(name) is None]
    return f"the module {missing[0]} is not installed in this Python; {_HOW}" if missing else None


_found = problem(sys.version_info)
if _found is not None:
    sys.stderr.write(f"error: {_found}\n")
    sys.exit(2)
