"""Stages carry on where they were after the agent of their host died or was ended with its workers."""

from __future__ import annotations

import json
import signal
from itertools import pairwise
from pathlib import Path
from typing import Any

from tests.commands import command
from tests.integration.hosts import near_agent
from tests.integration.running import finish, start, wait_until, write_graph
from tests.plugins.cameras.recordings import record

GRAPH = """
camera: {uses: cameras.playback, each: cameras, with: {path: a.mkv, fps: 20, loop: true}}
times:  {uses: sinks.jsonl, in: {messages: camera}}
numbers: {uses: ticks.live, with: {count: 1000000, period: 0.02}}
tally:  {uses: ticks.tally, in: {number: numbers}}
save:   {uses: ticks.write, in: {number: tally}}
"""
PLACEMENT = """
placement: hosts
workers:
  left: {host: pc-left, stages: [camera, numbers, tally]}
"""


def test_after_the_death_of_an_agent_a_recording_and_a_count_go_on(tmp_path: Path) -> None:
    home, out = tmp_path / "pc-left", tmp_path / "out"
    home.mkdir()
    video = str(record(tmp_path / "a.mkv", frames=10))
    command("room", "new", "--video", video, "-o", tmp_path / "room.yaml", check=True)
    (tmp_path / "hosts.yaml").write_text(PLACEMENT)
    graph = write_graph(tmp_path, GRAPH)
    agent = near_agent("pc-left", home, "--media", tmp_path)
    at = agent.endpoint
    options = ("--placement", str(tmp_path / "hosts.yaml"), "--connect", at, "--media", str(tmp_path))
    process = start(graph, out, "--room", str(tmp_path / "room.yaml"), *options)

    def counted() -> list[int]:
        return [int(line.split(",")[2]) for line in (out / "ticks.csv").read_text().splitlines()[:-1]]

    def played() -> list[int]:
        lines = (out / "messages.jsonl").read_text().splitlines()[:-1]
        return [json.loads(line)["seq"] for line in lines]

    def kept() -> dict[str, Any]:
        """The checkpoints that the agent has saved."""
        files = list(home.glob("runs/*-pc-left/.checkpoints"))
        return json.loads(files[0].read_text()) if files else {}

    try:
        assert wait_until(lambda: {"camera/cam0", "tally"} <= kept().keys() and len(played()) > 10)
        count = kept()["tally"][1]["count"]
        agent.process.kill()
        agent.process.communicate()
        lines, frames = len(counted()), len(played())
        agent = near_agent("pc-left", home, "--media", tmp_path, at=at)
        assert wait_until(lambda: len(played()) > frames + 10 and len(counted()) > lines + 10)
        process.send_signal(signal.SIGINT)
        finished = finish(process, out)
        assert finished.code == 0, finished.errors
        assert all(first < second for first, second in pairwise(played()))
        assert min(counted()[lines:]) > count
    finally:
        process.kill()
        agent.process.kill()
        agent.process.communicate()


SHARED = """
here:  {uses: ticks.live, with: {count: 1000000, period: 0.01}}
there: {uses: ticks.live, with: {count: 1000000, period: 0.01}}
kept:  {uses: sinks.jsonl, in: {message: here}, with: {path: kept.jsonl}}
save:  {uses: ticks.write, in: {number: there}}
"""
LEFT = """
placement: hosts
workers:
  left: {host: pc-left, stages: [there, kept]}
"""


def test_an_agent_that_is_ended_completes_its_files_and_the_next_one_takes_its_part_up(
    tmp_path: Path,
) -> None:
    home, out = tmp_path / "pc-left", tmp_path / "out"
    home.mkdir()
    (tmp_path / "hosts.yaml").write_text(LEFT)
    graph = write_graph(tmp_path, SHARED)
    agent = near_agent("pc-left", home)
    at = agent.endpoint
    process = start(graph, out, "--placement", str(tmp_path / "hosts.yaml"), "--connect", at)

    def saved() -> int:
        return len((out / "ticks.csv").read_text().splitlines()) if (out / "ticks.csv").exists() else 0

    def kept() -> list[int]:
        (file,) = home.glob("runs/*-pc-left/kept.jsonl")
        return [json.loads(line)["seq"] for line in file.read_text().splitlines()]

    try:
        assert wait_until(lambda: saved() > 10)
        agent.process.send_signal(signal.SIGTERM)
        agent.process.communicate(timeout=60)
        assert agent.process.returncode == 0
        lines, written = len(kept()), saved()
        agent = near_agent("pc-left", home, at=at)
        assert wait_until(lambda: saved() > written + 10, 30.0), "its source ended for good"
        process.send_signal(signal.SIGINT)
        finished = finish(process, out)
        assert finished.code == 0, finished.errors
        edge = finished.edge("here", "kept")
        assert lines > 0
        assert len(kept()) == edge["delivered"], edge
    finally:
        process.kill()
        agent.process.kill()
        agent.process.communicate()
