"""How deep edges are in live runs, and that no depth stops a replay."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from tests.core.worker.rates import STAGES, live, planned, run

from followspot.control.progress import Progress
from followspot.graph.compile import compile_graph
from followspot.graph.plan import Plan, PlannedEdge, PlannedStage, PlannedWorker
from followspot.plugins.registry import use_plugin_files
from followspot.room import Room


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
