"""Processes that work for a learner: one thread each, and none outlives it."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading

from ucon.core.memory import keep_freed_memory


def begin_worker() -> None:
    """To be called first in a worker. It leaves Ctrl-C to the learner, and ends when the learner is killed."""
    import torch

    torch.set_num_threads(1)
    keep_freed_memory()
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    if (parent := multiprocessing.parent_process()) is not None:
        parent.join()
        os._exit(1)
