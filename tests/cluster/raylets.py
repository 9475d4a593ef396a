"""A cluster of two raylets on this machine."""

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

ROOT = Path(__file__).parents[2]
#: Most seconds until started workers are placed.
PLACED_S = 60.0
#: Most seconds until a killed process has ended.
ENDED_S = 30.0


class Raylets:
    """Two raylets; the second can be killed."""

    def __init__(self, cpus: int) -> None:
        from ray.cluster_utils import Cluster

        options = {"num_cpus": cpus, "object_store_memory": 200 * 2**20}
        self._cluster = Cluster(initialize_head=True, head_node_args=options | {"include_dashboard": False})
        self._second = self._cluster.add_node(**options)
        self.address: str = self._cluster.address

    def wait_until_full(self) -> None:
        """Wait until every CPU has a worker, so that a raylet killed afterwards takes one with it."""
        import ray

        end = time.monotonic() + PLACED_S
        while ray.available_resources().get("CPU", 0):
            assert time.monotonic() < end, "workers without a place"
            time.sleep(0.1)

    def kill_second(self) -> None:
        """Kill the second raylet with all its workers, as if a machine were lost."""
        if self._second is not None:
            self._cluster.remove_node(self._second, allow_graceful=False)
            self._second = None

    def close(self) -> None:
        import ray

        ray.shutdown()
        self._cluster.shutdown()


@contextmanager
def two_raylets(cpus: int = 1) -> Iterator[Raylets]:
    """Context manager: two raylets with ``cpus`` each."""
    os.environ.update(RAY_AUTH_MODE="disabled", RAY_worker_niceness="0", RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO="0")
    made = Raylets(cpus)
    try:
        yield made
    finally:
        made.close()


def wait_until_ended(processes: list[int]) -> None:
    """Wait until none of the processes runs: a killed process ends a moment later."""
    end = time.monotonic() + ENDED_S
    while running := [process for process in processes if is_running(process)]:
        assert time.monotonic() < end, f"still running: {running}"
        time.sleep(0.1)


def is_running(process: int) -> bool:
    """Whether a process runs; a zombie does not."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False
