"""Limits linear algebra to one thread while workers live.

More threads would add up in another order and give other bits; a worker process and a worker in a script's
own process must give the same. Workers are the parallelism instead.
"""

from __future__ import annotations

import os
from threading import Lock
from typing import Any

from threadpoolctl import threadpool_limits

_VARIABLE = "OPENBLAS_NUM_THREADS"
"""For libraries that are loaded while workers live, such as those of plugins."""


class BlasLimit:
    """A context that all workers of a process share: the last one that leaves ends the limit."""

    def __init__(self) -> None:
        self._guard = Lock()
        self._workers = 0
        self._limits: Any = None
        self._before: str | None = None

    def __enter__(self) -> None:
        with self._guard:
            self._workers += 1
            if self._workers == 1:
                self._before = os.environ.get(_VARIABLE)
                os.environ[_VARIABLE] = "1"
                self._limits = threadpool_limits(1, user_api="blas")

    def __exit__(self, *_: object) -> None:
        with self._guard:
            self._workers -= 1
            if self._workers == 0 and self._limits is not None:
                self._limits.restore_original_limits()
                os.environ.pop(_VARIABLE)
                if self._before is not None:
                    os.environ[_VARIABLE] = self._before


ONE_BLAS_THREAD = BlasLimit()
"""Of this process."""
