"""The runs of a sweep, several at a time, with a line of progress after each."""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import suppress
from subprocess import Popen
from threading import Lock

from followspot_sweep.trial import Result, Task, kept, run


def run_all(tasks: Sequence[Task], jobs: int, *, quiet: bool) -> list[Result]:
    """The results in the order of the tasks; tasks with a kept result are not run again.

    jobs: most runs at a time. Raises KeyboardInterrupt on Ctrl-C, after it has ended every run.
    """
    results = {task: result for task in tasks if (result := kept(task)) is not None}
    waiting = [task for task in tasks if task not in results]
    if results and not quiet:
        print(f"{len(results)} of {len(tasks)} are done already", file=sys.stderr, flush=True)
    processes = _Processes()
    begun = time.monotonic()
    pool = ThreadPoolExecutor(jobs)
    futures = [pool.submit(run, task, processes.add) for task in waiting]
    try:
        for future in as_completed(futures):
            result = future.result()
            results[result.task] = result
            if not quiet:
                left = _time_left(len(tasks) - len(results), len(waiting), time.monotonic() - begun)
                line = f"{len(results)}/{len(tasks)}  {_text(result)}{left}"
                print(line, file=sys.stderr, flush=True)
    except KeyboardInterrupt:
        print(f"{len(results)} of {len(tasks)} are done; the same command goes on", file=sys.stderr)
        raise
    finally:
        pool.shutdown(wait=False, cancel_futures=True)
        processes.terminate()
    return [results[task] for task in tasks]


class _Processes:
    """The processes of all runs; safe from several threads."""

    def __init__(self) -> None:
        self._all: set[Popen[str]] = set()
        self._lock = Lock()

    def add(self, process: Popen[str]) -> None:
        with self._lock:
            self._all.add(process)

    def terminate(self) -> None:
        """End those that still run."""
        with self._lock:
            for process in self._all:
                with suppress(OSError):
                    process.terminate()


def _text(result: Result) -> str:
    """Room and point of a task that has ended, and whether it failed."""
    words = ", ".join(f"{name}={value}" for name, value in result.task.point)
    return f"{result.task.room}: {words}  {'failed' if result.error else 'done'}"


def _time_left(left: int, tasks: int, seconds: float) -> str:
    """The estimated time for the remaining tasks as text; seconds: since the first began."""
    return f", about {seconds * left / (tasks - left):.0f} s left" if 0 < left < tasks else ""
