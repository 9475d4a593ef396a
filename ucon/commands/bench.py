"""``python -m ucon bench``: speed of renderer, environments and agent, on one core.

Options measure something else instead: ``--learning`` the speed of learners, ``--batched`` that of many homes at once,
``--scaling`` cost against the size of knowledge bases and homes. ``--cluster`` estimates how long a run takes on a
cluster.
"""

from __future__ import annotations

import argparse
import json
from itertools import count
from pathlib import Path
from typing import Any, Final

import ucon

_TIMES: Final = "times as fast as TinyRenderer"
_STEPS: Final = "steps a second"
_FRAMES: Final = "frames a second"
_LEARNED: Final = "decisions a second"
_SHARE: Final = "(fraction)"
#: Numbers of worker processes with which learners are measured.
_WORKERS: Final = (1, 2)
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
    "env_robot_sps": ("UcON-v0 with images, task=real_robot", _STEPS),
    "env_with_resets_sps": ("UcON-v0 with images, resets included", _STEPS),
    "search_decisions_per_s": ("UcONSearch-v0, choices at random", "choices a second"),
    "search_steps_per_decision": ("UcONSearch-v0, length of choices at random", "steps a choice"),
    "decisions_per_s": ("agent=belief, its environment included", _STEPS),
}
#: The same of ``--learning``; the number of worker processes is added to the name.
_OF_LEARNERS: Final = {
    "imitation_frames_per_s": ("end to end, imitation of searches", _FRAMES),
    "dagger_frames_per_s": ("end to end, DAgger by an agent that searches", _FRAMES),
    "ppo_frames_per_s": ("end to end, PPO", _FRAMES),
    "hybrid_ppo_decisions_per_s": ("habit_policy, PPO", _LEARNED),
    "foresight_labelled_per_s": ("habit_policy, foresight: played and labelled", _LEARNED),
    "foresight_learned_per_s": ("habit_policy, foresight: learned from", _LEARNED),
    "counterfactual_labelled_per_s": ("habit_policy, counterfactual: labelled by rollouts", _LEARNED),
    "counterfactual_learned_per_s": ("habit_policy, counterfactual: learned from", _LEARNED),
}
#: The same of ``--batched``.
_OF_BATCHES: Final = {
    "loop_sps": ("64 environments in a loop", _STEPS),
    "keeping_loop_sps": ("the same, keeping observations", _STEPS),
    "torchrl_sps": ("TorchRL's collector over a batch of 64 environments", _STEPS),
    "torchrl_overhead": ("the collector's extra time, relative to the loop", _SHARE),
    "torchrl_overhead_over_keeping": ("the same, relative to the loop that keeps observations", _SHARE),
    "workers_1_fps": ("TorchRL's collector in 1 worker process", _FRAMES),
    "workers_2_fps": ("TorchRL's collector in 2 worker processes", _FRAMES),
    "workers_gain": ("two workers over one", "times"),
    "larger_images": ("speed with images of 224 x 224, relative to 128 x 128", _SHARE),
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's options to its parser."""
    parser.add_argument("--json", action="store_true", help="print JSON")
    parser.add_argument("--no-renderer", action="store_true", help="skip the comparison with PyBullet's TinyRenderer")
    instead = parser.add_mutually_exclusive_group()
    instead.add_argument(
        "--learning", action="store_true", help="measure the learners instead, with 1 and 2 worker processes (minutes)"
    )
    instead.add_argument(
        "--batched",
        action="store_true",
        help="measure many homes at once instead: TorchRL's cost, 1 and 2 worker processes, larger images (minutes)",
    )
    instead.add_argument(
        "--cluster",
        type=Path,
        metavar="RUN",
        help="estimate instead how long a finished run would take on more workers, some of them slow and some lost",
    )
    parser.add_argument(
        "--workers",
        type=int,
        nargs="+",
        default=[8, 64, 512],
        help="with --cluster: numbers of workers (default: 8 64 512)",
    )
    parser.add_argument(
        "--runs", type=int, default=1, help="with --cluster: number of such runs, played together (default: 1)"
    )
    parser.add_argument(
        "--lost",
        type=float,
        default=0.05,
        metavar="RATE",
        help="with --cluster: losses per worker and hour (default: 0.05)",
    )
    parser.add_argument(
        "--slow",
        type=float,
        default=0.05,
        metavar="SHARE",
        help="with --cluster: share of workers half as fast (default: 0.05)",
    )
    instead.add_argument(
        "--scaling",
        action="store_true",
        help="measure cost against size instead: queries by sentences, steps by things and rooms (a minute)",
    )
    parser.add_argument(
        "--plot", type=Path, metavar="FOLDER", help="with --scaling: also draw both as PNG files into a folder"
    )


def run(args: argparse.Namespace) -> int:
    """Measure, and print a line per figure, or JSON.

    Args:
        args: parsed options.

    Returns:
        Exit code 0.

    Raises:
        ConfigError: ``--plot`` without ``--scaling``, or without matplotlib.
    """
    from ucon.core.errors import ConfigError
    from ucon.core.output import stdout_to_stderr

    if args.plot is not None and not args.scaling:
        raise ConfigError("bench --plot: only cost against size is drawn; add --scaling")
    if args.scaling:
        return _scaling(args)
    if args.cluster is not None:
        return _reckon(args)
    with stdout_to_stderr():
        if args.learning:
            figures, how = measure_learning(), "wall time, medians over steps; a step plays, feeds and updates"
        elif args.batched:
            figures, how = measure_batches(), "CPU time of one core, with workers wall time; medians over five rounds"
        else:
            figures = measure(renderer=not args.no_renderer)
            how = "CPU time of one process on one core; medians over homes, and the slowest home"
    if args.json:
        print(json.dumps(figures, indent=1))
    else:
        for name, value in figures.items():
            print(said(name, value))
        print(how)
    return 0


def _reckon(args: argparse.Namespace) -> int:
    """Print how long a run takes on a cluster, for each number of workers."""
    from dataclasses import asdict

    from ucon.cluster.schedule import Trouble, simulate
    from ucon.core.errors import ConfigError
    from ucon.evaluation.kept.finished import FinishedRun

    if args.runs < 1:
        raise ConfigError(f"--runs {args.runs}: expected a whole number from 1 up")
    seconds = [timing.seconds for timing in FinishedRun.read(args.cluster).timings()] * args.runs
    if not seconds:
        raise ConfigError(f"--cluster {args.cluster}: has no timings of its episodes; evaluate them again")
    trouble = Trouble(lost_per_hour=args.lost, slow_share=args.slow)
    found = [simulate(seconds, workers, trouble) for workers in args.workers]
    if args.json:
        print(json.dumps([asdict(one) | {"efficiency": one.efficiency} for one in found], indent=1))
        return 0
    print(f"{len(seconds)} episodes, {sum(seconds) / 3600:.2f} core hours")
    for one in found:
        print(
            f"{one.workers:>6} workers: {one.wall_s / 60:8.1f} min, {one.efficiency:4.0%} of their time used, "
            f"{one.lost} lost, {one.again_s / 3600:.2f} core hours repeated"
        )
    return 0


def said(name: str, value: float) -> str:
    """One line with a figure and its unit.

    Args:
        name: key in ``--json``; ``_worst`` at its end means the slowest home, a number the worker processes.
        value: of the figure.
    """
    base, _, last = name.rpartition("_")
    if last == "worst":
        what, more = base, ", slowest home"
    elif last.isdecimal() and base in _OF_LEARNERS:
        what, more = base, f", {last} worker{'s' * (last != '1')}"
    else:
        what, more = name, ""
    title, unit = (_FIGURES | _OF_LEARNERS | _OF_BATCHES)[what]
    digits = 2 if unit == _SHARE else 1
    return f"{title + more:<60} {value:>9.{digits}f} {unit}"


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


def measure_learning() -> dict[str, Any]:
    """Frames or decisions per second of every learner, by name and number of worker processes."""
    from ucon.core.progress import Progress
    from ucon.programs.learning_speed import learning_rates, stages

    done = count(1)
    with Progress("bench", stages(_WORKERS), unit="parts") as progress:
        return learning_rates(_WORKERS, lambda: progress.update(next(done)))


def measure_batches() -> dict[str, Any]:
    """Figures of ``--batched`` by name: cost of TorchRL, gain of a second worker, cost of larger images."""
    from ucon.core.progress import Progress
    from ucon.evaluation.bench_batched import STAGES, bench_batched
    from ucon.task.sets import load_episodes

    done = count(1)
    with Progress("bench", STAGES, unit="parts") as progress:
        return bench_batched(load_episodes("mini"), lambda: progress.update(next(done)))


def _scaling(args: argparse.Namespace) -> int:
    """Measure cost against size, and print tables or JSON."""
    from dataclasses import asdict

    from ucon.core.output import stdout_to_stderr
    from ucon.core.progress import Progress
    from ucon.evaluation import bench_scaling as scaling
    from ucon.evaluation.figures.plotting import require_matplotlib
    from ucon.evaluation.figures.scaling_plots import plot_scaling

    if args.plot is not None:
        require_matplotlib()  # before minutes of measuring
    with stdout_to_stderr(), Progress("bench", 3, unit="parts") as progress:
        embedding = scaling.query_embedding_ms(scaling.QUERIES)
        progress.update(1)
        queries = scaling.query_costs(scaling.SIZES, scaling.QUERIES)
        progress.update(2)
        steps = scaling.step_costs(scaling.HOMES)
        progress.update(3)
        if args.plot is not None:
            plot_scaling(queries, steps, args.plot)
    if args.json:
        found = {"retrieval": [asdict(cost) for cost in queries], "steps": [asdict(cost) for cost in steps]}
        print(json.dumps({"query_embedding_ms": embedding, **found}, indent=1))
        return 0
    columns = f"{'ms a query':>11} {'slowest':>9} {'first':>9} {'reset':>9}"
    print(f"{'ranking a knowledge base':<26} {'sentences':>10} {columns}")
    for query in queries:
        times = f"{query.query_ms:>11.2f} {query.query_ms_worst:>9.2f} {query.first_ms:>9.1f} {query.reset_ms:>9.1f}"
        print(f"{query.retriever:<26} {query.sentences:>10} {times}")
    print(f"embedding a new query with MiniLM: {embedding:.1f} ms")
    print(f"{'step with images in':<26} {'things':>10} {'rooms':>11} {'ms a step':>9}")
    for step in steps:
        print(f"{step.home:<26} {step.things:>10} {step.rooms:>11} {step.step_ms:>9.3f}")
    print("CPU time of one process: medians over queries, and the fastest walk of each episode")
    print("first: the query that builds the index; reset: the first query after a reset, which shuffles the sentences")
    return 0


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
