"""Streams of different rates: windows, nearest messages, and edges that never stop a replay."""

from __future__ import annotations

import threading
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from tests.core.worker.solo import Solo

from followspot.control.progress import Progress
from followspot.errors import FollowspotError
from followspot.graph.compile import compile_graph
from followspot.graph.plan import Plan, PlannedEdge, PlannedStage, PlannedWorker
from followspot.operator.change.hot_swap import change_stages
from followspot.operator.coordinator import Coordinator
from followspot.operator.launch import local_run
from followspot.operator.reporting.report import RunReport
from followspot.operator.run_requests import ChangeStages
from followspot.plugins.registry import use_plugin_files
from followspot.room import Room
from followspot.worker.runners import deferred_runner
from followspot.worker.wiring import RunOptions

STAGES = Path(__file__).parents[2] / "stages" / "rates.py"
GRAPH = """
graph: rates
stages:
  camera: {{uses: rates.sensor, with: {{hz: 60, count: {frames}, shift: {shift}}}}}
  sensor: {{uses: rates.sensor, with: {{hz: {hz}, count: {readings}}}}}
  meet:   {{uses: rates.{meet}, in: {{frame: camera, {port}: {feed}}}}}
  save:   {{uses: rates.write, in: {{readings: meet}}}}
"""


def planned(folder: Path, meet: str, more: str = "", **changes: object) -> Plan:
    """The graph with a stage that meets both rates. more: lines of further stages."""
    values = {
        "frames": 60,
        "shift": 0.0041,
        "hz": 1000,
        "readings": 1000,
        "feed": "sensor",
        "port": "reading",
    }
    (folder / "rates.yaml").write_text((GRAPH + more).format(meet=meet, **{**values, **changes}))
    return compile_graph(folder / "rates.yaml", plugin_files=[STAGES])


def run(plan: Plan, folder: Path) -> RunReport:
    report = Solo(plan, folder).run()
    assert report.ok, report.errors
    assert all(edge.balanced for _, edge in report.edges)
    return report


def written(folder: Path) -> list[tuple[int, list[tuple[int, int]]]]:
    """Of each line its time, ns, and the values with their times, ns."""
    found = []
    for line in (folder / "readings.csv").read_text().splitlines():
        time, _, rest = line.partition(":")
        pairs = [(int(value), int(at)) for value, _, at in (word.partition("@") for word in rest.split())]
        found.append((int(time), pairs))
    return found


def counts(report: RunReport, port: str) -> tuple[int, int, int]:
    """Delivered, dropped and unmatched messages of the edge to a port of `meet`."""
    count = next(count for edge, count in report.edges if edge.to_port == port)
    return count.delivered, count.dropped, count.unmatched


@pytest.mark.parametrize("depth", [1, 1024])
@pytest.mark.parametrize("edges", ["reference", "ring"])
def test_every_reading_up_to_the_last_frame_is_in_exactly_one_window(
    tmp_path: Path, depth: int, edges: str
) -> None:
    planned(tmp_path, "gather", port="readings", feed=f"{{from: sensor, depth: {depth}}}")
    plan = compile_graph(tmp_path / "rates.yaml", plugin_files=[STAGES], edges=edges)  # type: ignore[arg-type]
    report = run(plan, tmp_path)
    before = -1
    seen = []
    for time, pairs in written(tmp_path):
        assert all(before < at <= time for _, at in pairs)
        before = time
        seen += [value for value, _ in pairs]
    assert seen == list(range(988)), "frame 59 was captured at 987.4 ms"
    assert counts(report, "readings") == (988, 0, 12)


@pytest.mark.parametrize(
    ("meet", "port", "why"),
    [
        (
            "gather",
            "readings",
            "962 of 1000 messages came after the last firing of their reader and were not used",
        ),
        ("meet", "reading", "997 of 1000 messages found no partner and were not used: raise tolerance, or "),
    ],
)
def test_what_no_firing_used_is_told_with_the_reason(tmp_path: Path, meet: str, port: str, why: str) -> None:
    report = run(planned(tmp_path, meet, port=port, frames=3), tmp_path)
    assert any(line.startswith(f"sensor.out -> meet.{port}: {why}") for line in report.warnings)


def test_a_window_holds_all_its_edges_in_the_order_of_time(tmp_path: Path) -> None:
    twin = "  twin:   {{uses: rates.sensor, with: {{hz: {hz}, count: {readings}}}}}\n"
    plan = planned(tmp_path, "gather", twin, port="readings", feed="[sensor, twin]", frames=3)
    run(plan, tmp_path)
    values = [value for _, pairs in written(tmp_path) for value, _ in pairs]
    assert values == [n for n in range(38) for _ in range(2)]


def test_a_latest_beside_a_slow_input_no_longer_stops_a_replay(tmp_path: Path) -> None:
    (tmp_path / "held.yaml").write_text("""
graph: held
stages:
  camera: {uses: rates.sensor, with: {hz: 60, count: 60}}
  sensor: {uses: rates.sensor}
  mix:    {uses: rates.mix, in: {frame: camera, latest: sensor}}
  save:   {uses: rates.note, in: {reading: mix}}
""")
    report = run(compile_graph(tmp_path / "held.yaml", plugin_files=[STAGES]), tmp_path)
    assert counts(report, "latest") == (60, 940, 0)


def test_a_join_does_not_wait_for_the_nearest_of_what_waits_for_its_own_result(tmp_path: Path) -> None:
    (tmp_path / "loop.yaml").write_text("""
graph: loop
stages:
  camera: {uses: rates.sensor, with: {hz: 250, count: 50}}
  sensor: {uses: rates.sensor, with: {hz: 1000, count: 200}}
  guided: {uses: rates.mix, in: {frame: sensor, latest: {from: meet, delay: 1}}}
  meet:   {uses: rates.mix, in: {frame: camera, other: guided}, tolerance: 0.002}
  save:   {uses: rates.note, in: {reading: meet}}
""")
    run(compile_graph(tmp_path / "loop.yaml", plugin_files=[STAGES]), tmp_path)
    assert len((tmp_path / "readings.csv").read_text().splitlines()) == 50


def nearest(time: int, readings: list[tuple[int, int]], tolerance: int) -> list[tuple[int, int]]:
    value, at = min(readings, key=lambda reading: (abs(reading[1] - time), reading[1]))
    return [(value, at)] if abs(at - time) <= tolerance else []


@settings(deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=30)
@example(hz=1000, shift=0.0007, tolerance=0.004)
@example(hz=7, shift=-0.05, tolerance=0.02)
@given(
    hz=st.sampled_from([7, 60, 61, 240, 1000]),
    shift=st.integers(-100_000, 100_000).map(lambda us: us / 1e6),
    tolerance=st.sampled_from([0.0, 0.0004, 0.004, 0.05, 1.0]),
)
def test_a_nearest_is_the_nearest_of_all_readings(
    tmp_path: Path, hz: float, shift: float, tolerance: float
) -> None:
    feed = f"{{from: sensor, tolerance: {tolerance}, depth: 1}}"
    run(planned(tmp_path, "near", hz=hz, shift=shift, feed=feed, frames=30, readings=300), tmp_path)
    readings = [(n, round(n / hz * 1e9)) for n in range(300)]
    found = written(tmp_path)
    assert len(found) == 30
    assert all(pairs == nearest(time, readings, round(tolerance * 1e9)) for time, pairs in found)


@settings(deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=15)
@example(hz=1000, shift=0.0037)
@example(hz=256.4, shift=0.00901)
@given(hz=st.integers(130, 2000), shift=st.integers(0, 50_000).map(lambda us: us / 1e6))
def test_a_join_takes_the_reading_nearest_to_the_frame(tmp_path: Path, hz: float, shift: float) -> None:
    """From the second frame on: the first may come before any two readings say that they are frequent."""
    run(planned(tmp_path, "meet", hz=hz, shift=shift, frames=30, readings=1200), tmp_path)
    readings = [(n, round(n / hz * 1e9)) for n in range(1200)]
    found = written(tmp_path)
    assert len(found) == 30
    for _, (frame, reading) in found[1:]:
        assert abs(reading[1] - frame[1]) == abs(nearest(frame[1], readings, 1 << 60)[0][1] - frame[1])


def test_several_messages_may_lie_within_the_tolerance_of_the_join_that_gives_them(tmp_path: Path) -> None:
    (tmp_path / "spread.yaml").write_text("""
graph: spread
stages:
  camera: {uses: rates.sensor, with: {hz: 60, count: 20}}
  sensor: {uses: rates.sensor, with: {hz: 60, count: 20, shift: 0.001}}
  spread: {uses: rates.spread, in: {frame: camera, reading: sensor}}
  save:   {uses: rates.note, in: {reading: spread}}
""")
    run(compile_graph(tmp_path / "spread.yaml", plugin_files=[STAGES]), tmp_path)
    lines = (tmp_path / "readings.csv").read_text().splitlines()
    assert [int(line.split()[1]) for line in lines] == [0, 1, 2] * 20


def test_a_tolerance_of_an_edge_is_wider_than_that_of_the_stage(tmp_path: Path) -> None:
    run(planned(tmp_path, "meet", hz=60, shift=0.006, frames=5, readings=5), tmp_path)
    assert written(tmp_path) == []
    wide = "{from: sensor, tolerance: 0.007}"
    run(planned(tmp_path, "meet", hz=60, shift=0.006, frames=5, readings=5, feed=wide), tmp_path)
    assert [[value for value, _ in pairs] for _, pairs in written(tmp_path)] == [[n, n] for n in range(5)]


@pytest.mark.parametrize(
    ("hz", "depth", "found"), [(60, "", 2), (1000, "", 500), (10**6, "", 10_000), (1000, ", depth: 7", 7)]
)
def test_a_live_source_is_as_deep_as_its_rate_asks_for(
    tmp_path: Path, hz: float, depth: str, found: int
) -> None:
    (tmp_path / "live.yaml").write_text(
        f"graph: live\nstages:\n  sensor: {{uses: rates.device, with: {{hz: {hz}}}{depth}}}\n"
    )
    (stage,) = compile_graph(tmp_path / "live.yaml", plugin_files=[STAGES]).stages
    assert stage.depth == found


@pytest.mark.parametrize(
    ("meet", "port", "feed", "depth"),
    [
        ("gather", "readings", "sensor", 1024),
        ("near", "reading", "sensor", 256),
        ("meet", "reading", "sensor", 8),
        ("gather", "readings", "{from: sensor, depth: 3}", 3),
        ("near", "reading", "{from: sensor, tolerance: 1}", 256),
    ],
)
def test_an_edge_is_as_deep_as_its_input_needs_in_a_live_run(
    tmp_path: Path, meet: str, port: str, feed: str, depth: int
) -> None:
    plan = planned(tmp_path, meet, port=port, feed=feed)
    assert [edge.depth for edge in plan.edges if (edge.to_stage, edge.to_port) == ("meet", port)] == [depth]


def test_the_rate_of_a_sensor_stands_in_the_room(tmp_path: Path) -> None:
    (tmp_path / "room.yaml").write_text(
        "room: r\nsensors:\n  imu: {kind: imu, rate: 400, source: {uses: rates.device, with: {hz: 60}}}\n"
    )
    (tmp_path / "live.yaml").write_text(
        "graph: live\nroom: room.yaml\nstages:\n  sensor: {uses: room.source, each: sensors}\n"
    )
    (stage,) = compile_graph(tmp_path / "live.yaml", plugin_files=[STAGES]).stages
    assert stage.depth == 200


def live(folder: Path, stages: str) -> Coordinator:
    (folder / "live.yaml").write_text(f"graph: live\nstages:\n{stages}")
    return local_run(compile_graph(folder / "live.yaml", plugin_files=[STAGES]), RunOptions(folder))


@pytest.mark.parametrize(("meet", "port"), [("gather", "readings"), ("near", "reading")])
def test_a_camera_that_falls_silent_does_not_hold_up_a_sensor(tmp_path: Path, meet: str, port: str) -> None:
    run = live(
        tmp_path,
        "  camera: {uses: rates.device, with: {hz: 0.001}}\n"
        "  sensor: {uses: rates.device, with: {count: 1000000}}\n"
        f"  meet: {{uses: rates.{meet}, in: {{frame: camera, {port}: {{from: sensor, depth: 8}}}}}}\n"
        "  save: {uses: rates.note, in: {reading: sensor}}\n",
    )
    looks = iter(range(500))

    def stop(progress: Progress, expected: int | None) -> None:
        if progress.fired > 50 or next(looks, None) is None:  # the looks only bound a failure
            run.stop()

    report = run.execute(stop)
    assert report.ok, report.errors
    count = next(count for edge, count in report.edges if edge.to_port == port)
    assert count.sent > 50, "the edge is full with eight"
    assert count.sent == count.delivered + count.dropped + count.unmatched


def test_a_stage_that_answers_later_is_swapped_and_loses_nothing(tmp_path: Path) -> None:
    run = live(
        tmp_path,
        "  sensor: {uses: rates.device, with: {hz: 300, count: 1000000}, depth: 10000}\n"
        "  later: {uses: rates.later, in: {reading: sensor}, with: {longest_ms: 20}, concurrency: 4}\n"
        "  save: {uses: rates.note, in: {reading: later}}\n",
    )
    begun = threading.Event()
    problems: list[BaseException] = []

    def meddle() -> None:
        try:
            assert begun.wait(60)
            change_stages(run, ChangeStages(words=("later.longest_ms=5",)))
            with pytest.raises(FollowspotError, match="in another way"):
                change_stages(run, ChangeStages(words=("later=rates.burst",)))
        except BaseException as error:
            problems.append(error)
        finally:
            run.stop()

    meddler = threading.Thread(target=meddle)
    meddler.start()
    report = run.execute(lambda progress, _: begun.set() if progress.fired > 10 else None)
    meddler.join()
    assert not problems, problems
    assert report.ok, report.errors
    assert run.plan.notes == ("while it ran: later: longest_ms = 5",)
    lines = (tmp_path / "readings.csv").read_text().splitlines()
    values = [int(line.split()[1]) for line in lines]
    assert values == [n + 1 for n in range(values[-1]) if n % 5], (
        "each in order, and every fifth says nothing"
    )


def test_a_stopped_run_ends_though_answers_never_come(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(deferred_runner, "_ANSWER_TIMEOUT", 0.05)
    run = live(
        tmp_path,
        "  sensor: {uses: rates.device, with: {count: 1000000}}\n"
        "  silent: {uses: rates.silent, in: {reading: sensor}, concurrency: 2}\n"
        "  save: {uses: rates.note, in: {reading: silent}}\n"
        "  seen: {uses: rates.note, in: {reading: sensor}, with: {path: seen.csv}}\n",
    )
    report = run.execute(lambda progress, _: run.stop() if progress.time > 0 else None)
    assert report.ok, report.errors
    assert sum("did not come within" in text for text in report.warnings) >= 2


INPUTS = ("frame", "other", "window", "near", "latest")
PAUSES = st.lists(st.integers(1, 60), min_size=2, max_size=12).flatmap(
    lambda pauses: st.integers(1, 8).map(lambda times: pauses * times)
)


@st.composite
def graphs(draw: st.DrawFn) -> Plan:
    """A graph of uneven sources and of stages with inputs of all kinds, each from anything before it."""
    sources = draw(st.integers(2, 3))
    names = [f"n{n}" for n in range(sources + draw(st.integers(1, 4)))]
    stages, edges, back = [], [], []
    for n, name in enumerate(names):
        tolerance = draw(st.sampled_from([0.0, 0.002, 0.01, 0.05]))
        if n < sources:
            stages.append(_stage(name, "uneven", {"pauses": draw(PAUSES)}))
            continue
        if draw(st.integers(0, 3)) == 0:
            uses = draw(st.sampled_from(["burst", "later"]))
            before = names[: sources if uses == "burst" else n]
            stages.append(_stage(name, uses, {}))
            edges.append(_edge(draw(st.sampled_from(before)), name, "reading"))
            continue
        stages.append(_stage(name, "mix", {}, tolerance))
        if draw(st.booleans()):
            back.append(name)
        used = {"frame", *draw(st.lists(st.sampled_from(INPUTS), max_size=4))}
        edges += [_edge(draw(st.sampled_from(names[:n])), name, port) for port in INPUTS if port in used]
    for name in back:
        if not any((edge.to_stage, edge.to_port) == (name, "latest") for edge in edges):
            sender = draw(st.sampled_from(names[names.index(name) :]))
            edges.append(replace(_edge(sender, name, "latest"), delay=draw(st.integers(1, 2))))
    for name in names[sources:]:
        stages.append(_stage(f"save_{name}", "note", {"path": f"{name}.csv"}))
        edges.append(_edge(name, f"save_{name}", "reading"))
    return Plan("rates", Room(), tuple(stages), tuple(edges), (PlannedWorker("main"),))


def _stage(name: str, uses: str, params: dict[str, object], tolerance: float = 0.0) -> PlannedStage:
    return PlannedStage(
        name, name, f"rates.{uses}", params, None, "main", live=False, tolerance=tolerance, concurrency=3
    )


def _edge(start: str, end: str, port: str, depth: int = 1) -> PlannedEdge:
    return PlannedEdge(start, "out", end, port, "reference", depth=depth)


@settings(deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(plan=graphs())
def test_no_depth_stops_a_replay_or_changes_what_it_gives(tmp_path: Path, plan: Plan) -> None:
    use_plugin_files([str(STAGES)])
    found = []
    for depth in (1, 1000):
        edges = tuple(replace(edge, depth=depth) for edge in plan.edges)
        report = run(replace(plan, edges=edges), tmp_path)
        ledger = [str(count) for _, count in report.edges]
        found.append((ledger, [path.read_text() for path in sorted(tmp_path.glob("n*.csv"))]))
        for path in tmp_path.glob("n*.csv"):
            path.unlink()
    assert found[0] == found[1]
