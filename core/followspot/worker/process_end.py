"""`os._exit` while workers live: an error of the stage that calls it.

If a worker is a thread of its host, the call would end the whole run without a message, and with the exit
code that the stage chose, perhaps 0. If the worker is a process, its host could not tell which stage made the
call.
"""

from __future__ import annotations

import os
import threading
from typing import NoReturn

end_process = os._exit
"""Ends this process at once."""


class ProcessEndError(RuntimeError):
    """A stage called `os._exit`."""

    def __init__(self, status: int) -> None:
        super().__init__(
            f"os._exit({status}) would end the process with all its stages; raise an error in its place"
        )


class StagesCannotExit:
    """A context that all workers of a process share: within it `os._exit` raises.

    It does not raise in the main thread of a script, nor in processes that a stage forks.
    """

    def __init__(self) -> None:
        self._guard = threading.Lock()
        self._workers: list[threading.Thread] = []
        self._process = 0

    def __enter__(self) -> None:
        with self._guard:
            self._process = os.getpid()
            self._workers.append(threading.current_thread())
            os._exit = self._exit

    def __exit__(self, *_: object) -> None:
        with self._guard:
            self._workers.remove(threading.current_thread())
            if not self._workers:
                os._exit = end_process

    def _exit(self, status: int) -> NoReturn:
        """In place of `os._exit`. Raises ProcessEndError in a worker, and in threads of its stages."""
        thread = threading.current_thread()
        of_script = thread is threading.main_thread() and thread not in self._workers
        if of_script or os.getpid() != self._process:
            end_process(status)
        raise ProcessEndError(status)


STAGES_CANNOT_EXIT = StagesCannotExit()
"""Of this process."""
