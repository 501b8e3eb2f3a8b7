"""Signals and killed workers: outputs are complete, the worker is named, nothing is left behind."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
from pathlib import Path

import pytest
from tests.commands import COMMAND
from tests.integration.running import (
    Finished,
    alive,
    balanced,
    finish,
    run,
    start,
    unused_memory,
    wait_until,
    words_of,
    workers,
    write_graph,
)

ENDLESS = """
a:    {uses: ticks.count, with: {count: 1000000, size: 5000}}
b:    {uses: ticks.add, in: {number: a}, with: {sleep: 0.001}}
save: {uses: ticks.write, in: {number: b}}
"""
EXIT = """
a:    {uses: ticks.count, with: {count: 10}}
b:    {uses: ticks.add, in: {number: a}, with: {exit_at: 5}}
save: {uses: ticks.write, in: {number: b}}
"""
PLACEMENTS = [(), ("--placement", "stage"), ("--placement", "stage", "--edges", "zenoh")]


def running(out: Path) -> bool:
    """True if tracks are being written."""
    path = out / "ticks.csv"
    return path.exists() and path.stat().st_size > 0


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
@pytest.mark.parametrize(
    "options",
    [*PLACEMENTS[:2], pytest.param(PLACEMENTS[2], marks=pytest.mark.thorough)],
    ids=["one", "stages", "zenoh"],
)
def test_ctrl_c_and_sigterm_end_cleanly_with_complete_outputs(
    tmp_path: Path, options: tuple[str, ...], number: signal.Signals
) -> None:
    process = start(write_graph(tmp_path, ENDLESS), tmp_path / "out", *options)
    assert wait_until(lambda: running(tmp_path / "out")), "the run never began"
    process.send_signal(number)
    finished = finish(process, tmp_path / "out")
    assert finished.code == 0, finished.errors
    assert finished.summary["stopped"]
    assert balanced(finished.summary)
    values = finished.values()
    assert values == list(range(1, len(values) + 1)), "every line is whole, none is missing"
    assert len(values) == finished.summary["frames"], "what was in flight was finished"


def test_nohup_keeps_a_run_when_its_terminal_closes(tmp_path: Path) -> None:
    words = words_of(write_graph(tmp_path, ENDLESS), tmp_path / "out")
    process = subprocess.Popen(
        ["nohup", *COMMAND, *words],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert wait_until(lambda: running(tmp_path / "out")), "the run never began"
    process.send_signal(signal.SIGHUP)
    written = (tmp_path / "out" / "ticks.csv").stat().st_size
    assert wait_until(lambda: (tmp_path / "out" / "ticks.csv").stat().st_size > written + 2_000)
    process.send_signal(signal.SIGTERM)
    assert finish(process, tmp_path / "out").code == 0


@pytest.mark.parametrize("edges", ["ring", pytest.param("zenoh", marks=pytest.mark.thorough)])
@pytest.mark.parametrize("victim", ["a", "b", pytest.param("save", marks=pytest.mark.thorough)])
def test_a_worker_killed_mid_run_is_named_and_the_rest_ends(tmp_path: Path, victim: str, edges: str) -> None:
    before = unused_memory()
    process = start(
        write_graph(tmp_path, ENDLESS), tmp_path / "out", "--placement", "stage", "--edges", edges
    )
    assert wait_until(lambda: running(tmp_path / "out")), "the run never began"
    started = workers(process.pid)
    os.kill(worker_of(process.pid, victim), signal.SIGKILL)
    finished = finish(process, tmp_path / "out")
    assert finished.code == 1
    assert any(f"worker {victim} " in e and "SIGKILL" in e for e in finished.summary["errors"])
    check_counts(finished)
    assert wait_until(lambda: not any(alive(pid) for pid in started))
    assert wait_until(lambda: unused_memory() <= before)


@pytest.mark.parametrize("options", PLACEMENTS[:2], ids=["one", "stages"])
def test_a_stage_that_ends_its_process_with_code_0_fails_and_is_named(
    tmp_path: Path, options: tuple[str, ...]
) -> None:
    finished = run(write_graph(tmp_path, EXIT), *options)
    assert finished.code == 1
    assert any("stage b failed" in e and "os._exit(0)" in e for e in finished.summary["errors"])
    assert finished.values() == list(range(1, 6)), "what was computed before is written"


@pytest.mark.parametrize("options", PLACEMENTS[:2], ids=["one", "stages"])
@pytest.mark.parametrize("tidy", [False, True])
def test_a_process_that_a_stage_forks_in_setup_is_no_second_worker(
    tmp_path: Path, options: tuple[str, ...], tidy: bool
) -> None:
    stages = f"a: {{uses: ticks.fork, with: {{count: 100, tidy: {str(tidy).lower()}}}}}"
    graph = write_graph(tmp_path, f"{stages}\nsave: {{uses: ticks.write, in: {{number: a}}}}")
    finished = run(graph, *options)
    told = "stage a failed: ForkedCopyError: its setup forked this process and returned in both: end the new"
    if tidy:
        assert (finished.code, finished.values()) == (0, list(range(100)))
    else:
        assert finished.code == 1
        assert finished.errors.count(told) == 1
        assert finished.summary["frames"] == 0, "told before the run began"


def worker_of(launcher: int, stage: str) -> int:
    """The process that runs a stage: workers start in the order of the plan."""
    order = ["a", "b", "save"]
    return workers(launcher)[order.index(stage)]


def check_counts(finished: Finished) -> None:
    """Check that every message was delivered, or lost with the dead worker or on its way to it."""
    parts = ("delivered", "dropped", "late", "unmatched", "invalid", "lost", "in_flight")
    for edge in finished.summary["edges"]:
        assert edge["sent"] == sum(edge[part] for part in parts)
        assert 0 <= edge["in_flight"] + edge["lost"] <= 10, edge
    written = len([line for line in finished.lines() if line.count(",") == 3])
    assert written <= finished.edge("b.", "save.")["sent"]


@pytest.mark.parametrize(
    "options",
    [PLACEMENTS[1], pytest.param(PLACEMENTS[2], marks=pytest.mark.thorough)],
    ids=["stages", "zenoh"],
)
def test_workers_listen_on_loopback_only_and_end_when_their_launcher_is_killed(
    tmp_path: Path, options: tuple[str, ...]
) -> None:
    before = unused_memory()
    process = start(write_graph(tmp_path, ENDLESS), tmp_path / "out", *options)
    assert wait_until(lambda: running(tmp_path / "out")), "the run never began"
    started = workers(process.pid)
    assert len(started) == 3
    assert listening(started) == ({"127.0.0.1"} if "zenoh" in options else set())
    process.kill()
    process.communicate()
    assert wait_until(lambda: not any(alive(pid) for pid in started))
    assert wait_until(lambda: unused_memory() <= before)
    lines = (tmp_path / "out" / "ticks.csv").read_text().splitlines()
    assert [int(line.split(",")[2]) for line in lines] == list(range(1, len(lines) + 1))


def listening(pids: list[int]) -> set[str]:
    """Addresses on which processes listen."""
    inodes = {
        str(link.readlink())[8:-1]
        for pid in pids
        for link in Path(f"/proc/{pid}/fd").iterdir()
        if str(link.readlink()).startswith("socket:[")
    }
    return {
        socket.inet_ntoa(bytes.fromhex(fields[1].partition(":")[0])[::-1])
        for line in Path("/proc/net/tcp").read_text().splitlines()[1:]
        if (fields := line.split())[3] == "0A" and fields[9] in inodes
    }


def test_a_stage_that_cannot_be_set_up_stops_the_run_before_it_starts(tmp_path: Path) -> None:
    graph = write_graph(
        tmp_path,
        """
a:    {uses: ticks.count}
save: {uses: ticks.write, in: {number: a}, with: {path: no/such/folder.csv}}
""",
    )
    for options in PLACEMENTS[:2]:
        finished = finish(start(graph, tmp_path / "out", *options), tmp_path / "out")
        assert finished.code == 1
        assert any("stage save failed" in error for error in finished.summary["errors"])
        assert finished.edge("a.", "save.")["sent"] == 0


TRACKS = """
from followspot import Source, Stage, at
from followspot.tracking import Tracks

class Seen(Stage):
    'A tracker that sees nothing.'

    def process(self) -> Source[Tracks]:
        yield at(0, Tracks.empty())
"""


def test_unreadable_truth_does_not_prevent_the_summary(tmp_path: Path) -> None:
    (tmp_path / "truth.csv").write_text("frame,time,object\n0,0,red\n")
    (tmp_path / "room.yaml").write_text(
        "room: r\ntruth: {uses: cameras.truth_csv, with: {path: truth.csv}}\n"
    )
    (tmp_path / "nothing.py").write_text(TRACKS)
    graph = write_graph(tmp_path, "a: {uses: nothing.seen}\nsave: {uses: sinks.csv, in: {tracks: a}}\n")
    options = ("--room", str(tmp_path / "room.yaml"), "--plugin", str(tmp_path / "nothing.py"))
    process = start(graph, tmp_path / "out", *options)
    finished = finish(process, tmp_path / "out")
    assert finished.code == 0
    assert finished.summary["targets"] == {}
    assert "cannot score the run" in finished.errors
    assert "truth.csv" in finished.errors
