"""Errors of ``eval.py`` and ``train.py`` as one line, with the nearest existing names."""

from __future__ import annotations

import errno
import inspect
import os
import re
import signal
import sys
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from types import FrameType
from typing import Any, NoReturn

from ucon.configuration.help_page import help_page
from ucon.configuration.near_options import unknown_option
from ucon.core.errors import UconError, unknown_name

#: Exit codes: of errors that the user can fix, and of Ctrl-C and SIGTERM (the shell's codes).
USER_ERROR, INTERRUPTED, TERMINATED = 2, 130, 143
#: Error numbers that mean a problem with the disk, not a bug.
_OF_THE_DISK = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.EACCES, errno.EIO)

#: File that Hydra writes into the folder of a sweep.
_OF_SWEEPS = "multirun.yaml"
#: Options with two dashes that Hydra accepts.
_FLAGS = frozenset(
    {"--hydra-help", "--version", "--cfg", "--resolve", "--package", "--run", "--multirun", "--shell-completion"}
    | {"--config-path", "--config-name", "--config-dir", "--experimental-rerun", "--info"}
)


class Terminated(KeyboardInterrupt):
    """SIGTERM, which ends a command as Ctrl-C does: worker processes are ended, and a line says how to continue."""


def run_entry(main: Callable[[], Any], config_name: str) -> None:
    """Run a Hydra main; errors before it begins are printed as one line, and ``--help`` prints the help page.

    Before it begins, Hydra composes the configuration and makes the folder ``out``; errors there are the user's to
    fix.

    Args:
        main: decorated by Hydra; uses :func:`one_line_errors` inside.
        config_name: ``eval`` or ``train``.
    """
    words = sys.argv[1:]
    if {"-h", "--help"} & set(words):
        sys.stdout.write(help_page(_configs(), config_name, words))
        return
    if odd := next((word for word in words if word.startswith("--") and word.partition("=")[0] not in _FLAGS), None):
        name = odd[2:].partition("=")[0]
        _end(f"{odd}: options are given as name=value, such as agent=belief; give {name}=... or see --help", USER_ERROR)
    os.environ.setdefault("HYDRA_FULL_ERROR", "1")  # otherwise Hydra prints its own message and exits
    from hydra.errors import HydraException
    from omegaconf.errors import OmegaConfBaseException

    signal.signal(signal.SIGTERM, _terminate)
    try:
        main()
    except (HydraException, OmegaConfBaseException) as error:
        _end(explain(error, _configs(), config_name, sys.argv[1:]), USER_ERROR)
    except (OSError, ValueError) as error:
        if _within(main, error):
            raise
        if isinstance(error, OSError):
            _end(
                f"{error.filename}: cannot be created ({error.strerror}); give out=FOLDER that can be written",
                USER_ERROR,
            )
        _end(explain(error, _configs(), config_name, sys.argv[1:]), USER_ERROR)
    except KeyboardInterrupt as stop:
        _end_as_asked(stop)


@contextmanager
def one_line_errors(config_name: str, swept: Path | None = None) -> Iterator[None]:
    """Context manager within a Hydra main: errors that a user can fix end the program in one line, with exit code 2.

    Ending by SystemExit keeps Hydra from printing lines of its own. Bugs keep their traceback.

    Args:
        config_name: ``eval`` or ``train``.
        swept: folder that Hydra made for this run of a sweep. It is removed if the run fails before it writes
            anything, and so is the sweep's folder if no other run has written; None outside a sweep.
    """
    from hydra.errors import HydraException
    from omegaconf.errors import OmegaConfBaseException

    try:
        with _unused_removed(swept):
            yield
    except UconError as error:
        _end(str(error), USER_ERROR)
    except (HydraException, OmegaConfBaseException) as error:
        _end(explain(error, _configs(), config_name, sys.argv[1:]), USER_ERROR)
    except OSError as error:
        if error.errno not in _OF_THE_DISK:
            raise
        where = error.filename2 or error.filename or "cannot write"
        _end(
            f"{where}: {error.strerror}; make room or fix permissions, {_what_is_kept(config_name)}",
            USER_ERROR,
        )
    except KeyboardInterrupt as stop:
        _end_as_asked(stop, f"; {_what_is_kept(config_name)}")


@contextmanager
def _unused_removed(swept: Path | None) -> Iterator[None]:
    """Context manager that, after an error, removes a run's empty folder, and its sweep's if nothing else is there."""
    try:
        yield
    except BaseException:
        if swept is not None:
            with suppress(OSError):
                if swept.is_dir():
                    swept.rmdir()
                if [path.name for path in swept.parent.iterdir()] == [_OF_SWEEPS]:
                    (swept.parent / _OF_SWEEPS).unlink()
                    swept.parent.rmdir()
        raise


def _within(main: Callable[[], Any], error: BaseException) -> bool:
    """Whether an error occurred within a decorated main, in this process or another."""
    code = getattr(inspect.unwrap(main), "__code__", None)
    return error.__cause__ is not None or any(
        frame.f_code is code for frame, _ in traceback.walk_tb(error.__traceback__)
    )


def _what_is_kept(config_name: str) -> str:
    if config_name == "train":
        return "what is saved is kept: resume=RUN continues"
    return "what is finished is kept: the same command with the same out= continues"


def explain(error: BaseException, configs: Path, config_name: str, words: Sequence[str] = ()) -> str:
    """One line for a configuration error, with the nearest existing names.

    Args:
        error: of Hydra or OmegaConf.
        configs: folder of the configurations.
        config_name: ``eval`` or ``train``.
        words: of the command line; the options of the agent, detector, ... that they choose also count as existing.
    """
    text = str(error)
    if type(error).__name__ in ("MissingMandatoryValue", "InterpolationToMissingValueError"):
        key = getattr(error, "full_key", None) or text.rsplit(" ", 1)[-1]
        return f"{key} has no value; give {key}=..."
    if override := getattr(error, "override", None):
        return f"cannot read '{override}': {text.splitlines()[0]}; expected name=value, quoted where it has brackets"
    if found := re.search(r"Could not find '([^']+)/([^'/]+)'", text):
        group, name = found.groups()
        names = sorted(p.stem for p in (configs / group).glob("*.yaml"))
        if group == "learner/of":
            return f"agent={name} has no learner of its own; give learner=..., or one that has: {', '.join(names)}"
        return unknown_name(group, name, names)
    if found := re.search(r"Could not (?:override|append to|find a match for) '([^'@]+)'", text):
        return unknown_option(found[1], _options(configs, config_name, words))
    if found := re.search(r"Key '([^']+)' (?:is not in struct|not in)[\s\S]*full_key: (\S+)", text):
        return unknown_option(found[2], _options(configs, config_name, words))
    return " ".join(line.strip() for line in text.splitlines()[:2] if line.strip())


def _options(configs: Path, config_name: str, words: Sequence[str]) -> list[str]:
    """Dotted names of all options of a configuration with the choices in ``words``, and of its groups."""
    from hydra import compose, initialize_config_dir
    from hydra.core.global_hydra import GlobalHydra
    from hydra.errors import HydraException
    from omegaconf import OmegaConf

    GlobalHydra.instance().clear()
    chosen = [word for word in words if (configs / f"{word.replace('=', '/')}.yaml").is_file()]
    with initialize_config_dir(str(configs), version_base="1.3"):
        try:
            composed = compose(config_name, overrides=chosen)
        except HydraException:  # the choices do not go together
            composed = compose(config_name)
        config = OmegaConf.to_container(composed, resolve=False)
    groups = [p.name for p in configs.iterdir() if p.is_dir()]
    return sorted({*groups, *_keys(config)})


def _configs() -> Path:
    """Folder of the configurations, next to the script."""
    return Path(sys.argv[0]).resolve().parent / "configs"


def _keys(node: Any, prefix: str = "") -> Iterator[str]:
    if isinstance(node, dict):
        for key, value in node.items():
            if not str(key).startswith("_"):
                yield f"{prefix}{key}"
                yield from _keys(value, f"{prefix}{key}.")


def _terminate(number: int, frame: FrameType | None) -> NoReturn:
    raise Terminated


def _end_as_asked(stop: KeyboardInterrupt, kept: str = "") -> NoReturn:
    """End the program after a signal."""
    terminated = isinstance(stop, Terminated)
    _end(f"{'terminated' if terminated else 'interrupted'}{kept}", TERMINATED if terminated else INTERRUPTED)


def _end(message: str, code: int) -> NoReturn:
    sys.stdout.flush()
    print(f"error: {message}", file=sys.stderr)
    sys.exit(code)
