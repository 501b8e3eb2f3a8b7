"""A tap sees every message of a port, and nothing that befalls it reaches the graph."""

from __future__ import annotations

import threading
from pathlib import Path
from typing import Any, ClassVar

import pytest
from tests.core.worker.solo import Solo

from followspot import Message, Stage
from followspot.control import tapping as requested
from followspot.control.tapping import Tapping
from followspot.graph.compile import compile_graph
from followspot.worker.taps import port_taps as tapping
from followspot.worker.taps.port_taps import Tap

STAGES = Path(__file__).parents[2] / "stages" / "ticks.py"
GRAPH = """\
graph: count
stages:
  count: {uses: ticks.count, with: {count: 30}}
  write: {uses: ticks.write, in: {number: count}}
"""


class Seen(Stage):
    """Remembers what it sees; raises at the fifth if it is told so."""

    tap = True
    seen: ClassVar[list[int]] = []
    closed: ClassVar[list[str]] = []
    raises: ClassVar[type[Exception] | None] = None

    def process(self, message: Message) -> None:
        self.seen.append(message.header.seq)
        if self.raises is not None and len(self.seen) == 5:
            raise self.raises("enough")

    def close(self) -> None:
        self.closed.append(self.context.name)


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Solo:
    path = tmp_path / "count.yaml"
    path.write_text(GRAPH)
    made = Solo(compile_graph(path, plugin_files=[STAGES]), tmp_path)
    for module in (tapping, requested):
        monkeypatch.setattr(module, "load_stage", lambda name: Seen)
    for name, value in (("seen", []), ("closed", []), ("raises", None)):
        monkeypatch.setattr(Seen, name, value)
    return made


def test_a_tap_sees_every_message_and_stands_in_no_ledger(run: Solo) -> None:
    run.tap([Tapping("count.out", "seen", {}), Tapping("elsewhere.out", "seen", {})])
    report = run.run()
    assert Seen.seen == list(range(30))
    assert report.ok
    assert [edge.name for edge, _ in report.edges] == ["count.out -> write.number"]


def test_the_same_tap_is_made_once(run: Solo) -> None:
    for _ in range(3):
        run.tap([Tapping("count.out", "seen", {})])
    run.run()
    assert len(Seen.seen) == 30


def test_taps_that_come_at_once_are_all_made(run: Solo, monkeypatch: pytest.MonkeyPatch) -> None:
    """While one is made, another thread makes one, too."""
    both: list[threading.Thread] = []

    class Slow(Tap):
        def __init__(self, *args: Any) -> None:
            super().__init__(*args)
            if not both:
                both.append(threading.Thread(target=run.tap, args=([Tapping("count.out", "other", {})],)))
                both[0].start()
                both[0].join(20)

    monkeypatch.setattr(tapping, "Tap", Slow)
    run.tap([Tapping("count.out", "seen", {})])
    run.run()
    assert sorted(Seen.seen) == sorted([*range(30), *range(30)])
    assert Seen.closed == ["count", "count"]


@pytest.mark.parametrize(("error", "warnings"), [(ZeroDivisionError, 1), (EOFError, 0)])
def test_a_tap_that_fails_is_taken_away_and_the_graph_goes_on(
    run: Solo, monkeypatch: pytest.MonkeyPatch, error: type[Exception], warnings: int
) -> None:
    monkeypatch.setattr(Seen, "raises", error)
    run.tap([Tapping("count.out", "seen", {})])
    report = run.run()
    assert report.ok
    assert report.frames == 30
    assert len(Seen.seen) == 5
    assert Seen.closed == ["count"]
    assert len(report.warnings) == warnings
