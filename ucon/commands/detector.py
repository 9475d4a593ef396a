"""``python -m ucon detector``: fit a detector's errors on training homes, and show them."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from ucon.perception.detectors.box_detector import BoxDetector
    from ucon.perception.errors.model import DetectorErrors

#: Scores that are shown.
_SCORES: Final = (0.3, 0.5, 0.7, 0.9)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's actions to its parser."""
    actions = parser.add_subparsers(dest="action", metavar="ACTION", required=True)
    fit = actions.add_parser("fit", help="walk through training homes with a detector and fit its errors")
    fit.add_argument("name", metavar="NAME", help="a detector in configs/detector")
    fit.add_argument("file", metavar="FILE", type=Path, help="file to write: the errors, as JSON")
    fit.add_argument("option", metavar="OPTION", nargs="*", help="option of the detector, such as detector.seed=1")
    fit.add_argument("--episodes", metavar="SET", default="train", help="a set by name or file (train)")
    fit.add_argument("--walks", type=int, default=120, help="episodes to walk through, spread over the set (120)")
    fit.add_argument("--plots", metavar="FOLDER", type=Path, help="draw the errors as PNG files into a folder")
    show = actions.add_parser("show", help="print the errors of a detector")
    show.add_argument("name", metavar="NAME", help="a detector in configs/detector")
    show.add_argument("file", metavar="FILE", type=Path, nargs="?", help="file of errors (default: the shipped one)")
    show.add_argument("--thing", default="mug", help="thing whose chances are printed (mug)")
    show.add_argument("--plots", metavar="FOLDER", type=Path, help="draw the errors as PNG files into a folder")


def run(args: argparse.Namespace) -> int:
    """Fit or show.

    Args:
        args: parsed options.

    Returns:
        Exit code 0.

    Raises:
        ConfigError: no such detector, or none that finds boxes.
        DataError: too few looks, or a file without detector errors.
    """
    from ucon.perception.errors.model import read_errors

    if args.action == "fit":
        return _fit(args)
    errors = read_errors(args.name, args.file)
    print(described(errors, args.thing))
    if args.plots:
        from ucon.fitting.error_plots import draw_errors

        _say_drawn(draw_errors(errors, args.thing, args.plots.expanduser()))
    return 0


def _fit(args: argparse.Namespace) -> int:
    from ucon.core.errors import ConfigError
    from ucon.core.files import require_writable, write_atomic
    from ucon.core.progress import Progress
    from ucon.evaluation.figures.plotting import require_matplotlib
    from ucon.fitting.detector_errors import fit_errors
    from ucon.fitting.detector_looks import collect
    from ucon.fitting.error_plots import draw_errors
    from ucon.fitting.reliability import reliability
    from ucon.task.sets import load_episodes

    if args.walks < 2:
        raise ConfigError(f"--walks {args.walks}: expected 2 or more")
    require_writable(args.file)
    if args.plots:  # check first: walking takes minutes
        require_matplotlib()
        require_writable(args.plots.expanduser() / "recall.png")
    detector = _detector(args.name, args.option)
    episodes = load_episodes(args.episodes, "paper")
    chosen = episodes[:: max(1, len(episodes) // args.walks)][: args.walks]
    with Progress(f"walks with {args.name}", len(chosen)) as progress:
        looks, false = collect(detector, chosen, tick=progress.update)
    errors = fit_errors(args.name, looks, false)
    write_atomic(args.file, errors.to_json() + "\n")
    print(described(errors, "mug"))
    held = reliability(args.name, looks, false)
    print(f"\n{held.text}\n\nwritten to {args.file}, {errors.looks:,} looks")
    if args.plots:
        _say_drawn(draw_errors(errors, "mug", args.plots.expanduser(), held))
    return 0


def _say_drawn(files: list[Path]) -> None:
    print(f"drawn in {files[0].parent}: {', '.join(file.name for file in files)}")


def _detector(name: str, options: list[str]) -> BoxDetector:
    """A configured detector.

    Raises:
        ConfigError: there is no detector with this name, or it finds no boxes.
    """
    from ucon.configuration.wiring import Factory
    from ucon.core.errors import ConfigError
    from ucon.perception.detectors.box_detector import BoxDetector
    from ucon.programs.composing import eval_config

    detector = Factory(eval_config(f"detector={name}", "out=runs/detector", *options)["detector"])()
    if not isinstance(detector, BoxDetector):
        raise ConfigError(f"detector={name}: makes no errors; expected a detector that finds boxes, such as noisy")
    return detector


def described(errors: DetectorErrors, thing: str) -> str:
    """The errors as text: recall, scores, wrong names, false boxes.

    Args:
        errors: of a detector.
        thing: name of the thing whose chances are printed.

    Raises:
        ConfigError: no such thing.
    """
    import numpy as np

    from ucon.core.errors import ConfigError, unknown_name
    from ucon.perception.detectors.base import vocabulary

    names = vocabulary()
    if thing not in names:
        raise ConfigError(unknown_name("thing", thing, names))
    sizes, far = np.array([6.0, 25.0, 100.0, 400.0, 1600.0]), np.array([1.0, 2.0, 4.0, 8.0])
    lines = [
        f"{errors.detector}: errors fitted on {errors.looks:,} looks (sha256 {errors.fingerprint()[:12]})",
        "",
        "found, of things that are fully visible (%)",
    ]
    lines.append("   pixels" + "".join(f"{f'{m:g} m':>8}" for m in far))
    for px in sizes:
        chance = 100 * errors.found(np.full(4, px), far, np.ones(4))
        lines.append(f"{px:9.0f}" + "".join(f"{c:8.0f}" for c in chance))
    seen = 100 * errors.sighted_curve(thing, far)
    lines.append(f"{thing[:9]:>9}" + "".join(f"{c:8.0f}" for c in seen) + "  by its size, fully visible")
    lines.append(f"\ncalled by its own name: {100 * errors.right:.0f} % of what is found")
    row = np.exp(errors.called[names.index(thing)])
    likely = ", ".join(f"{names[k]} {100 * row[k]:.0f} %" for k in np.argsort(-row)[:4])
    lines.append(f"a wrong name of {thing}: {likely}")
    scores = np.exp([errors.evidence(score) for score in _SCORES])
    lines.append("how much more often right boxes have a score than wrong ones:")
    lines.append("  " + "   ".join(f"{score:.1f}: {ratio:.2f}" for score, ratio in zip(_SCORES, scores, strict=True)))
    lines.append(f"boxes on nothing: {errors.false_boxes:.2f} a frame, {100 * errors.false_share:.0f} % of all boxes")
    lines.append(
        f"looks from one side (of {errors.sides}) within {errors.octave:g} octave agree by {errors.repeats:.2f}, "
        f"others by {errors.repeats_elsewhere:.2f}"
    )
    return "\n".join(lines)
