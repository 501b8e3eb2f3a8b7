"""The ledger tells the truth: journals of the stages agree with it, whatever befalls the run.

Faults at random: workers killed, hanging, suspended for a moment; readers that are slow; a disk that is full.
"""

from __future__ import annotations

import json
import os
import random
import signal
import subprocess
import uuid
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Self

import pytest
from books import Books, books_of, disagreements, impossible
from running import COMMAND, Finished, alive, children, finish, start, wait_until, write_graph

STAGES = Path(__file__).parent / "journal.py"
LIVE = """
cam:   {uses: journal.camera}
left:  {uses: journal.step, with: {invalid_every: 50}, in: {note: cam}}
right: {uses: journal.sampling, in: {note: {from: cam, policy: drop_oldest}, known: {from: both, delay: 1}}}
split: {uses: journal.split, in: {note: cam}}
even:  {uses: journal.step, in: {note: split.even}}
both:  {uses: journal.meet, in: {notes: [left, right]}}
save:  {uses: journal.save, in: {note: both}, on_error: skip}
odd:   {uses: journal.save, with: {path: odd.csv}, in: {note: split.odd}, on_error: skip}
rest:  {uses: journal.save, with: {path: even.csv}, in: {note: even}, on_error: skip}
"""
PLACEMENT = """
placement: five
workers:
  first:  {stages: [cam]}
  second: {stages: [left, split]}
  third:  {stages: [right]}
  fourth: {stages: [both, save]}
  fifth:  {stages: [even, rest, odd]}
"""
WORKERS = {"first": "cam", "second": "left", "third": "right", "fourth": "both", "fifth": "odd"}
"""Each worker with a stage of it that gets every message."""
FOREVER = 60.0
"""Seconds that only bound a failure."""


class Run:
    """A live run of five workers whose stages keep journals."""

    def __init__(self, folder: Path, edges: str, size: int = 0) -> None:
        self.folder = folder / "books"
        self.folder.mkdir()
        self.books = Books(self.folder)
        self.name = f"accounts-{uuid.uuid4().hex[:8]}"
        graph = write_graph(folder, LIVE, self.name)
        placement = folder / "placement.yaml"
        placement.write_text(PLACEMENT)
        self.out = folder / "out"
        words = ("--plugin", str(STAGES), "--placement", str(placement), "--edges", edges)
        os.environ["BOOKS"] = str(self.folder)
        self.process = start(graph, self.out, *words, "--set", f"cam.size={size}")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        """Leave nothing behind where the test failed; workers end when their operator does."""
        if self.process.poll() is None:
            self.process.kill()
            self.process.communicate()

    def lines(self, stage: str) -> int:
        """How many messages a stage was given."""
        return sum(len(path.read_bytes().splitlines()) for path in self.books.journals(stage))

    def goes_on(self, *stages: str, count: int = 10) -> None:
        """Wait until each of these stages has done so much more."""
        wanted = {stage: self.lines(stage) + count for stage in stages or WORKERS.values()}
        for stage, lines in wanted.items():
            assert wait_until(lambda s=stage, n=lines: self.lines(s) >= n, FOREVER), f"{stage} does not go on"  # type: ignore[misc]

    def signal(self, worker: str, number: signal.Signals) -> int:
        pid = self.books.pid(WORKERS[worker])
        if pid in children(self.process.pid):  # else another fault had it
            os.kill(pid, number)
        return pid

    def kill(self, worker: str) -> None:
        self.signal(worker, signal.SIGKILL)

    def hang(self, worker: str) -> None:
        """Until its host has had enough."""
        pid = self.signal(worker, signal.SIGSTOP)
        assert wait_until(lambda: not alive(pid), FOREVER), "nobody minds that it hangs"

    def suspend(self, worker: str) -> None:
        """For as long as another one makes five messages, or it hangs for too long."""
        pid = self.signal(worker, signal.SIGSTOP)
        other = "odd" if worker == "first" else "cam"
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

    def status(self) -> list[dict[str, object]]:
        """The ledger as `followspot top` shows it now."""
        words = [*COMMAND, "top", self.name, "--json"]
        said = subprocess.run(words, capture_output=True, text=True, timeout=FOREVER, check=False)
        edges: list[dict[str, object]] = json.loads(said.stdout)["edges"]
        return edges

    def end(self) -> Finished:
        self.process.send_signal(signal.SIGINT)
        return finish(self.process, self.out)

    def judge(self) -> None:
        """End the run and compare."""
        finished = self.end()
        assert finished.code == 0, finished.errors + json.dumps(finished.summary.get("errors"))
        found = disagreements(finished.summary, books_of(self.folder, finished.summary))
        assert not found, "\n".join(found)


def befall(run: Run, chance: random.Random, faults: int) -> None:
    """Faults one after the other, some of them while the last one is not over yet."""
    kinds: list[Callable[[str], None]] = [run.kill, run.kill, run.hang, run.suspend]
    for _ in range(faults):
        kind, worker = chance.choice(kinds), chance.choice(list(WORKERS))
        misbehaving = chance.choice([("slow", "left"), ("slow", "odd"), ("full", "save"), ("slow", "right")])
        with run.asked(*misbehaving):
            kind(worker)
            if chance.random() < 0.3:
                run.kill(chance.choice(list(WORKERS)))
        if chance.random() < 0.7:
            run.goes_on()


@pytest.mark.parametrize(("edges", "size", "seed"), [("ring", 6000, 1), ("zenoh", 0, 5)])
def test_journals_agree_with_the_ledger_after_faults_at_random(
    tmp_path: Path, edges: str, size: int, seed: int
) -> None:
    with Run(tmp_path, edges, size) as run:
        run.goes_on()
        befall(run, random.Random(seed), 3)
        assert not list(impossible(run.status()))
        run.judge()


@pytest.mark.thorough
@pytest.mark.parametrize("edges", ["ring", "zenoh"])
@pytest.mark.parametrize("seed", range(100, 112))
def test_journals_agree_with_the_ledger_after_many_faults(tmp_path: Path, edges: str, seed: int) -> None:
    chance = random.Random(seed)
    with Run(tmp_path, edges, size=chance.choice([0, 6000])) as run:
        run.goes_on()
        for _ in range(3):
            befall(run, chance, 3)
            assert not list(impossible(run.status()))
        run.judge()
