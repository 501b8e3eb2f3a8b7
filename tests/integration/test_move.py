"""Moves of stages of live runs between workers and hosts, also with different clocks."""

from __future__ import annotations

import signal
import time
from pathlib import Path

import pytest
from tests.integration.hosts import free_port, near_agent
from tests.integration.running import Finished, balanced, finish, start, wait_until, write_graph

from followspot.errors import FollowspotError
from followspot.operator.connect import run_here

STAGES = """
a:    {uses: ticks.live, with: {count: 1000000, period: 0.02}}
b:    {uses: ticks.tally, in: {number: a}}
save: {uses: ticks.write, in: {number: b}}
"""
NEAR = """
placement: near
workers:
  one: {stages: [a, b]}
  two: {stages: [save]}
"""
FAR_STAGES = """
b:    {uses: ticks.tally, in: {number: a}}
a:    {uses: ticks.live, with: {count: 1000000, period: 0.02}}
save: {uses: ticks.write, in: {number: b}}
"""
FAR = """
placement: far
workers:
  left:  {host: pc-left, stages: [b]}
  right: {host: pc-right, stages: [a]}
  main:  {stages: [save]}
"""
HOUR_MS = 3_600_000
PATIENCE = 90.0


def values(out: Path) -> list[int]:
    """The values that the writer has written since its last start."""
    path = out / "ticks.csv"
    lines = path.read_text().splitlines() if path.exists() else []
    return [int(fields[2]) for line in lines if len(fields := line.split(",")) == 4]


def refusal(run: str) -> str:
    """The error of a move to an unknown place; it lists the known ones, which include agents once found."""
    with pytest.raises(FollowspotError) as refused:
        run_here(run).move(["b"], "three")
    return str(refused.value)


def test_a_stage_moves_with_its_state_to_another_worker_and_to_a_new_host(tmp_path: Path) -> None:
    (tmp_path / "near.yaml").write_text(NEAR)
    out = tmp_path / "out"
    desk = f"tcp/127.0.0.1:{free_port()}"
    options = ("--placement", str(tmp_path / "near.yaml"), "--listen", desk)
    process = start(write_graph(tmp_path, STAGES), out, *options)
    name = str(process.pid)
    agent = near_agent("pc-right", tmp_path, "--connect", desk)
    try:
        assert wait_until(lambda: len(values(out)) > 100, PATIENCE)
        assert wait_until(lambda: "workers and hosts: one, pc-right, two" in refusal(name), PATIENCE)
        report = run_here(name).move(["b"], "two")
        assert (report.stages, report.worker, report.restarted) == (("b",), "two", ("one", "two"))
        assert wait_until(lambda: len(values(out)) > 10, PATIENCE)
        assert values(out)[0] > 100, "it counts on"
        report = run_here(name).move(["b"], "pc-right")
        assert (report.worker, report.host, report.restarted) == (
            "pc-right",
            "pc-right",
            ("one", "pc-right", "two"),
        )
        assert wait_until(lambda: values(out)[:1] > [110] and len(values(out)) > 10, PATIENCE), "it counts on"
        clocks = run_here(name).status().clocks
        assert {host: clock.reference for host, clock in clocks.items()} == {"": "pc-right"}
        process.send_signal(signal.SIGINT)
        finished = finish(process, out)
    finally:
        process.kill()
        agent.process.kill()
        agent.process.communicate()
    assert finished.code == 0, finished.errors
    assert balanced(finished.summary)
    kinds = {edge["to"]: edge["kind"] for edge in finished.summary["edges"]}
    assert kinds == {"b.number": "zenoh", "save.number": "zenoh"}


def test_the_progress_of_a_run_goes_on_when_its_sink_moves(tmp_path: Path) -> None:
    (tmp_path / "near.yaml").write_text(NEAR)
    desk = f"tcp/127.0.0.1:{free_port()}"
    options = ("--placement", str(tmp_path / "near.yaml"), "--listen", desk)
    process = start(write_graph(tmp_path, STAGES), tmp_path / "out", *options)
    name = str(process.pid)
    agent = near_agent("pc-right", tmp_path, "--connect", desk)
    try:
        assert wait_until(lambda: len(values(tmp_path / "out")) > 100, PATIENCE)
        assert wait_until(lambda: "workers and hosts: one, pc-right, two" in refusal(name), PATIENCE)
        fired = run_here(name).status().fired
        assert fired > 50
        run_here(name).move(["save"], "pc-right")
        assert run_here(name).status().fired >= fired
        assert wait_until(lambda: run_here(name).status().fired > fired + 10, PATIENCE), "it counts on"
    finally:
        process.kill()
        agent.process.kill()
        agent.process.communicate()


@pytest.mark.thorough
def test_a_stage_moves_to_a_host_whose_clock_is_an_hour_off(tmp_path: Path) -> None:
    (tmp_path / "far.yaml").write_text(FAR)
    agents = [
        near_agent("pc-left", tmp_path),
        near_agent("pc-right", tmp_path, "--clock-offset", str(HOUR_MS)),
    ]
    connect = [word for agent in agents for word in ("--connect", agent.endpoint)]
    out = tmp_path / "out"
    placement = ("--placement", str(tmp_path / "far.yaml"))
    process = start(write_graph(tmp_path, FAR_STAGES), out, *placement, *connect)
    try:
        assert wait_until(lambda: len(values(out)) > 50, PATIENCE)
        report = run_here(str(process.pid)).move(["b"], "pc-right")
        assert (report.worker, report.host) == ("right", "pc-right")
        assert wait_until(lambda: values(out)[:1] > [50] and len(values(out)) > 10, PATIENCE), "it counts on"
        process.send_signal(signal.SIGINT)
        finished = finish(process, out)
    finally:
        process.kill()
        for agent in agents:
            agent.process.kill()
            agent.process.communicate()
    assert finished.code == 0, finished.errors
    assert balanced(finished.summary)
    kinds = {edge["to"]: edge["kind"] for edge in finished.summary["edges"]}
    assert kinds == {"b.number": "reference", "save.number": "zenoh"}
    check_clocks(finished)


def check_clocks(finished: Finished) -> None:
    """Check that times are those of the left host, and that the summary gives and warns of the offset."""
    times = [int(line.split(",")[1]) for line in finished.lines()]
    assert times == sorted(times)
    assert abs(times[0] - time.time_ns()) < 600e9, "not an hour off"
    clocks = {clock["host"]: clock for clock in finished.summary["clocks"]}
    assert set(clocks) == {"pc-right", ""}
    assert clocks["pc-right"]["offset_ms"] == pytest.approx(-HOUR_MS, abs=1000)
    assert clocks[""]["offset_ms"] == pytest.approx(0, abs=1000)
    warnings = [line for line in finished.summary["warnings"] if "clock" in line]
    assert any(line.startswith("pc-right: its clock is 3") and "ahead of" in line for line in warnings)
