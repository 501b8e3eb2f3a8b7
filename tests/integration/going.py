"""A graph of test stages that runs while it is changed, in one worker or two."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from tests.commands import Started
from tests.integration import running
from tests.integration.running import Finished, finish, start, workers, write_graph

PATIENCE = 90.0
"""Seconds that bound a failure on a busy machine."""


def wait_until(condition: Callable[[], object]) -> bool:
    return running.wait_until(condition, PATIENCE)


APART = """
placement: apart
workers:
  other: {stages: [STAGE]}
"""


class Going:
    """A running graph; other runs may go on on this machine."""

    def __init__(self, folder: Path, stages: str, workers: int, apart: str) -> None:
        self.out = folder / "out"
        (folder / "apart.yaml").write_text(APART.replace("STAGE", apart))
        options = ("--placement", str(folder / "apart.yaml")) if workers == 2 else ()
        self.process = start(write_graph(folder, stages), self.out, *options)
        self.name = str(self.process.pid)

    @classmethod
    def of(cls, process: Started, out: Path) -> Going:
        """The run of a process that was started elsewhere."""
        run = cls.__new__(cls)
        run.out, run.process, run.name = out, process, str(process.pid)
        return run

    def values(self, file: str = "ticks.csv") -> list[int]:
        path = self.out / file
        lines = path.read_text().splitlines() if path.exists() else []
        return [int(fields[2]) for line in lines if len(fields := line.split(",")) == 4]

    def grows(self, more: int = 10) -> None:
        wanted = len(self.values()) + more
        assert wait_until(lambda: len(self.values()) >= wanted), "nothing is written any more"

    def step(self) -> int:
        """Difference of the newest two numbers, from one read because the file grows."""
        before, newest = self.values()[-2:]
        return newest - before

    def reaches(self, value: int, file: str) -> None:
        assert wait_until(lambda: self.values(file)[-1] > value)

    def workers(self) -> list[int]:
        """Process ids of the workers, in the order of the graph until one is restarted."""
        return workers(self.process.pid)

    def stopped(self) -> Finished:
        self.process.send_signal(signal.SIGINT)
        return finish(self.process, self.out)


@contextmanager
def going(folder: Path, stages: str, workers: int, apart: str = "b") -> Iterator[Going]:
    """apart: the stage in the second worker."""
    run = Going(folder, stages, workers, apart)
    try:
        run.grows()
        yield run
    finally:
        if run.process.poll() is None:
            run.process.kill()
