"""``python -m ucon check-env ID_OR_MODULE:CLASS``: checks that an environment keeps the task's interface and rules."""

from __future__ import annotations

import argparse
import json
import sys
import warnings
from dataclasses import asdict
from pathlib import Path


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's options to its parser."""
    parser.add_argument("environment", metavar="ID_OR_MODULE:CLASS", help="UcON-v0, or my_module:MyWrapper")
    parser.add_argument(
        "--around", default="UcON-v0", metavar="ID", help="environment to put a wrapper around (UcON-v0)"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object per line")


def run(args: argparse.Namespace) -> int:
    """Print one line per check.

    Args:
        args: parsed options.

    Returns:
        Exit code 0 if all checks pass, 1 if one fails.
    """
    import ucon.envs  # noqa: F401 (registers the environments)
    from ucon.envs.checking import check, subject_of

    sys.path.insert(0, str(Path.cwd()))
    warnings.filterwarnings("ignore", module="gymnasium")
    findings = []
    for finding in check(subject_of(args.environment, args.around)):
        findings.append(finding)
        print(json.dumps(asdict(finding)) if args.json else finding.line(), flush=True)
    failed = sum(not finding.ok for finding in findings)
    if not args.json:
        print(f"{len(findings)} checks, {failed} failed")
    return int(failed > 0)
