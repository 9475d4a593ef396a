"""Compiles the numba kernels that an episode and a searching agent need, by playing a few steps."""

from __future__ import annotations

import time
import warnings

from ucon.core.errors import UconError
from ucon.core.pool import Pool
from ucon.envs.ucon_env import UcONEnv
from ucon.perception.detectors.noisy import NoisyDetector
from ucon.perception.warm import look_around
from ucon.sim.bullet import bullet

#: Actions that together call every kernel: turns, looks, moves, an Open and Done.
WARMING = (0, 1, 1, 2, 3, 4, 4, 3, 2, 5, 0, 0, 6)


def compile_kernels() -> float:
    """Compile every kernel into the cache on disk, in two processes at once.

    Functions that both halves need are called with arguments of the same types: numba's cache does not support two
    processes that compile one function for different types.

    Returns:
        Seconds taken.
    """
    started = time.perf_counter()
    with Pool(1) as pool:
        drawn = pool.submit(warm_drawing)
        warm_mapping()
        pool.result(drawn)
    warm_up()
    return time.perf_counter() - started


def warm_drawing() -> None:
    """Compile the renderer, the painter of frames and the noisy detector."""
    env = UcONEnv("mini", detector=NoisyDetector(), render_mode="rgb_array")
    env.reset(options={"episode": 0})
    for action in WARMING:
        env.step(action)
    env.render()
    env.close()


def warm_mapping() -> None:
    """Compile mapping and search on frames of PyBullet's renderer; does nothing without PyBullet."""
    try:
        bullet()
    except UconError:
        return
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # the renderer warns that it is slow
        env = UcONEnv("mini", observe="symbolic", detector=True, renderer="tiny")
    look_around(env, WARMING)
    env.close()


def warm_up() -> float:
    """Play a few steps with everything, in this process: compiles what is not cached, and loads the rest.

    Returns:
        Seconds taken.
    """
    started = time.perf_counter()
    for env in (
        UcONEnv("mini", detector=True, render_mode="rgb_array"),
        UcONEnv("mini", observe="symbolic", detector=True, render_mode="rgb_array"),
        UcONEnv("mini", observe="symbolic", detector=NoisyDetector(), render_mode="rgb_array"),
    ):
        look_around(env, WARMING)
        env.render()
        env.close()
    return time.perf_counter() - started
