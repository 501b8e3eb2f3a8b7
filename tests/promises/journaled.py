"""Runs whose stages keep journals, and what can befall their processes."""

from __future__ import annotations

import json
import os
import signal
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, Self

from tests.commands import Process, command
from tests.integration.running import Finished, alive, finish, wait_until, workers
from tests.promises.ledger_check import Journals, disagreements, journals_of

STAGES = Path(__file__).parent / "journal.py"
FOREVER = 60.0
"""Seconds until a failure is reported."""


class Journaled:
    """A run that goes on, and its journals.

    workers: each with a stage of it that gets or makes every message.
    """

    def __init__(self, name: str, folder: Path, out: Path, workers: Mapping[str, str]) -> None:
        """name: of the graph; folder: of the journals."""
        self.name = name
        self.folder = folder
        self.out = out
        self.workers = workers
        self.journals = Journals(folder)
        self.process: Process
        self.killed: set[int] = set()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        """Leave nothing behind if the test failed; workers end when their operator does."""
        if self.process.poll() is None:
            self.process.kill()
            self.process.communicate()

    def told(self, *words: str) -> str:
        """What a command says that sees what the run sees."""
        return command(*words, timeout=FOREVER, check=True).stdout

    def parents(self) -> Sequence[int]:
        """Processes that start workers."""
        return [self.process.pid]

    def lines(self, stage: str) -> int:
        """How many messages a stage was given and made."""
        return sum(len(path.read_bytes().splitlines()) for path in self.journals.files(stage))

    def goes_on(self, *stages: str, count: int = 10) -> None:
        """Wait until each of these stages, or one of each worker, has done so much more."""
        for stage in stages or self.workers.values():
            wanted = self.lines(stage) + count
            assert wait_until(lambda s=stage, n=wanted: self.lines(s) >= n, FOREVER), f"{stage} stands still"  # type: ignore[misc]

    def kill(self, worker: str) -> None:
        self.killed.add(self.signal(worker, signal.SIGKILL))

    def hang(self, worker: str) -> None:
        """Until its host has had enough."""
        pid = self.signal(worker, signal.SIGSTOP)
        assert wait_until(lambda: not alive(pid), FOREVER), "the host does not notice that it hangs"
        self.killed.add(pid)

    def suspend(self, worker: str) -> None:
        """For as long as another one makes five messages, or half a second."""
        pid = self.signal(worker, signal.SIGSTOP)
        other = next(stage for name, stage in self.workers.items() if name != worker)
        wanted = self.lines(other) + 5
        wait_until(lambda: self.lines(other) >= wanted, 0.5)
        with suppress(ProcessLookupError):
            os.kill(pid, signal.SIGCONT)

    @contextmanager
    def asked(self, what: str, stage: str) -> Iterator[None]:
        """While a stage is asked to misbehave."""
        path = self.folder / f"{what}.{stage}"
        path.touch()
        try:
            yield
        finally:
            path.unlink()

    def status(self) -> list[dict[str, Any]]:
        """The ledger as `followspot top` shows it now."""
        edges: list[dict[str, Any]] = json.loads(self.told("top", "--run", self.name, "--json"))["edges"]
        return edges

    def end(self) -> Finished:
        """As Ctrl-C does."""
        self.process.send_signal(signal.SIGINT)
        return finish(self.process, self.out)

    def judge(self, finished: Finished, *, with_dead: bool = False) -> None:
        """Compare what the run says with the journals.

        with_dead: whether it may end while workers are dead: then it says so, and fails.
        """
        told = finished.summary.get("errors", [])
        of_dead = [line for line in told if "was not there at the end: it had died" in line]
        code = 1 if with_dead and told and of_dead == told else 0
        assert finished.code == code, finished.errors + json.dumps(told)
        found = disagreements(
            finished.summary["edges"], journals_of(self.folder, finished.summary["warnings"], self.killed)
        )
        assert not found, "\n".join(found)

    def signal(self, worker: str, number: signal.Signals) -> int:
        pid = self.journals.pid(self.workers[worker])
        if any(pid in workers(parent) for parent in self.parents()):  # else another fault had it
            os.kill(pid, number)
        return pid
