"""``python -m ucon bench``: renderer, environment and agent speed, measured in one process on one core."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

import ucon


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of the command."""
    parser.add_argument("--json", action="store_true", help="print JSON")
    parser.add_argument("--no-renderer", action="store_true", help="skip the comparison with PyBullet's TinyRenderer")


def run(args: argparse.Namespace) -> int:
    """Measure and print."""
    from ucon.core.output import stdout_to_stderr

    with stdout_to_stderr():
        figures = measure(renderer=not args.no_renderer)
    if args.json:
        print(json.dumps(figures, indent=1))
    else:
        for name, value in figures.items():
            print(f"{name:<28} {value}")
    return 0


def measure(*, renderer: bool = True) -> dict[str, Any]:
    """All figures; ratios are to TinyRenderer, rates are per CPU second."""
    from ucon.evaluation.bench_env import bench_environment
    from ucon.task.sets import load_episodes

    figures: dict[str, Any] = {}
    if renderer:
        from ucon.sim.cache import load_house
        from ucon.sim.render.bench import BENCH_SCENES, bench_renderer

        figures |= bench_renderer([load_house(name) for name in BENCH_SCENES])
    return figures | bench_environment(load_episodes("mini"), _belief())


def _belief() -> Any:
    """Factory of the agent that decisions are counted with; None outside a clone, where there are no agents."""
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
