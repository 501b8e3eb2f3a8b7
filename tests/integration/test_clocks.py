"""Hosts whose clocks differ: their cameras are seen at one time all the same, and the user is told."""

from __future__ import annotations

import json
import signal
import time
from pathlib import Path

import pytest
from hosts import near_agent
from running import balanced, finish, start, wait_until, write_graph

HOUR_MS = 3_600_000
PORTS = (17461, 17462)
LIVE = """
a:    {uses: ticks.live, with: {count: 1000000, period: 0.005}}
b:    {uses: ticks.live, with: {count: 1000000, period: 0.005}}
left:  {uses: ticks.write, in: {number: a}, with: {path: left.csv}}
right: {uses: ticks.write, in: {number: b}, with: {path: right.csv}}
"""
PLACEMENT = """
placement: hosts
workers:
  near: {host: pc-left, stages: [a]}
  far:  {host: pc-right, stages: [b]}
"""


def test_a_host_whose_clock_is_an_hour_off_sees_with_the_others(tmp_path: Path) -> None:
    graph = write_graph(tmp_path, LIVE)
    (tmp_path / "hosts.yaml").write_text(PLACEMENT)
    agents = [
        near_agent("pc-left", tmp_path, PORTS[0]),
        near_agent("pc-right", tmp_path, PORTS[1], "--clock-offset", str(HOUR_MS)),
    ]
    connect = [word for port in PORTS for word in ("--connect", f"tcp/127.0.0.1:{port}")]
    out = tmp_path / "out"
    try:
        process = start(graph, out, "--placement", str(tmp_path / "hosts.yaml"), *connect)
        files = [out / "left.csv", out / "right.csv"]
        assert wait_until(lambda: all(file.exists() and file.stat().st_size > 500 for file in files), 90.0)
        process.send_signal(signal.SIGINT)
        finished = finish(process, out)
    finally:
        for agent in agents:
            agent.process.kill()
            agent.process.communicate()
    assert finished.code == 0, finished.errors + json.dumps(finished.summary)
    assert balanced(finished.summary)
    for file in files:
        times = [int(line.split(",")[1]) for line in file.read_text().splitlines()]
        assert times == sorted(times)
        assert abs(times[0] - time.time_ns()) < 600e9, "not an hour off"
    clocks = {clock["host"]: clock for clock in finished.summary["clocks"]}
    assert set(clocks) == {"pc-right", ""}
    assert clocks["pc-right"]["offset_ms"] == pytest.approx(-HOUR_MS, abs=50)
    assert clocks[""]["offset_ms"] == pytest.approx(0, abs=50)
    warnings = [line for line in finished.summary["warnings"] if "clock" in line]
    assert any(line.startswith("pc-right: its clock is 36000") and "ahead of" in line for line in warnings)
