"""``python -m ucon COMMAND``. Only the chosen command's module is imported, so ``--help`` answers at once."""

from __future__ import annotations

import argparse
import contextlib
import importlib
import keyword
import re
import sys
from collections.abc import Iterator, Sequence
from types import ModuleType
from typing import NoReturn

from ucon import __version__
from ucon.core.errors import UconError, unknown_name

#: Command and what it does; its code is ``ucon/commands/<command>.py``, ``-`` as ``_`` and ``try`` as ``try_``, with
#: ``add_arguments`` and ``run``.
COMMANDS = {
    "doctor": "check this machine and this installation, and say what to do",
    "info": "show the seven actions, or the home, household and target of an episode",
    "bench": "measure renderer and environment speed",
    "demo": "film one search without and with habits, and show the sentence that makes the difference",
    "try": "search for your own object in a home, without and with your own habits",
    "home": "start a home of your own as a file, and show what is built from it",
    "report": "write one HTML file with the tables of runs and every episode: map, pictures, beliefs, decisions",
    "compare": "paired differences with 95 % intervals between runs of eval.py",
    "verify": "recompute the figures of finished runs from their records, and check their checksums",
    "replay": "play finished runs again, such as those of results/, and say whether their numbers come out the same",
    "watch": "film an episode of a finished run, or list its episodes and how they ended",
    "serve": "open pages in the browser, on this machine only: runs, homes, habits, play, study",
    "cases": "find the habits that made a search better or worse, by playing it again without them",
    "catalogue": "print the names of the object catalogue, or draw it",
    "detector": "fit the errors of a detector on training homes, and show them",
    "scenes": "list and draw the homes",
    "habits": "import a habit dataset, or print a dataset's statistics",
    "episodes": "make or verify fixed episode sets",
    "lives": "make, list or verify sets of lives: days in a home whose people use their things",
    "check-env": "check that an environment, or a wrapper around one of ours, keeps the task's interface and rules",
    "models": "download a language model once, check it, and convert it",
    "data": "fit, measure and ship the weights and tables that come with the package",
    "pack": "write episode sets and their compiled homes, for machines without PyBullet",
}


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command; its exit code is 0 only when all is well, 2 for errors that the user can fix."""
    arguments = list(sys.argv[1:] if argv is None else argv)
    parser = Parser(prog="ucon", description="User-centric object navigation.")
    parser.add_argument("--version", action="version", version=f"ucon {__version__}")
    commands = parser.add_subparsers(dest="command", metavar="COMMAND")
    chosen = next((word for word in arguments if not word.startswith("-")), None)
    if chosen is not None and chosen not in COMMANDS:
        return _error(unknown_name("command", chosen, COMMANDS))
    for name, text in COMMANDS.items():
        command = commands.add_parser(name, help=text.replace("%", "%%"), description=f"{text[0].upper()}{text[1:]}.")
        if name == chosen:
            _module(name).add_arguments(command)
    args, unknown = parser.parse_known_args(arguments)
    if unknown:
        return _error(unknown_name("argument", unknown[0], {*_options(parser)}, remedy="(see --help)"))
    if args.command is None:
        parser.print_help()
        return 0
    try:
        return int(_module(args.command).run(args))
    except UconError as error:
        return _error(str(error))
    except BrokenPipeError:
        return 0  # the reader (head, less) has seen enough
    except OSError as error:
        where = error.filename2 or error.filename or args.command
        return _error(f"{where}: {error.strerror or error}; check the path, its permissions and the free disk space")
    except KeyboardInterrupt:
        return _error("interrupted", 130)


class Parser(argparse.ArgumentParser):
    """Says of a choice that does not exist which one may have been meant."""

    def error(self, message: str) -> NoReturn:
        """End in one line with exit code 2."""
        if found := re.fullmatch(r"argument (\S+): invalid choice: (.+?) \(choose from (.*)\)", message):
            names = [name.strip("'") for name in found[3].split(", ")]
            message = unknown_name(found[1].lstrip("-").lower(), found[2].strip("'"), names)
        self.exit(2, f"error: {message}; see {self.prog} --help\n")


def _options(parser: argparse.ArgumentParser) -> Iterator[str]:
    """Options of a parser, and of the parsers of its actions."""
    for action in parser._actions:
        yield from action.option_strings
        if isinstance(action, argparse._SubParsersAction):
            for below in action.choices.values():
                yield from _options(below)


def _module(command: str) -> ModuleType:
    name = f"{command}_" if keyword.iskeyword(command) else command.replace("-", "_")
    return importlib.import_module(f"ucon.commands.{name}")


def _error(message: str, code: int = 2) -> int:
    with contextlib.suppress(OSError):  # it may be standard output that cannot be written
        sys.stdout.flush()
    sys.stderr.write(f"error: {message}\n")
    return code


if __name__ == "__main__":
    sys.exit(main())
