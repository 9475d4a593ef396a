"""What ``eval.py`` and ``train.py`` share: errors in one line, and the comparison at the end of a sweep."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from ucon.core.errors import UconError, unknown_name

#: Exit code of errors that the user can mend; 130 is the shell's code for Ctrl-C.
USER_ERROR, INTERRUPTED = 2, 130


def run_entry(main: Callable[[], Any], config_name: str) -> None:
    """Run a Hydra main. Errors that a user can mend end in one line and exit code 2; bugs keep their traceback."""
    os.environ.setdefault("HYDRA_FULL_ERROR", "1")  # Hydra would print its own text and exit
    from hydra.errors import HydraException
    from omegaconf.errors import OmegaConfBaseException

    try:
        main()
    except UconError as error:
        _end(str(error), USER_ERROR)
    except KeyboardInterrupt:
        _end("interrupted; the same command with the same out= goes on from here", INTERRUPTED)
    except (HydraException, OmegaConfBaseException) as error:
        _end(explain(error, Path(sys.argv[0]).resolve().parent / "configs", config_name), USER_ERROR)


def explain(error: BaseException, configs: Path, config_name: str) -> str:
    """One line for a configuration error, with the nearest names that exist."""
    text = str(error)
    if found := re.search(r"Could not find '([^']+)/([^'/]+)'", text):
        group, name = found.groups()
        return unknown_name(group, name, [p.stem for p in (configs / group).glob("*.yaml")])
    if found := re.search(r"Could not (?:override|append to|find a match for) '([^'@]+)'", text):
        return unknown_name("option", found[1], _options(configs, config_name))
    if found := re.search(r"Key '([^']+)' (?:is not in struct|not in)[\s\S]*full_key: (\S+)", text):
        return unknown_name("option", found[2], _options(configs, config_name))
    if found := re.search(r"Missing mandatory value: (\S+)", text):
        return f"{found[1]} has no value; give {found[1]}=..."
    return " ".join(line.strip() for line in text.splitlines()[:2] if line.strip())


class CompareAtEnd:
    """Hydra callback: after a sweep, one table of all runs and the paired differences that answer its question."""

    def on_multirun_end(self, config: Any, **_: Any) -> None:
        """Print the tables of the sweep's folder."""
        from ucon.commands.compare import print_sweep

        print_sweep(Path(config.hydra.sweep.dir))


def _options(configs: Path, config_name: str) -> list[str]:
    """Dotted names of all options of a configuration, with its groups."""
    from hydra import compose, initialize_config_dir
    from hydra.core.global_hydra import GlobalHydra
    from omegaconf import OmegaConf

    GlobalHydra.instance().clear()
    with initialize_config_dir(str(configs), version_base="1.3"):
        config = OmegaConf.to_container(compose(config_name), resolve=False)
    groups = [p.name for p in configs.iterdir() if p.is_dir()]
    return sorted({*groups, *_keys(config)})


def _keys(node: Any, prefix: str = "") -> Iterator[str]:
    if isinstance(node, dict):
        for key, value in node.items():
            if not str(key).startswith("_"):
                yield f"{prefix}{key}"
                yield from _keys(value, f"{prefix}{key}.")


def _end(message: str, code: int) -> None:
    sys.stdout.flush()
    print(f"error: {message}", file=sys.stderr)
    sys.exit(code)
