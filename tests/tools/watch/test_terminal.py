"""`followspot top`, `hz` and `echo` on a run that answers as runs do."""

from __future__ import annotations

import argparse
import json
import os
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import replace
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rich.console import Group
from tests.tools.watch.screens import on_terminal

from followspot.cli.parser import build_parser
from followspot.context import Context
from followspot.control.dispatch import Dispatcher
from followspot.control.host import WorkerStatus
from followspot.control.stage_status import PathStatus, StageStatus
from followspot.control.tapping import PlaceTaps, Tapping
from followspot.control.unix_socket import serve_requests
from followspot.errors import FollowspotError
from followspot.graph.compile import compile_graph
from followspot.graph.plan import Plan
from followspot.graph.plan_data import plan_to_data
from followspot.messages import Header, stamped
from followspot.operator.connect import runs_here
from followspot.operator.run_requests import GetPlan, GetRunMetadata, GetStatus, RunMetadata
from followspot.operator.run_status import RunStatus
from followspot.plugins.registry import load_stage
from followspot.tables.terminal import grid, line
from followspot.taps.sender import TapSender
from followspot.tracking import Blobs, Frame, Tracks
from followspot.wire import pack
from followspot.worker.ledger import AWAY, COLUMNS, DELIVERED, DROPPED, LATE, PRODUCED, UNMATCHED
from followspot_dashboard.picture import picture_of
from followspot_watch.runs import listed_here
from followspot_watch.screen import live_screen

GRAPH = Path(__file__).parents[3] / "graphs" / "glowballs.yaml"
NAME = f"{os.getpid():x}terminal"
"""Of the run; other runs may be on this machine."""


@pytest.fixture(scope="module")
def run() -> Iterator[str]:
    plan = compile_graph(GRAPH)
    counts = [0] * (COLUMNS * len(plan.edges))
    for column, count in {PRODUCED: 12, AWAY: 2, DELIVERED: 6, DROPPED: 1, LATE: 1, UNMATCHED: 1}.items():
        counts[column] = count
    waiting = StageStatus(
        "fuse", "getting", ("a.out -> fuse.x", "b.out -> fuse.x"), 6, 1, 2, 9.0, "it\nhurts"
    )
    blocked = StageStatus("verify", "sending", ("verify.out -> triangulate.pairs",))
    worker = WorkerStatus(
        "main", "running", 7, stages=(waiting, blocked), paths=(PathStatus("camera", "save", 1.5, 9.0),)
    )
    status = RunStatus((worker,), tuple(counts), 7, 100, ("a worker is back",))

    tapped: list[Tapping] = []

    def tap(request: PlaceTaps) -> None:
        tapped[:] = request.taps
        for wanted in request.taps:
            tell(wanted)

    def status_now(_: GetStatus) -> RunStatus:
        """It is over when what it was asked for has been told."""
        over = replace(status, workers=(replace(worker, phase="over"),))
        return over if tapped else status

    with serve_requests(NAME, plan.graph, answering(plan, status_now, tap)):
        yield NAME


def answering(
    plan: Plan, status: Callable[[GetStatus], RunStatus], tap: Callable[[PlaceTaps], None]
) -> Dispatcher:
    """What a run on this machine answers."""
    return Dispatcher(
        "operator",
        {
            GetPlan: lambda _: plan_to_data(plan),
            GetStatus: status,
            PlaceTaps: tap,
            GetRunMetadata: lambda _: RunMetadata(Path("/nowhere")),
        },
    )


def tell(wanted: Tapping) -> None:
    """What a tap tells of two messages; of a source, nothing to a meter."""
    port, uses, params = wanted.port, wanted.uses, wanted.params
    if uses == "dashboard.meter" and not port.startswith("camera/"):
        meter = load_stage(uses)(Context(), **params)
        meter.monotonic_ns = lambda: 1  # all at once
        meter.setup()
        for message in sent(port):
            meter.process(message)
        meter.close()
        return
    taps = TapSender(Path(params["socket"]))
    for message in sent(port) if uses == "dashboard.echo" else ():
        taps.send(port, 0, pack(message))
    taps.close()


def sent(port: str) -> Iterator[Any]:
    """Two messages of a port."""
    for seq in range(2):
        header = Header("camera/cam0", seq, seq * 10**7)
        if port.startswith("camera/"):
            frame = stamped(Frame("cam0", np.zeros((24, 32, 3), "u1")), header)
            yield picture_of(frame, 320)
        elif port == "track.tracks":
            place = np.array([[1.0, np.nan, 0.5]])
            row = np.zeros(1, "i4")
            yield stamped(Tracks(row, np.ones(1, "u1"), place, place, place), header)
        else:
            yield stamped(Blobs.empty(), header)


def said(*line: str) -> int:
    args: argparse.Namespace = build_parser().parse_args(line)
    code: int = args.run_command(args)
    return code


@pytest.mark.parametrize("seconds", ["nan", "inf", "-1", "0"])
def test_a_time_between_tables_that_is_none_is_refused(
    seconds: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit):
        said("top", "--every", seconds)
    assert "argument --every: from 0.1 to 3600" in capsys.readouterr().err


def test_top_tells_once_what_everything_is_doing(run: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert said("top", "--run", run) == 0
    text = capsys.readouterr().out
    assert text.startswith(f"glowballs ({run[:8]}): 7 of 100 frames")
    fuse = next(line for line in text.splitlines() if line.startswith("  fuse "))
    assert fuse.split()[1:5] == ["main", "getting", "a.out", "+1"]
    verify = next(line for line in text.splitlines() if line.startswith("  verify "))
    assert verify.split()[3] == "triangulate.pairs"
    assert "fuse: it" in text
    assert "a worker is back" in text
    head = next(line for line in text.splitlines() if line.startswith("  edge "))
    assert head.split()[4:9] == ["produced", "away", "sent", "in", "flight"]
    first = next(line for line in text.splitlines() if " -> " in line)
    assert first.split()[5:] == ["12", "2", "10", "1", "1", "1", "1", "0", "0"]


def test_top_in_json_is_one_object(run: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert said("top", "--run", run, "--json") == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["run"], found["fired"], found["edges"][0]["late"]) == (run, 7, 1)
    assert (found["edges"][0]["produced"], found["edges"][0]["away"]) == (12, 2)


def test_echo_prints_messages_until_the_run_ends(run: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert said("echo", "track", "--run", run, "--json") == 0
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    tracks = [line for line in lines if line["port"] == "track.tracks"]
    assert [line["seq"] for line in tracks] == [0, 1]
    (row,) = tracks[0]["rows"]
    assert [row[name] for name in ("object", "state", "x", "y", "z")] == ["green", "tracked", 1.0, None, 0.5]


def test_echo_shows_a_table_with_names_and_units(run: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert said("echo", "track.tracks", "--run", run, "-n", "1") == 0
    head, columns, row = capsys.readouterr().out.splitlines()
    assert head.startswith("track.tracks  Tracks  camera/cam0#0")
    assert columns.split()[:6] == ["object", "state", "x", "[m]", "y", "[m]"]
    assert row.split()[:5] == ["green", "tracked", "1.0000", "None", "0.5000"]


def test_echo_ends_after_so_many_and_takes_all_cameras(run: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert said("echo", "camera.out", "--run", run, "-n", "7") == 0
    text = capsys.readouterr().out
    assert text.count("Picture") == 7
    assert "width 32" in text
    assert len({line.split()[0] for line in text.splitlines() if "Picture" in line}) > 3


def test_hz_tells_how_regularly_each_port_sends_and_what_was_lost(
    run: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert said("hz", "--run", run, "--json") == 0
    found = {pace["port"]: pace for pace in json.loads(capsys.readouterr().out)}
    assert found["track.tracks"]["count"] == 1  # the second comes too soon to be told of
    assert found["camera/cam0.out"]["count"] is None
    first = compile_graph(GRAPH).edges[0]
    assert found[f"{first.from_stage}.{first.from_port}"]["dropped"] == 5
    assert said("hz", "color/cam0", "--run", run) == 0
    (_, row) = capsys.readouterr().out.splitlines()
    assert row.split()[0] == "color/cam0.out"


def test_the_time_of_hz_begins_with_the_first_measurement(capsys: pytest.CaptureFixture[str]) -> None:
    plan, status = compile_graph(GRAPH), RunStatus((WorkerStatus("main", "running"),), (), 0, None)
    begun: list[threading.Timer] = []

    def tap(request: PlaceTaps) -> None:
        begun.append(threading.Timer(0.5, lambda: [tell(wanted) for wanted in request.taps]))
        begun[0].start()

    with serve_requests(f"late{NAME}", plan.graph, answering(plan, lambda _: status, tap)):
        assert said("hz", "track", "--run", f"late{NAME}", "--seconds", "0.1", "--json") == 0
    begun[0].join()
    found = {pace["port"]: pace for pace in json.loads(capsys.readouterr().out)}
    assert found["track.tracks"]["count"] == 1


def test_a_report_is_cut_to_the_terminal() -> None:
    def draw(most: int | None) -> Group:
        return Group(*(line(str(number) * 9) for number in range(10)[:most]))

    assert len(on_terminal(draw, 80, 10)) == 10
    assert on_terminal(draw, 5, 3) == ["00000", "11111", "... m"]
    assert "... more lines: make the window larger, or see --json" in on_terminal(draw, 80, 9)


def test_a_narrow_terminal_cuts_the_right_edge_of_a_table() -> None:
    rows = [("camera/cam0.out -> color/cam0.image", "call", "123456"), ("a -> b", "call", "7")]
    lines = on_terminal(lambda most: grid(("edge", "kind", "sent"), rows[:most]), 42, 9)
    assert lines == [
        "  edge                                 kin",
        "  camera/cam0.out -> color/cam0.image  cal",
        "  a -> b                               cal",
    ]


def test_the_last_report_stays_whole_when_the_screen_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    class Terminal(StringIO):
        def isatty(self) -> bool:
            return True

    for name, value in {"TERM": "xterm", "COLUMNS": "20", "LINES": "4"}.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setattr(sys, "stdout", seen := Terminal())
    with suppress(KeyboardInterrupt), live_screen() as show:
        for number in (1, 2):
            rows = [(f"{number}: " + "x" * 30, "7")] * 9
            show(lambda most, rows=rows: Group(line("y" * 30), grid(("edge", "sent"), rows[:most])))
        raise KeyboardInterrupt
    during, _, after = seen.getvalue().partition("\x1b[?1049l")
    assert "1: xxx" in during
    shown = [line.rstrip() for line in after.splitlines()]
    assert shown == ["y" * 30, f"  {'edge':<33}  sent", *["  2: " + "x" * 30 + "     7"] * 9]


def test_a_port_or_run_that_is_not_there_is_told_with_what_is(run: str) -> None:
    with pytest.raises(FollowspotError, match='did you mean "track"'):
        said("echo", "trak", "--run", run)
    with pytest.raises(FollowspotError, match=r"runs in reach: .*glowballs"):
        said("echo", "track", "--run", "nobody")


def test_a_run_is_shown_though_a_plugin_of_it_is_edited(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "edited.py").write_text("class Low(")
    plan = replace(compile_graph(GRAPH), plugin_files=(str(tmp_path / "edited.py"),))
    status = RunStatus((WorkerStatus("main", "running", 7),), (0,) * (COLUMNS * len(plan.edges)), 7, 100)
    name = f"{os.getpid():x}edited"
    with serve_requests(name, plan.graph, answering(plan, lambda _: status, lambda _: None)):
        assert said("top", "--run", name, "--json") == 0
        assert json.loads(capsys.readouterr().out)["fired"] == 7
        listed = next(found for found in map(listed_here, runs_here(name)) if found.run == name)
    assert (listed.state, listed.frames) == ("running", 7)
