"""The connection to a Ray cluster: a running one, given by its address, or one on this machine for this process."""

from __future__ import annotations

import logging
import os
import socket
from pathlib import Path
from typing import Any, Final

import ucon
from ucon.core.errors import ConfigError, brief
from ucon.core.pool import ONE_THREAD, usable_cores

#: Seconds within which a cluster has to answer.
_ANSWER_S: Final = 10.0
_REMEDY: Final = "start one with `ray start --head`, or leave the address out for one on this machine"
#: The address that :func:`connect` connected this process to; in a tuple, since an address may be None.
_connected_to: tuple[str | None] | None = None


def connect(address: str | None, cpus: int | None = None) -> Any:
    """Connect this process to a cluster; does nothing if it is already connected to it.

    The connection lasts until the process ends or connects to another address. A connection that other code made is
    used as it is.

    Args:
        address: ``host:port``, or ``auto`` for the cluster that runs on this machine; None: a cluster of this process
            alone, which ends with it.
        cpus: CPUs of a cluster of this process alone; None: the cores that the process may use.

    Returns:
        The module ``ray``.

    Raises:
        ConfigError: Ray is not installed, or no cluster answers at the address.
    """
    if address is None:
        os.environ.setdefault("RAY_AUTH_MODE", "disabled")  # nobody else reaches it
        os.environ.setdefault("RAY_worker_niceness", "0")  # its workers are all that this command runs
    elif address != "auto":
        _check_answers(address)
    global _connected_to
    # Otherwise leftovers of an ended connection would start a cluster.
    os.environ.setdefault("RAY_ENABLE_AUTO_CONNECT", "0")
    os.environ.setdefault("RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO", "0")
    try:
        import ray
    except ImportError:
        raise ConfigError("Ray is not installed: pip install 'ucon-nav[ray]'") from None
    if ray.is_initialized():
        if _connected_to in (None, (address,)):  # None: other code connected this process
            return ray
        ray.shutdown()
    local: dict[str, Any] = {}
    if address is None:
        local = {"num_cpus": cpus or usable_cores(), "include_dashboard": False}
    try:
        ray.init(
            address=address or "local",
            log_to_driver=False,
            logging_level=logging.ERROR,
            runtime_env={"env_vars": {"PYTHONPATH": _python_path(), **ONE_THREAD}},
            **local,
        )
    except (ConnectionError, ValueError, RuntimeError) as error:
        first = str(error).strip().splitlines()[0] if str(error).strip() else type(error).__name__
        raise ConfigError(f"address={brief(address)}: no Ray cluster ({brief(first)}); {_REMEDY}") from None
    _connected_to = (address,)
    return ray


def _check_answers(address: str) -> None:
    """Refuse an address that is no ``host:port`` or where no server answers: Ray would try for minutes.

    Raises:
        ConfigError: naming the address.
    """
    host, _, port = address.rpartition(":")
    if "://" in address or not host or not port.isdecimal() or int(port) > 65535:
        raise ConfigError(f"address={brief(address)}: expected host:port, or auto for the cluster on this machine")
    try:
        socket.create_connection((host.strip("[]"), int(port)), timeout=_ANSWER_S).close()
    except OSError as error:
        raise ConfigError(f"address={brief(address)}: no answer there ({error}); {_REMEDY}") from None


def cluster_cpus(ray: Any) -> int:
    """CPUs of the cluster that this process is connected to."""
    return max(1, int(ray.cluster_resources().get("CPU", 1)))


def _python_path() -> str:
    """``PYTHONPATH`` of workers: they find ``ucon`` and ``models`` in the same folder as this process."""
    root = str(Path(ucon.__file__).resolve().parents[1])
    return os.pathsep.join([root, *filter(None, os.environ.get("PYTHONPATH", "").split(os.pathsep))])
