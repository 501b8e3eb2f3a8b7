"""`followspot runs` lists the runs in reach with what other commands need to name them."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest

import followspot as fs
from followspot.cli.main import main
from followspot.control.dispatch import NoAnswer
from followspot.control.process_identity import user_of
from followspot.library.attach import FoundRun
from followspot.library.handle import RunHandle
from followspot_watch import runs

GRAPH = Path(__file__).parents[3] / "graphs" / "glowballs.yaml"


def test_a_run_of_this_machine_and_one_under_agents_are_listed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    with fs.run(GRAPH, out=tmp_path, frames=500) as run:
        run.pause()
        run.step()  # it is known to be paused then
        there = [
            FoundRun(
                "dddd4444eeee",
                "show",
                ("left", "right"),
                over=False,
                detached=True,
                owner="ann@desk",
                fired=77,
                age_s=65.0,
                folders=("left:/runs/a", "right:/runs/b"),
            ),
            FoundRun(run.run, "", (), False),
        ]
        monkeypatch.setattr(runs, "runs_under", lambda network, on_gap: there)
        assert main(["runs", "--json"]) == 0
        listed = json.loads(capsys.readouterr().out)
        assert main(["runs"]) == 0
        shown = capsys.readouterr().out
        run.resume()
        run.stop()
    by_name = {found["run"]: found for found in listed}
    mine, theirs = by_name[run.run], by_name["dddd4444eeee"]
    assert len(listed) == len(by_name), "each once"
    assert (mine["graph"], mine["hosts"], mine["state"]) == ("glowballs", ["this host"], "paused")
    assert (mine["process"], mine["folder"], mine["keeps_s"]) == (os.getpid(), str(tmp_path), None)
    assert 0 <= mine["age_s"] < 600
    assert (theirs["hosts"], theirs["state"], theirs["process"]) == (["left", "right"], "detached", None)
    assert (theirs["owner"], theirs["frames"], theirs["age_s"]) == ("ann@desk", 77, 65.0)
    assert theirs["folder"] == "left:/runs/a, right:/runs/b"
    assert mine["owner"] == user_of(os.getpid())
    assert run.run[:8] in shown
    for text in ("left, right", "ann@desk", "1 min 5 s", "right:/runs/b"):
        assert text in shown


def test_a_run_that_does_not_answer_is_listed_all_the_same() -> None:
    def silent(request: object, timeout: float) -> None:
        raise NoAnswer("it is suspended")

    found = runs.listed_here(RunHandle("aaaa", "", silent, 77))
    assert (found.state, found.process, found.frames) == ("does not answer", 77, None)


def test_no_run_is_said_in_words(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(runs, "runs_here", list)
    monkeypatch.setattr(runs, "runs_under", lambda network, on_gap: [])
    assert main(["runs"]) == 0
    assert capsys.readouterr().out == "there are no runs in reach\n"


@pytest.mark.parametrize(("seconds", "text"), [(5.9, "5 s"), (65, "1 min 5 s"), (7325, "2 h 2 min")])
def test_ages_are_short(seconds: float, text: str) -> None:
    assert runs._age(seconds) == text
