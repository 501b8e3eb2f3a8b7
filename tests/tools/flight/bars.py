"""A live graph whose stages give what only their inputs in the run decide, for tests of `followspot verify`.

It has a join with a deadline, an edge that drops, and an input that goes by arrival.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import pytest
from tests.commands import launch

import followspot as fs
from followspot.cli.main import main
from followspot.errors import FollowspotError
from followspot.library.handle import RunHandle

STAGES = """
import time
from followspot import Field, Joined, Latest, Message, Source, Stage, StageParams, at

class Beat(Message):
    bar: int

class Drum(Stage):
    live = True

    class Params(StageParams):
        pause: float = Field(0.01, description="between two beats", unit="s")

    def process(self) -> Source[Beat]:
        bar = 0
        while self.context.pause(self.params.pause):
            yield Beat(bar)
            bar += 1

class Meet(Stage):
    def process(self, beats: Joined[Beat]) -> Beat:
        return Beat(sum((n + 1) * beat.bar for n, beat in enumerate(beats)))

class Sum(Stage):
    class Params(StageParams):
        factor: int = Field(1, description="of each bar")

    total = 0

    def process(self, beat: Beat, other: Latest[Beat]) -> Beat:
        self.total += self.params.factor * beat.bar + (0 if other is None else other.bar)
        return Beat(self.total)

    def state(self):
        return self.total

    def restore(self, state):
        self.total = state

class Slow(Stage):
    def process(self, beat: Beat) -> Beat:
        time.sleep(0.03)
        return Beat(beat.bar)

class Secret(Stage):
    total = 0

    def process(self, beat: Beat) -> Beat:
        self.total += 1
        return Beat(self.total)
"""
GRAPH = """
graph: bars
stages:
  left: {uses: bars.drum}
  right: {uses: bars.drum, with: {pause: 0.017}}
  meet: {uses: bars.meet, in: {beats: [left, right]}, tolerance: 0.004, deadline: 0.005}
  sum: {uses: bars.sum, in: {beat: left, other: slow}}
  slow: {uses: bars.slow, in: {beat: {from: right, policy: latest}}}
"""
SECRET = "  secret: {uses: bars.secret, in: {beat: meet}}\n"
APART = "placement: apart\nworkers:\n  one: {stages: [left, meet, sum]}\n  two: {stages: [right, slow]}\n"
TIMEOUT = 120.0
PORTS = {"meet.out", "sum.out", "slow.out"}


def wait_until(happens: Callable[[], bool]) -> None:
    deadline = time.monotonic() + TIMEOUT
    while not happens():
        assert time.monotonic() < deadline
        time.sleep(0.05)


@contextmanager
def running(*words: object) -> Iterator[RunHandle]:
    """A run of the command line that has fired 50 times; it is stopped at the end, and must succeed."""
    with launch("run", *words, "--quiet") as process:

        def found() -> RunHandle | None:
            with suppress(FollowspotError):
                run = fs.connect(str(process.pid))
                return run if run.status().fired > 50 else None
            return None

        try:
            wait_until(lambda: found() is not None)
            run = fs.connect(str(process.pid))
            yield run
            run.stop()
            _, errors = process.communicate(TIMEOUT)
        except BaseException:
            process.kill()
            raise
    assert process.returncode == 0, errors


def fire(run: RunHandle, times: int) -> None:
    """Wait until the stages of a run have fired so many times more."""
    before = run.status().fired
    wait_until(lambda: run.status().fired > before + times)


def written(folder: Path) -> Path:
    """The folder with the graphs and the file of their stages."""
    (folder / "bars.py").write_text(STAGES)
    (folder / "bars.yaml").write_text(GRAPH)
    (folder / "secret.yaml").write_text(GRAPH + SECRET)
    (folder / "apart.yaml").write_text(APART)
    return folder


def verified(path: Path, folder: Path, capsys: pytest.CaptureFixture[str]) -> dict[str, Any]:
    capsys.readouterr()
    code = main(["verify", str(path), "--plugin", str(folder / "bars.py"), "--json", "--quiet"])
    found: dict[str, Any] = json.loads(capsys.readouterr().out)
    assert code == (0 if found["same"] else 1)
    return found


def differing(found: Mapping[str, Any]) -> list[str]:
    return [port["port"] for port in found["ports"] if port["difference"]]
