"""A source that plays at a pace: nothing is sent early, and its worker works on meanwhile."""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass
from pathlib import Path

import pytest
from tests.core.worker.solo import Solo
from tests.integration.running import wait_until

from followspot.graph.compile import compile_graph

PACED = Path(__file__).parents[2] / "stages" / "paced.py"
PATIENCE = 60.0
GRAPH = """graph: paced
stages:
  free: {uses: paced.pace, with: {count: 9, interval: 0}}
  slow: {uses: paced.pace, with: {waits_at: -1}}
  look: {uses: paced.punctual, in: {number: slow}}
"""
BOTH_WAIT = """graph: paced
stages:
  one: {uses: paced.pace, with: {waits_at: 0}}
  two: {uses: paced.pace, with: {waits_at: 0}}
  look: {uses: paced.together, in: {left: one, right: two}}
"""


def solo(folder: Path, waits_at: int = -1) -> Solo:
    (folder / "g.yaml").write_text(GRAPH.replace("-1", str(waits_at)))
    return Solo(compile_graph(folder / "g.yaml", plugin_files=[PACED]), folder)


def test_no_message_is_sent_before_its_time(tmp_path: Path) -> None:
    run = solo(tmp_path)
    report = run.run()
    assert report.errors == ()
    assert [source.yielded for source in run.scheduler.sources.all] == [9, 5]


def test_while_a_source_waits_its_worker_works_and_no_other_source_goes_ahead(tmp_path: Path) -> None:
    run = solo(tmp_path, waits_at=2)
    free, slow = run.scheduler.sources.all
    thread = threading.Thread(target=run.run)
    thread.start()

    def seen() -> tuple[bool, int, int]:
        """Whether the slow one waits, and what both have yielded, as the worker's thread sees it."""
        found: list[tuple[bool, int, int]] = []
        looked = threading.Event()
        run.scheduler.between_firings(lambda: found.append((slow.early, free.yielded, slow.yielded)))
        run.scheduler.between_firings(looked.set)
        assert looked.wait(PATIENCE), "the worker's thread sleeps"
        return found[0]

    assert wait_until(lambda: seen() == (True, 3, 2), PATIENCE)
    assert {seen() for _ in range(20)} == {(True, 3, 2)}
    run.scheduler.stop()
    thread.join(PATIENCE)
    assert not thread.is_alive()
    assert slow.yielded == 2  # what waited is not sent when the run ends


def test_after_each_message_that_is_made_and_kept_others_have_their_turn(tmp_path: Path) -> None:
    """To make one takes time, a video's picture for one, and stages may have become ready meanwhile."""
    (tmp_path / "g.yaml").write_text(BOTH_WAIT)
    run = Solo(compile_graph(tmp_path / "g.yaml", plugin_files=[PACED]), tmp_path)
    run.scheduler.setup()
    sources = run.scheduler.sources
    kept = []
    while sources.pull():
        kept.append([source.keeps for source in sources.all])
    assert kept == [[True, False], [True, True]]
    assert [source.yielded for source in sources.all] == [0, 0]
    run.scheduler.close()


def test_what_falls_due_just_before_the_worker_sleeps_is_sent(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = solo(tmp_path)
    finished = run.scheduler._finished

    def finished_late() -> bool:
        time.sleep(0.025)  # longer than from one message to the next
        return finished()

    monkeypatch.setattr(run.scheduler, "_finished", finished_late)
    assert run.run().errors == ()
    assert [source.yielded for source in run.scheduler.sources.all] == [9, 5]


PERIOD = 20_000_000
BEGUN = 1_000_000_000


@dataclass
class Clock:
    """Stands still until it is told otherwise, ns."""

    now: int = BEGUN

    def __call__(self) -> int:
        return self.now


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    """In place of the monotonic clock."""
    clock = Clock()
    monkeypatch.setattr(time, "monotonic_ns", clock)
    return clock


def after_sending(folder: Path, clock: Clock, made_in: tuple[int, int]) -> Solo:
    """Two sources that have just sent a message; each took so long to make it, ns."""
    (folder / "g.yaml").write_text(BOTH_WAIT.replace("waits_at: 0", f"interval: {PERIOD}"))
    run = Solo(compile_graph(folder / "g.yaml", plugin_files=[PACED]), folder)
    run.scheduler.setup()
    sources = run.scheduler.sources
    while sources.pull():
        pass
    assert [(source.yielded, source.keeps) for source in sources.all] == [(1, True), (1, True)]
    clock.now = BEGUN + PERIOD
    for source, ns in zip(sources.all, made_in, strict=True):
        source.made_in = ns
        source.pull()
    return run


@pytest.mark.parametrize(
    ("made_in", "rest"),
    [((0, 0), 10_000_000), ((3_000_000, 4_000_000), 6_000_000), ((5_000_000, 9_000_000), 0)],
    ids=["half of the interval", "half of what is left", "none"],
)
def test_after_it_has_sent_a_source_leaves_the_cores_to_the_stages(
    tmp_path: Path, clock: Clock, made_in: tuple[int, int], rest: int
) -> None:
    """Its worker has nothing to do then, but the stages of its message may be in other workers."""
    run = after_sending(tmp_path, clock, made_in)
    sources = run.scheduler.sources
    if rest:
        clock.now += rest - 1
        assert not sources.pull()
        assert list(sources.due()) == [(BEGUN + PERIOD + rest) / 1e9]
        clock.now += 1
    assert sources.pull()
    assert [source.keeps for source in sources.all] == [True, False]
    run.scheduler.close()


def test_a_source_that_is_to_stop_does_not_rest(tmp_path: Path, clock: Clock) -> None:
    run = after_sending(tmp_path, clock, made_in=(0, 0))
    run.scheduler.sources.stop()
    while run.scheduler.sources.pull():
        pass
    assert all(source.done for source in run.scheduler.sources.all)
    run.scheduler.close()
