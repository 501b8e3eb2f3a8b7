"""Stages that give messages for earlier firings, and what is left at the end."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import pytest
from tests.core.worker.bench import Bench, Note
from tests.core.worker.solo import Solo

from followspot import Lagged, Stage, at
from followspot.errors import InputError
from followspot.graph.compile import compile_graph
from followspot.messages import Header
from followspot.ports.signature import ports
from followspot.transport.token import END
from followspot.worker.runners.error_policy import StageError
from followspot.worker.runners.lagged_runner import LaggedRunner

STAGES = Path(__file__).parents[2] / "stages" / "rates.py"


class Delayed(Stage):
    """Gives what it is told to, and two notes at the end."""

    def setup(self) -> None:
        self.given: dict[int, Iterable[Any]] = {}
        self.rest: Iterable[Any] = (at(20, Note(2)), at(30, Note(3)))

    def process(self, note: Note) -> Lagged[Note]:
        return self.given.get(note.header.time, ())

    def remaining(self) -> Iterable[Note]:
        return self.rest


class Lagging(Bench):
    """The stage between two edges; gives: what it gives at times."""

    def __init__(self, gives: dict[int, Iterable[Any]], **options: Any) -> None:
        super().__init__(LaggedRunner, Delayed(), **options)
        assert isinstance(self.stage, Delayed)
        self.stage.given = gives


def test_a_message_has_the_header_of_the_firing_that_it_belongs_to() -> None:
    bench = Lagging({30: [at(10, Note(1))]})
    bench.put(10, 20, 30)
    bench.end()
    assert bench.got() == [(10, 1), (20, 2), (30, 3)]
    assert [m.header for m in bench.out.messages] == [Header("a", t, t, 5) for t in (10, 20, 30)]


def test_only_a_message_or_the_end_moves_the_watermark() -> None:
    bench = Lagging({30: [at(10, Note(1))]})
    bench.put(10, 20)
    bench.into.advance(25)
    bench.runner.step()
    assert bench.out.watermark < 0
    bench.put(30)
    assert bench.out.watermark == 11
    bench.end()
    assert bench.out.watermark == END
    assert bench.runner.done


def test_what_remains_waits_for_room_and_comes_before_the_end() -> None:
    bench = Lagging({}, depth=1)
    bench.put(10, 20, 30)
    bench.end()
    assert bench.got() == [(20, 2)]
    assert (bench.runner.done, bench.out.watermark) == (False, 21)
    bench.out.take()
    bench.runner.step()
    assert bench.got() == [(30, 3)]
    bench.runner.step()
    assert (bench.runner.done, bench.out.watermark) == (True, END)


@pytest.mark.parametrize(
    "wrong",
    [
        [at(21, Note(0))],  # beyond the firing
        [at(20, Note(0)), at(20, Note(1))],
        [at(20, Note(0)), at(10, Note(1))],
        [Note(0)],
    ],
)
def test_times_that_do_not_rise_up_to_the_firing_are_refused(wrong: list[Any]) -> None:
    bench = Lagging({20: wrong})
    with pytest.raises(StageError, match="times rise"):
        bench.put(10, 20)


def test_what_remains_is_checked_as_well() -> None:
    bench = Lagging({})
    bench.stage.rest = [at(40, Note(4))]  # type: ignore[attr-defined]
    bench.put(10, 20, 30)
    with pytest.raises(StageError, match="times rise up to that of the firing"):
        bench.end()


def test_a_stage_that_never_fired_owes_nothing() -> None:
    bench = Lagging({})
    bench.end()
    assert bench.got() == []
    assert bench.runner.done


def test_a_new_worker_that_lacks_the_header_gives_the_number_of_the_message() -> None:
    bench = Lagging({30: [at(10, Note(1), seq=7)]})
    bench.put(30)
    assert [m.header for m in bench.out.messages] == [Header("a", 7, 10, 5)]


def test_ports_know_a_stage_that_lags() -> None:
    assert ports(Delayed).gives == "lagged"
    assert [(port.name, port.type) for port in ports(Delayed).outputs] == [("out", Note)]


@pytest.mark.parametrize("lag", [1, 40, 0])
@pytest.mark.parametrize("edges", ["reference", "ring"])
def test_a_join_with_the_stream_that_it_lags_behind_is_complete_at_any_depth(
    tmp_path: Path, lag: int, edges: Any
) -> None:
    (tmp_path / "late.yaml").write_text(f"""
graph: late
stages:
  camera: {{uses: rates.sensor, with: {{hz: 60, count: 100}}}}
  behind: {{uses: rates.behind, in: {{reading: {{from: camera, depth: 1}}}}, with: {{lag: {lag}}}}}
  meet:   {{uses: rates.meet, in: {{frame: {{from: camera, depth: 1}}, reading: {{from: behind, depth: 1}}}}}}
  save:   {{uses: rates.write, in: {{readings: meet}}}}
""")
    plan = compile_graph(tmp_path / "late.yaml", plugin_files=[STAGES], edges=edges)
    report = Solo(plan, tmp_path).run()
    assert report.ok, report.errors
    assert all(edge.balanced for _, edge in report.edges)
    lines = (tmp_path / "readings.csv").read_text().splitlines()
    times = [round(n / 60 * 1e9) for n in range(100)]
    assert lines == [f"{time}: {n}@{time} {10 * n}@{time}" for n, time in enumerate(times)]


@pytest.mark.parametrize("feed", ["{from: behind, delay: 1}", "behind"])
def test_a_stage_that_waits_for_its_own_output_is_refused(tmp_path: Path, feed: str) -> None:
    (tmp_path / "loop.yaml").write_text(f"""graph: loop
stages:
  camera: {{uses: rates.sensor}}
  mix:    {{uses: rates.mix, in: {{frame: camera, latest: {feed}}}}}
  behind: {{uses: rates.behind, in: {{reading: mix}}}}
""")
    with pytest.raises(InputError) as caught:
        compile_graph(tmp_path / "loop.yaml", plugin_files=[STAGES])
    (mistake,) = [m for m in caught.value.mistakes if "lags" in m.text]
    assert mistake.text == 'stage "behind" lags and would wait for its own output, which "mix" reads'
    assert mistake.remedy == "feed back what does not lag"
    assert mistake.place is not None
    assert mistake.place.line == 4
