"""``python -m ucon bench``: speed of renderer, environments and agent, in one process on one core."""

from __future__ import annotations

import argparse
import json
from itertools import count
from pathlib import Path
from typing import Any, Final

import ucon

_TIMES: Final = "times as fast as TinyRenderer"
_STEPS: Final = "steps a second"
#: Description and unit of each figure of ``--json``.
_FIGURES: Final = {
    "renderer_ratio_128": ("frames of 128 x 128 pixels", _TIMES),
    "renderer_ratio_128_flat": ("frames of 128 x 128 pixels, no textures", _TIMES),
    "renderer_ratio_224": ("frames of 224 x 224 pixels", _TIMES),
    "renderer_us_128": ("a frame of 128 x 128 pixels", "microseconds"),
    "renderer_us_128_flat": ("a frame of 128 x 128 pixels, no textures", "microseconds"),
    "renderer_us_224": ("a frame of 224 x 224 pixels", "microseconds"),
    "renderer_us_counts": ("counting the pixels of each thing in a frame", "microseconds"),
    "env_pixels_sps": ("UcON-v0 with images", _STEPS),
    "env_symbolic_sps": ("UcON-v0 without images", _STEPS),
    "env_with_resets_sps": ("UcON-v0 with images, resets included", _STEPS),
    "search_decisions_per_s": ("UcONSearch-v0, choices at random", "choices a second"),
    "search_steps_per_decision": ("UcONSearch-v0, length of choices at random", "steps a choice"),
    "decisions_per_s": ("agent=belief, its environment included", _STEPS),
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's options to its parser."""
    parser.add_argument("--json", action="store_true", help="print JSON")
    parser.add_argument("--no-renderer", action="store_true", help="skip the comparison with PyBullet's TinyRenderer")


def run(args: argparse.Namespace) -> int:
    """Measure, and print a line per figure, or JSON.

    Args:
        args: parsed options.

    Returns:
        Exit code 0.
    """
    from ucon.core.output import stdout_to_stderr

    with stdout_to_stderr():
        figures = measure(renderer=not args.no_renderer)
    if args.json:
        print(json.dumps(figures, indent=1))
    else:
        for name, value in figures.items():
            print(said(name, value))
        print("CPU time of one process on one core; medians over homes, and the slowest home")
    return 0


def said(name: str, value: float) -> str:
    """One line with a figure and its unit.

    Args:
        name: key in ``--json``; ``_worst`` at its end means the slowest home.
        value: of the figure.
    """
    what, unit = _FIGURES[name.removesuffix("_worst")]
    slowest = ", slowest home" if name.endswith("_worst") else ""
    return f"{what + slowest:<52} {value:>9.1f} {unit}"


def measure(*, renderer: bool = True) -> dict[str, Any]:
    """All figures by name; ratios are to TinyRenderer, rates are per CPU second.

    Args:
        renderer: False leaves out the comparison with TinyRenderer.
    """
    from ucon.core.progress import Progress
    from ucon.evaluation.bench_env import STAGES, bench_environment
    from ucon.task.sets import load_episodes

    figures: dict[str, Any] = {}
    agent = _belief_agent()
    stages = count(1)
    with Progress("bench", renderer + STAGES + (agent is not None), unit="parts") as progress:
        if renderer:
            from ucon.sim.cache import load_house
            from ucon.sim.render.bench import BENCH_SCENES, bench_renderer

            figures |= bench_renderer([load_house(name) for name in BENCH_SCENES])
            progress.update(next(stages))
        return figures | bench_environment(load_episodes("mini"), agent, lambda: progress.update(next(stages)))


def _belief_agent() -> Any:
    """Factory of ``agent=belief``, whose speed is measured; None outside a clone, where there are no agents."""
    configs = Path(ucon.__file__).parents[1] / "configs"
    if not configs.is_dir():
        return None
    from hydra import compose, initialize_config_dir
    from omegaconf import OmegaConf

    from ucon.configuration.wiring import Factory

    with initialize_config_dir(str(configs), version_base="1.3"):
        config = compose("eval", overrides=["agent=belief", "out=runs/bench"])
    agent: Any = OmegaConf.to_container(config.agent, resolve=True)
    return Factory(agent)
