"""One log of a run from those of its hosts."""

from __future__ import annotations

from collections.abc import Sequence
from threading import Lock
from typing import Protocol

from followspot.log.run_log import OnLog, RunLog


class Logging(Protocol):
    """A host that keeps a log."""

    @property
    def log(self) -> RunLog:
        """The host's log."""


class MergedLog(RunLog):
    """Merges the logs of all hosts, in the order in which records arrive here."""

    def __init__(self, hosts: Sequence[Logging], on_log: OnLog | None = None) -> None:
        super().__init__(on_log)
        self._taken = [(host, [-1]) for host in hosts]
        self._gathering = Lock()

    def join(self, host: Logging) -> None:
        """Merge the log of one more host."""
        with self._gathering:
            self._taken.append((host, [-1]))

    def gather(self) -> None:
        """Take new records of all hosts. Safe from any thread."""
        with self._gathering:
            for host, last in self._taken:
                while host.log.last > last[0]:
                    page = host.log.after(last[0])
                    last[0] = page.last
                    self.add(*page.records)
