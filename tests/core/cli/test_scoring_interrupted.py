"""Ctrl-C while a run is scored leaves the scores out, not the summary."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from followspot.cli.main import main
from followspot.graph.compile import compile_graph
from followspot.library import execute
from followspot.operator.reporting.report import RunReport, merge
from followspot.worker.ledger import Ledger

GRAPH = Path(__file__).parents[3] / "graphs" / "glowballs.yaml"


def interrupt(*_: object) -> None:
    raise KeyboardInterrupt


@pytest.fixture
def stopped(monkeypatch: pytest.MonkeyPatch) -> None:
    """Runs end at once, stopped by their user, and scoring is interrupted."""

    def run_plan(plan: object, *_: object, **__: object) -> RunReport:
        found = compile_graph(GRAPH)
        return merge(found, Ledger(len(found.edges)), [], 1.0, stopped=True)

    monkeypatch.setattr(execute, "run_plan", run_plan)
    monkeypatch.setattr(execute, "run_scores", interrupt)


@pytest.mark.usefixtures("stopped")
def test_an_interrupted_score_leaves_the_summary(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", str(GRAPH), "--out", str(tmp_path), "--json"]) == 0
    said = capsys.readouterr()
    assert json.loads(said.out)["stopped"]
    assert "outputs are complete; scoring" in said.err
    assert "the run is not scored" in said.err
