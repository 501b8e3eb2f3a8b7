"""Stages of live runs that go to another worker or host: their state goes with them, all is accounted for."""

from __future__ import annotations

import signal
from pathlib import Path

import pytest
from hosts import near_agent
from running import balanced, finish, start, wait_until, write_graph

from followspot.deploy.change import move
from followspot.errors import FollowspotError

STAGES = """
a:    {uses: ticks.live, with: {count: 1000000, period: 0.005}}
b:    {uses: ticks.tally, in: {number: a}}
save: {uses: ticks.write, in: {number: b}}
"""
NEAR = """
placement: near
workers:
  one: {stages: [a, b]}
  two: {stages: [save]}
"""
FAR = """
placement: far
workers:
  left:  {host: pc-left, stages: [a]}
  right: {host: pc-right, stages: [b]}
  main:  {stages: [save]}
"""
PORTS = {"pc-left": 17471, "pc-right": 17472}
PATIENCE = 90.0


def values(out: Path) -> list[int]:
    """What was written since its writer last began."""
    path = out / "ticks.csv"
    lines = path.read_text().splitlines() if path.exists() else []
    return [int(fields[2]) for line in lines if len(fields := line.split(",")) == 4]


def test_a_stage_goes_to_another_worker_with_its_state_and_back(tmp_path: Path) -> None:
    (tmp_path / "near.yaml").write_text(NEAR)
    out = tmp_path / "out"
    process = start(write_graph(tmp_path, STAGES), out, "--placement", str(tmp_path / "near.yaml"))
    name = str(process.pid)
    try:
        assert wait_until(lambda: len(values(out)) > 100, PATIENCE)
        with pytest.raises(FollowspotError, match='no worker or host "three"'):
            move(name, ["b"], "three")
        report = move(name, ["b"], "two")
        assert (report.stages, report.worker, report.anew) == (("b",), "two", ("one", "two"))
        assert wait_until(lambda: len(values(out)) > 10, PATIENCE)
        assert values(out)[0] > 100, "it counts on"
        process.send_signal(signal.SIGINT)
        finished = finish(process, out)
    finally:
        process.kill()
    assert finished.code == 0, finished.errors
    assert balanced(finished.summary)
    kinds = {edge["to"]: edge["kind"] for edge in finished.summary["edges"]}
    assert kinds == {"b.number": "ring", "save.number": "reference"}


def test_a_stage_goes_to_another_host_with_its_state(tmp_path: Path) -> None:
    (tmp_path / "far.yaml").write_text(FAR)
    connect = [word for port in PORTS.values() for word in ("--connect", f"tcp/127.0.0.1:{port}")]
    agents = [near_agent(name, tmp_path, port) for name, port in PORTS.items()]
    out = tmp_path / "out"
    try:
        placement = ("--placement", str(tmp_path / "far.yaml"))
        process = start(write_graph(tmp_path, STAGES), out, *placement, *connect)
        assert wait_until(lambda: len(values(out)) > 50, PATIENCE)
        report = move(str(process.pid), ["b"], "pc-left")
        assert (report.worker, report.host) == ("left", "pc-left")
        assert wait_until(lambda: values(out)[:1] > [50] and len(values(out)) > 10, PATIENCE), "it counts on"
        process.send_signal(signal.SIGINT)
        finished = finish(process, out)
    finally:
        for agent in agents:
            agent.process.kill()
            agent.process.communicate()
    assert finished.code == 0, finished.errors
    assert balanced(finished.summary)
    kinds = {edge["to"]: edge["kind"] for edge in finished.summary["edges"]}
    assert kinds == {"b.number": "reference", "save.number": "zenoh"}
