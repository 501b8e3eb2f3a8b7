"""`followspot logs`: of a run that goes on, of one that has ended, and only what is asked for."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from pathlib import Path

import pytest

from followspot.cli.main import main
from followspot.control.dispatch import Dispatcher
from followspot.control.host import WorkerStatus
from followspot.control.observation import GetLog
from followspot.control.unix_socket import serve_requests
from followspot.errors import FollowspotError
from followspot.graph.compile import compile_graph
from followspot.graph.plan_data import plan_to_data
from followspot.log.file import LogFile
from followspot.log.record import LogPage, LogRecord
from followspot.log.run_log import RunLog
from followspot.operator.run_requests import GetPlan, GetRunMetadata, GetStatus, RunMetadata
from followspot.operator.run_status import RunStatus

GRAPH = Path(__file__).parents[3] / "graphs" / "glowballs.yaml"
NAME = f"{os.getpid():x}10ca1"
"""Of the run; other runs may be on this machine."""
SAID = (
    LogRecord(1, "info", "warm", worker="main", stage="color/cam0"),
    LogRecord(2, "warning", "dark\nvery", "pc-left", "left", "color/cam1"),
    LogRecord(3, "error", "broken", worker="main", stage="fuse"),
)


@pytest.fixture
def run(tmp_path: Path) -> Iterator[str]:
    """A run that says one thing more, and ends with a last word that nobody can ask for."""
    kept = RunLog(LogFile(tmp_path).write)
    kept.add(*SAID)
    plan = plan_to_data(compile_graph(GRAPH))

    def log(request: GetLog) -> LogPage:
        after = request.after
        if after == len(SAID):
            kept.add(LogRecord(5, "error", "a last word"))
            raise FollowspotError("the run has ended")
        page = kept.after(after)
        if not page.records:
            kept.add(LogRecord(4, "info", "at last"))
        return page

    running = RunStatus((WorkerStatus("main", "running"),), (), 0, None)
    dispatcher = Dispatcher(
        "operator",
        {
            GetPlan: lambda _: plan,
            GetStatus: lambda _: running,
            GetLog: log,
            GetRunMetadata: lambda _: RunMetadata(tmp_path),
        },
    )
    with serve_requests(NAME, "glowballs", dispatcher):
        yield NAME


def said(capsys: pytest.CaptureFixture[str], *words: str) -> list[str]:
    assert main(["logs", *words]) == 0
    return [json.loads(line)["text"] for line in capsys.readouterr().out.splitlines()]


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ((), ["warm", "dark\nvery", "broken"]),
        (("--level", "warning"), ["dark\nvery", "broken"]),
        (("--stage", "color"), ["warm", "dark\nvery"]),
        (("--stage", "color/cam1"), ["dark\nvery"]),
        (("--worker", "main", "--level", "error"), ["broken"]),
        (("--host", "pc-left"), ["dark\nvery"]),
    ],
)
def test_what_is_asked_for_is_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], words: tuple[str, ...], expected: list[str]
) -> None:
    file = LogFile(tmp_path)
    for record in SAID:
        file.write(record)
    assert said(capsys, "--run", str(tmp_path), "--json", *words) == expected


def test_a_run_that_goes_on_is_asked_once_or_followed_to_its_end(
    run: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert said(capsys, "--run", run, "--json") == ["warm", "dark\nvery", "broken"]
    assert main(["logs", "--run", run, "-f"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[1].endswith("warning pc-left/left color/cam1: dark")
    assert lines[2] == "    very"
    assert [line.rpartition(": ")[2] for line in lines[-2:]] == ["at last", "a last word"]


def test_a_folder_without_a_log_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["logs", "--run", str(tmp_path)]) == 2
    assert "log.jsonl" in capsys.readouterr().err
