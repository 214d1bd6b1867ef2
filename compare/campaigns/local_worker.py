"""Set up each worker of a local cluster: it ends with its parent process, which handles Ctrl-C."""

import logging
import os
import signal

from femic.cache.workers import end_with_parent


def dask_setup(_worker: object) -> None:
    """Prepare the process of a worker, in its main thread."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    end_with_parent(os.getppid())
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
