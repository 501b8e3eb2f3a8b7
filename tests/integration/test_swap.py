"""Hot swaps in running graphs: nothing is lost, and a failed swap changes nothing."""

from __future__ import annotations

import json
import os
import signal
from itertools import pairwise
from pathlib import Path

import pytest
from tests.commands import command
from tests.integration.going import going, wait_until
from tests.integration.hosts import near_agent
from tests.integration.running import STAGES, balanced, finish, start, write_graph
from tests.integration.zenoh_listener import heard_by_a_stranger

from followspot.errors import FollowspotError
from followspot.operator.connect import run_here

REPLAY = """
a:    {uses: ticks.count, with: {count: 1200}}
b:    {uses: ticks.add, in: {number: a}, with: {sleep: 0.02}}  # until another one takes its place
save: {uses: ticks.write, in: {number: b}}
"""
LIVE = """
a:    {uses: ticks.live, with: {count: 1000000, period: 0.02}}
b:    {uses: ticks.tally, in: {number: a}}
c:    {uses: ticks.tally, in: {number: a}}
save: {uses: ticks.write, in: {number: b}}
keep: {uses: ticks.write, in: {number: c}, with: {path: kept.csv}}
"""


@pytest.mark.parametrize("workers", [1, 2])
def test_a_replay_that_is_changed_loses_nothing(tmp_path: Path, workers: int) -> None:
    with going(tmp_path, REPLAY, workers) as run:
        run_here(run.name).change(["b.term=1000"])
        run.grows()
        report = run_here(run.name).change(["b=ticks.swapped"])
        finished = finish(run.process, run.out)
    assert finished.code == 0, finished.errors
    assert [stage.uses for stage in report.stages] == ["ticks.swapped"]
    rows = [line.split(",") for line in finished.lines()]
    assert [int(row[0]) for row in rows] == list(range(1200)), "every frame has its row"
    terms = [int(row[2]) - int(row[0]) for row in rows]
    assert terms == sorted(terms)
    assert set(terms) == {1, 1000, 5000}
    counts = {(e["to"], e["sent"], e["delivered"]) for e in finished.summary["edges"]}
    assert counts == {("b.number", 1200, 1200), ("save.number", 1200, 1200)}, "as without a change"
    assert "while it ran: b: term = 1000" in finished.summary["notes"]


PART = """\
params: {{first: b.term}}
inputs: {{number: b.number}}
outputs: {{number: c}}
stages:
  b: {{uses: ticks.add, with: {{term: {term}, sleep: {sleep}}}}}
  c: {{uses: ticks.add, in: {{number: b}}, with: {{term: {term}}}}}
"""
WHOLE = """
a:    {uses: ticks.count, with: {count: 1200}}
hall: {graph: part.yaml, in: {number: a}}
save: {uses: ticks.write, in: {number: hall}}
"""


def test_a_sub_graph_is_swapped_as_a_whole_and_no_message_is_lost(tmp_path: Path) -> None:
    """Stage hall/b runs in another worker than the rest."""
    (tmp_path / "part.yaml").write_text(PART.format(term=1, sleep=0.02))
    (tmp_path / "other.yaml").write_text(PART.format(term=1000, sleep=0.0))
    with going(tmp_path, WHOLE, 2, "hall/b") as run:
        words = [f"hall={tmp_path / 'other.yaml'}", "hall.first=5000"]
        report = run_here(run.name).change(words)
        assert {stage.stage for stage in report.stages} == {"hall/b", "hall/c"}
        finished = finish(run.process, run.out)
    assert finished.code == 0, finished.errors
    rows = [line.split(",") for line in finished.lines()]
    assert [int(row[0]) for row in rows] == list(range(1200)), "every frame has its row"
    terms = [int(row[2]) - int(row[0]) for row in rows]
    assert (terms[0], terms[-1]) == (2, 6000)
    assert set(terms) <= {2, 1001, 5001, 6000}, "a worker may take over a few messages after another"
    assert terms == sorted(terms)
    assert balanced(finished.summary)


REFUSED = [
    (["b.step=one"], '"step" of stage "b" (ticks.tally) cannot be \'one\''),
    (["b=ticks.both"], 'the replacement of "b" has no input "number"'),
    (["b=ticks.gone"], 'no stage "ticks.gone" is installed'),
    (["b.broken=true"], "stage b (ticks.tally) cannot be built: RuntimeError: the model is missing"),
    (["b.step=7", "b.forgetful=true"], "cannot carry on from the state of the one before"),
    (["c.step=7", "b.step=7", "b.forgetful=true"], "stage b cannot carry on"),
    (["c.step=7", "c.broken=true", "b.step=7"], "stage c (ticks.tally) cannot be built"),
]
"""Stages b and c are in two workers; if one cannot be replaced, the other keeps its old stage, too."""


def test_a_failed_swap_changes_nothing_and_a_replacement_keeps_its_state_after_a_death(
    tmp_path: Path,
) -> None:
    with going(tmp_path, LIVE, 2) as run:
        for words, why in REFUSED:
            with pytest.raises(FollowspotError) as raised:
                run_here(run.name).change(words)
            assert why in str(raised.value)
        assert run_here(run.name).change(["save.path=ticks.csv", "b=ticks.tally"]).stages == (), (
            "it is so already"
        )
        run.grows()
        for file in ("ticks.csv", "kept.csv"):
            before = run.values(file)
            assert before == list(range(1, len(before) + 1)), "all went on as it was"
        run_here(run.name).change(["b.step=1000", "c.step=1000"])
        for file in ("ticks.csv", "kept.csv"):
            run.reaches(2000, file)
            steps = [later - sooner for sooner, later in pairwise(run.values(file))]
            assert set(steps) == {1, 1000}, "it counted on"
            assert steps == sorted(steps), "each number by the old one or by the new one"
        _, worker = run.workers()
        os.kill(worker, signal.SIGKILL)
        assert wait_until(lambda: worker not in run.workers() and len(run.workers()) == 2)
        run.grows()
        assert run.step() == 1000, "the replacement comes back"
        run_here(run.name).change(["b.step=7", "b.forgetful=true"], fresh=True)
        assert wait_until(lambda: run.step() == 7)
        assert run.values().count(7) == 2, "it began without a state"
        finished = run.stopped()
    assert balanced(finished.summary)


TALLY = """\
params: {{{name}: t.step}}
inputs: {{number: t.number}}
outputs: {{number: t}}
stages: {{t: {{uses: {uses}, with: {{step: {step}}}}}}}
"""
OTHER = """\
inputs: {number: u.number}
outputs: {number: v}
stages:
  u: {uses: ticks.tally, with: {step: 10}}
  v: {uses: ticks.add, in: {number: u}, with: {term: 5}}
"""
HALL = """
hall: {graph: tally.yaml, in: {number: a}}
far:  {uses: ticks.write, in: {number: hall}, with: {path: far.csv}}
"""


def test_a_run_under_an_agent_is_changed_without_its_operator(tmp_path: Path) -> None:
    agent = near_agent("pc-left", tmp_path)
    connect = ("--connect", agent.endpoint)
    (tmp_path / "tally.yaml").write_text(TALLY.format(name="step", uses="ticks.tally", step=1))
    (tmp_path / "quick.yaml").write_text(TALLY.format(name="stride", uses="ticks.tally", step=100_000))
    graph = write_graph(tmp_path, LIVE + HALL, "faraway")
    try:
        operator = start(graph, tmp_path, "--host", "pc-left", "--detach", *connect)
        stdout, stderr = operator.communicate(timeout=60)
        assert stdout, stderr
        (folder,) = (tmp_path / "runs").iterdir()

        def last(file: str = "ticks.csv") -> int:
            lines = (folder / file).read_text().splitlines() if (folder / file).exists() else []
            return int(lines[-1].split(",")[2]) if lines else 0

        def change(*words: str) -> str:
            done = command(words[0], "--run", "faraway", words[1], *stages, *connect)
            return done.stdout + done.stderr

        assert wait_until(lambda: last() > 0)
        stages = ("--plugin", str(STAGES))
        done = command("set", "--run", "faraway", "b.step=1000000", "--json", *stages, *connect)
        assert done.returncode == 0, done.stderr
        (found,) = json.loads(done.stdout)["stages"]
        assert (found["stage"], found["params"]) == ("b", {"step": 1000000})
        assert wait_until(lambda: last() > 1_000_000)
        refused = command("set", "--run", "faraway", "save.path=../elsewhere.csv", *stages, *connect)
        assert refused.returncode == 1
        assert "not below the output folder" in refused.stderr
        for name in ("tally", "faraway"):
            (tmp_path / f"{name}.yaml").unlink()
        assert "hall/t: step = 10000" in change("set", "hall.step=10000")
        assert wait_until(lambda: last("far.csv") > 10_000)
        assert "run " in change("swap", f"hall={tmp_path / 'quick.yaml'}")
        assert "hall/t: step = 20000" in change("set", "hall.stride=20000")
        assert 'has no parameter "step"' in change("set", "hall.step=1")
        (tmp_path / "other.yaml").write_text(OTHER)
        assert "hall/t: left (ticks.tally)" in change("swap", f"hall={tmp_path / 'other.yaml'}")
        assert wait_until(lambda: last("far.csv") % 10 == 5), "another inside"
        assert "hall/v: term = 3" in change("set", "hall/v.term=3")
        assert wait_until(lambda: last("far.csv") % 10 == 3)
        taps = [f"followspot/*/pc-left/{port}/out" for port in ("a", "b")]
        for numbers in heard_by_a_stranger(agent.endpoint, taps, more=20):
            assert numbers == sorted(set(numbers))
    finally:
        agent.process.kill()
        agent.process.communicate()
