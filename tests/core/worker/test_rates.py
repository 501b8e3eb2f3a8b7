"""Streams of different rates meet: windows, the latest and the nearest messages, and their tolerances."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from tests.core.worker.rates import STAGES, counts, planned, run, written

from followspot.graph.compile import compile_graph


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
