"""What a run that its user stops says of its outputs and scores, and Ctrl-C while it is scored."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from followspot.cli.main import main
from followspot.control.worker_report import WorkerReport
from followspot.graph.compile import compile_graph
from followspot.library import execute
from followspot.operator.reporting.report import RunReport, merge
from followspot.worker.ledger import Ledger

GRAPH = Path(__file__).parents[3] / "graphs" / "glowballs.yaml"


def interrupt(*_: object) -> None:
    raise KeyboardInterrupt


@pytest.fixture
def stopped_run(monkeypatch: pytest.MonkeyPatch) -> None:
    """Runs that their user stops after seven frames; scoring is interrupted."""
    monkeypatch.setattr(execute, "run_plan", lambda *_, **__: report(frames=7))
    monkeypatch.setattr(execute, "run_scores", interrupt)


def report(frames: int, error: str = "") -> RunReport:
    found = compile_graph(GRAPH)
    worker = WorkerReport("main", frames, error=error)
    return merge(found, Ledger(len(found.edges)), [worker], 1.0, stopped=True)


@pytest.mark.usefixtures("stopped_run")
def test_an_interrupted_score_leaves_the_summary(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", str(GRAPH), "--out", str(tmp_path), "--json"]) == 0
    said = capsys.readouterr()
    assert json.loads(said.out)["stopped"]
    assert "outputs are complete; scoring 7 frames" in said.err
    assert "the run is not scored" in said.err


def test_outputs_of_a_stopped_run_that_failed_are_not_called_complete(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(execute, "run_plan", lambda *_, **__: report(frames=7, error="the disk is full"))
    monkeypatch.setattr(execute, "run_scores", interrupt)
    assert main(["run", str(GRAPH), "--out", str(tmp_path)]) == 1
    said = capsys.readouterr()
    assert "complete" not in said.err
    assert "the run failed; scoring 7 frames" in said.err


def test_a_run_that_is_stopped_before_its_first_frame_says_so_and_blames_no_camera(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(execute, "run_plan", lambda *_, **__: replace(report(frames=0), begun=False))
    monkeypatch.setattr(execute, "run_scores", interrupt)
    assert main(["run", str(GRAPH), "--out", str(tmp_path)]) == 0
    said = capsys.readouterr()
    assert "stopped before its first frame" in said.out
    assert "complete" not in said.err
    assert "scor" not in said.err
    assert "gave nothing" not in said.out
    assert "accuracy" not in said.out
