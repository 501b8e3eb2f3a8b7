"""A sub-graph is swapped for a file with other stages and edges while the graph runs."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import pytest
from tests.commands import Started
from tests.integration.going import APART as OTHER_WORKER
from tests.integration.going import Going, going, wait_until
from tests.integration.hosts import near_agent
from tests.integration.running import STAGES, balanced, finish, start, workers, write_graph
from tests.integration.zenoh_listener import heard_by_a_stranger

import followspot as fs
from followspot.errors import FollowspotError
from followspot.operator.connect import run_here

SLOW = """\
inputs: {number: [b.number, t.number]}
outputs: {number: sum}
stages:
  b:   {uses: ticks.add, with: {term: 2, sleep: 0.01}}
  t:   {uses: ticks.tally}
  odd_b: {uses: ticks.odd, in: {number: b}}
  odd_t: {uses: ticks.odd, in: {number: t}}
  sum: {uses: ticks.sum, in: {numbers: [b, t, odd_b, odd_t]}, tolerance: 0.001}
"""
"""Gives n + 2, n + 1, and again the odd one of the two: a firing always waits until the other cannot come."""
QUICK = """\
inputs: {number: [t.number, odd.number, late.left]}
outputs: {number: late}
stages:
  t:    {uses: ticks.tally, with: {step: 2}}
  odd:  {uses: ticks.add, with: {term: 1000}}
  all:  {uses: ticks.sum, in: {numbers: [t, odd]}, tolerance: 0.001}
  late: {uses: ticks.both, in: {right: all}, tolerance: 0.001}
"""
"""Gives n * 1000 + (t + n + 1000) for n: the tally t counts on, in steps of 2."""
WHOLE = """
a:    {uses: ticks.count, with: {count: 1200}}
hall: {graph: part.yaml, in: {number: a}}
save: {uses: ticks.write, in: {number: hall}}
side: {uses: ticks.both, in: {left: a, right: hall}, tolerance: 0.001}
keep: {uses: ticks.write, in: {number: side}, with: {path: kept.csv}}
"""
LIVE = WHOLE.replace("ticks.count, with: {count: 1200}", "ticks.live, with: {count: 1000000, period: 0.02}")

FAR = """
placement: far
workers:
  far: {host: pc-left, stages: [hall]}
"""


def files(folder: Path) -> tuple[str, str]:
    """Words that put the quick file in the place of the slow one, and back."""
    (folder / "part.yaml").write_text(SLOW)
    (folder / "quick.yaml").write_text(QUICK)
    return f"hall={folder / 'quick.yaml'}", f"hall={folder / 'part.yaml'}"


def slow(n: int) -> int:
    return 2 * n + 3 + (n + 1 if n % 2 == 0 else n + 2)


def quick(n: int, first: int) -> int:
    """What the quick file gives if `first` was its first number."""
    return n * 1000 + first + 2 * (n - first + 1) + n + 1000


@pytest.mark.parametrize("apart", ["", "hall/b", "a"])
def test_a_replay_goes_on_with_another_inside_and_loses_nothing(tmp_path: Path, apart: str) -> None:
    """In one worker, or with a stage that goes, or the source, in a worker of its own."""
    there, _ = files(tmp_path)
    with going(tmp_path, WHOLE, 2 if apart else 1, apart) as run:
        report = run_here(run.name).change([there])
        assert [(s.stage, s.before, s.uses) for s in report.stages] == [
            ("hall/b", "ticks.add", ""),
            ("hall/odd_b", "ticks.odd", ""),
            ("hall/odd_t", "ticks.odd", ""),
            ("hall/sum", "ticks.sum", ""),
            ("hall/t", "ticks.tally", "ticks.tally"),
            ("hall/odd", "", "ticks.add"),
            ("hall/all", "", "ticks.sum"),
            ("hall/late", "", "ticks.both"),
        ]
        finished = finish(run.process, run.out)
    assert finished.code == 0, finished.errors
    values = finished.values()
    first = next(n for n, value in enumerate(values) if value != slow(n))
    assert first > 5
    assert values[:first] == [slow(n) for n in range(first)]
    assert values[first:] == [quick(n, first) for n in range(first, 1200)], "the tally counted on"
    kept = finished.values("kept.csv")
    assert kept == [n * 1000 + value for n, value in enumerate(values)], "outside, all met as ever"
    assert balanced(finished.summary)
    lost = {name: finished.edge("", "")[name] for name in ("dropped", "late", "unmatched", "invalid", "lost")}
    assert set(lost.values()) == {0}
    assert finished.edge("hall/b", "hall/sum")["delivered"] == first, "edges that left are in the ledger"
    assert finished.edge("hall/all", "hall/late")["delivered"] == 1200 - first


@pytest.mark.parametrize("apart", ["", "hall/b", "side"])
def test_a_live_run_goes_on_with_another_inside_and_back(tmp_path: Path, apart: str) -> None:
    """A worker without stages ends, none starts anew; one may die afterwards."""
    there, back = files(tmp_path)
    with going(tmp_path, LIVE, 2 if apart else 1, apart) as run:
        before = run.workers()
        run_here(run.name).change([there])
        assert is_reached(run, quick=True)
        assert set(run.workers()) <= set(before), "none starts anew"
        if apart == "side":
            lines = len(run.values())
            os.kill(before[0], signal.SIGKILL)
            assert wait_until(lambda: len(run.values()) < lines), "its file begins anew"
            assert is_reached(run, quick=True)
        run_here(run.name).change([back])
        assert is_reached(run, quick=False)
        finished = run.stopped()
    assert finished.code == 0, finished.errors
    assert balanced(finished.summary)
    assert finished.summary["workers"]


def test_a_stage_that_comes_back_has_no_fault_of_the_one_that_left(tmp_path: Path) -> None:
    files(tmp_path)
    graph = write_graph(tmp_path, LIVE)
    with fs.run(graph, out=tmp_path / "out", plugin_files=[STAGES]) as run:
        messages = iter(run["hall/b.out"])  # whose end is a warning of the stage
        next(messages)

        def faults() -> dict[str, str]:
            return {stage.stage: stage.error for worker in run.status().workers for stage in worker.stages}

        run.swap("hall", str(tmp_path / "quick.yaml"))
        assert wait_until(lambda: "hall/b" not in faults())
        run.swap("hall", str(tmp_path / "part.yaml"))
        assert wait_until(lambda: "hall/b" in faults())
        assert faults()["hall/b"] == ""


def test_a_port_within_that_a_script_reads_must_be_in_the_file(tmp_path: Path) -> None:
    files(tmp_path)
    graph = write_graph(tmp_path, LIVE)
    with fs.run(graph, out=tmp_path / "out", plugin_files=[STAGES], ports=["hall/b.out"]) as run:
        with pytest.raises(FollowspotError, match=r"reads hall/b\.out, which the file lacks"):
            run.swap("hall", str(tmp_path / "quick.yaml"))
        assert next(iter(run["hall/b.out"]))


def is_reached(run: Going, *, quick: bool) -> bool:
    """Wait until the quick file's numbers are written, or the slow one's."""
    found = (lambda value: value > 20_000) if quick else (lambda value: 0 < value < 20_000)
    return wait_until(lambda: found((run.values() or [0])[-1]))


ENDED = """
a:    {uses: ticks.count, with: {count: 300}}
x:    {uses: ticks.count, with: {count: 3}}
hall: {graph: part.yaml, in: {left: a, right: x}}
save: {uses: ticks.write, in: {number: hall}}
"""
ALONE = """\
inputs: {left: add.number, right: rest.number}
outputs: {number: add}
stages:
  add:  {uses: ticks.add, with: {term: 0, sleep: 0.01}}
  rest: {uses: ticks.add}
"""
TOGETHER = """\
inputs: {left: near.number, right: far.number}
outputs: {number: sum}
stages:
  near: {uses: ticks.add, with: {term: 0}}
  far:  {uses: ticks.add}
  sum:  {uses: ticks.sum, in: {numbers: [near, far]}}
"""


def test_a_new_stage_knows_how_far_its_inputs_are(tmp_path: Path) -> None:
    """The stream x has ended: a join that did not know would wait for it for ever."""
    (tmp_path / "part.yaml").write_text(ALONE)
    (tmp_path / "other.yaml").write_text(TOGETHER)
    with going(tmp_path, ENDED, 1) as run:
        run_here(run.name).change([f"hall={tmp_path / 'other.yaml'}"])
        finished = finish(run.process, run.out)
    assert finished.code == 0, finished.errors
    assert finished.values() == list(range(300))


def is_changed(process: Started, word: str) -> bool:
    """Whether a change was made; False as long as the operator does not know that the run has begun."""
    try:
        run_here(str(process.pid)).change([word])
    except FollowspotError as error:
        assert "has not begun yet" in str(error)  # noqa: PT017
        return False
    return True


MEETING = """\
inputs: {left: meet.left, right: meet.right}
outputs: {number: meet}
stages:
  meet: {uses: ticks.both}
"""
LATER = """\
inputs: {left: add.number, right: pair.right}
outputs: {number: pair}
stages:
  add:  {uses: ticks.add, with: {term: 1}}
  pair: {uses: ticks.both, in: {left: add}}
"""
APART = """
a:    {uses: ticks.count, with: {count: 300}}
z:    {uses: ticks.count, with: {count: 300}}
slow: {uses: ticks.add, in: {number: a}, with: {term: 0, sleep: 0.01}}
hall: {graph: part.yaml, in: {left: slow, right: z}}
save: {uses: ticks.write, in: {number: hall}}
"""


def test_a_paused_replay_takes_another_inside_between_two_frames(tmp_path: Path) -> None:
    (tmp_path / "part.yaml").write_text(MEETING)
    (tmp_path / "later.yaml").write_text(LATER)
    with going(tmp_path, APART, 1) as run:
        run_here(run.name).pause()
        run_here(run.name).change([f"hall={tmp_path / 'later.yaml'}"])
        run_here(run.name).resume()
        finished = finish(run.process, run.out)
    assert finished.code == 0, finished.errors
    terms = [value // 1000 - n for n, value in enumerate(finished.values())]
    assert [value % 1000 for value in finished.values()] == list(range(300))
    assert terms == sorted(terms)
    assert set(terms) == {0, 1}, "each frame went one way as a whole"
    assert finished.edge("slow", "hall/meet")["lost"] == finished.edge("z", "hall/meet")["lost"] == 0


@pytest.mark.parametrize("apart", ["", "side"])
def test_a_stage_that_cannot_be_built_leaves_the_graph_as_it_was(tmp_path: Path, apart: str) -> None:
    there, _ = files(tmp_path)
    broken = QUICK.replace("ticks.add, with: {term: 1000}", "ticks.tally, with: {broken: true}")
    (tmp_path / "quick.yaml").write_text(broken)
    with going(tmp_path, LIVE, 2 if apart else 1, apart) as run:
        before = run.workers()
        with pytest.raises(FollowspotError) as refused:
            run_here(run.name).change([there])
        assert str(refused.value).startswith("stage hall/odd (ticks.tally) cannot be built: RuntimeError")
        run.grows()
        assert run.values()[-1] < 20_000
        assert run.workers() == before
        finished = run.stopped()
    assert finished.code == 0, finished.errors
    assert all(not e["from"].startswith("hall/odd.") for e in finished.summary["edges"])


def test_a_live_run_over_two_hosts_goes_on_with_another_inside_and_back(tmp_path: Path) -> None:
    """A stage that cannot be built leaves all as it was; its edges find their ends when it is tried again."""
    there, back = files(tmp_path)
    broken = QUICK.replace("ticks.add, with: {term: 1000}", "ticks.tally, with: {broken: true}")
    (tmp_path / "quick.yaml").write_text(broken)
    agent = near_agent("pc-left", tmp_path)
    (tmp_path / "far.yaml").write_text(FAR)
    options = ("--placement", str(tmp_path / "far.yaml"), "--connect", agent.endpoint)
    run = Going.of(start(write_graph(tmp_path, LIVE), tmp_path / "out", *options), tmp_path / "out")
    try:
        run.grows()
        before = run.workers(), workers(agent.process.pid)
        with pytest.raises(FollowspotError) as refused:
            run_here(run.name).change([there])
        assert str(refused.value).startswith("stage hall/odd (ticks.tally) cannot be built: RuntimeError")
        run.grows()
        (tmp_path / "quick.yaml").write_text(QUICK)
        run_here(run.name).change([there])
        assert is_reached(run, quick=True)
        (late,) = heard_by_a_stranger(agent.endpoint, ["followspot/*/pc-left/hall/late/out"], more=5)
        assert min(late) > 20_000
        run_here(run.name).change([back])
        assert is_reached(run, quick=False)
        assert (run.workers(), workers(agent.process.pid)) == before, "none starts anew"
        finished = run.stopped()
    finally:
        run.process.kill()
        agent.process.kill()
        agent.process.communicate()
    assert finished.code == 0, finished.errors
    assert balanced(finished.summary)
    assert finished.edge("a", "hall/b")["delivered"] > 0
    assert finished.edge("a", "hall/odd.")["delivered"] > 0
    assert not [line for line in finished.summary["warnings"] if "refused" in line]


@pytest.mark.thorough
def test_two_workers_of_an_agent_go_on_with_another_inside_and_back(tmp_path: Path) -> None:
    there, back = files(tmp_path)
    (tmp_path / "quick.yaml").write_text(QUICK.replace("term: 1000", "term: 1000, sleep: 0.01"))
    agent = near_agent("pc-left", tmp_path)
    (tmp_path / "apart.yaml").write_text(OTHER_WORKER.replace("STAGE", "hall/t"))
    options = ("--placement", str(tmp_path / "apart.yaml"), "--host", "pc-left", "--connect", agent.endpoint)
    process = start(write_graph(tmp_path, WHOLE), tmp_path / "out", *options)
    try:
        assert wait_until(lambda: list(tmp_path.glob("runs/*/ticks.csv")))
        (written,) = tmp_path.glob("runs/*/ticks.csv")
        for word in (there, back):
            assert wait_until(lambda word=word: is_changed(process, word))  # type: ignore[misc]
        finished = finish(process, tmp_path / "out")
    finally:
        process.kill()
        agent.process.kill()
        agent.process.communicate()
    assert finished.code == 0, finished.errors
    assert balanced(finished.summary)
    lost = {name: finished.edge("", "")[name] for name in ("dropped", "late", "unmatched", "invalid", "lost")}
    assert set(lost.values()) == {0}
    assert [int(line.split(",")[0]) for line in written.read_text().splitlines()] == list(range(1200))
