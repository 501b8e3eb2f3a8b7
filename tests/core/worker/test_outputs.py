"""What a stage hands out must be what it declares: else its error policy applies, as for an exception."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from followspot import Header, Message, at
from followspot.graph.compile import compile_graph
from followspot.message_checks.outputs import WrongOutput, check_returned, check_yielded
from followspot.messages import InvalidMessage, stamped
from followspot.operator.launch import local_run
from followspot.operator.reporting.report import RunReport
from followspot.plugins.registry import load_stage
from followspot.ports.specs import OutputSpec
from followspot.worker.wiring import RunOptions

WRONG = Path(__file__).parents[2] / "stages" / "wrong.py"
PERIOD = 10_000_000
CHAIN = """
a: {uses: wrong.count}
b: {uses: wrong.pass, in: {note: a}}
c: {uses: wrong.collect, in: {note: b}}
"""
BATCH = """
a: {uses: wrong.count}
b: {uses: wrong.pass, in: {note: a}}
b2: {uses: wrong.pass, in: {note: a}}
c: {uses: wrong.collect, in: {note: b}}
d: {uses: wrong.collect, in: {note: b2}}
"""
FORK = """
a: {uses: wrong.count}
b: {uses: wrong.split, in: {note: a}}
c: {uses: wrong.collect, in: {note: b.left}}
d: {uses: wrong.collect, in: {note: b.right}}
"""
SOURCES = """
a: {uses: wrong.count_both}
c: {uses: wrong.collect, in: {note: a.left}}
d: {uses: wrong.collect, in: {note: a.right}}
"""
LIVE = """
a: {uses: wrong.live, with: {at: 5}}
c: {uses: wrong.collect, in: {note: a}}
"""


def execute(folder: Path, text: str, *overrides: str) -> tuple[RunReport, list[tuple[str, int, int]]]:
    """The report of a run, and what was collected."""
    path = folder / "graph.yaml"
    path.write_text("graph: g\nstages:\n" + "".join(f"  {line}\n" for line in text.strip().splitlines()))
    plan = compile_graph(path, plugin_files=[WRONG], overrides=overrides)
    collected = sys.modules[load_stage("wrong.collect").__module__].Collect.got
    collected.clear()
    report = local_run(plan, RunOptions(folder)).execute()
    return report, sorted(collected)


RETURNED = [
    (CHAIN, "b", "memo", "returned a Memo, declared Note"),
    (CHAIN, "b", "list", "returned a list, declared Note"),
    (CHAIN, "b", "number", "returned an int, declared Note"),
    (CHAIN, "b", "late", "return the message without at()"),
    (CHAIN, "b", "same time", "return the message without at()"),
    (CHAIN, "c", "number", "returned an int, declared None"),
    (CHAIN, "c", "bare", "returned a Note, declared None"),
    (FORK, "b", "left only", "returned a LeftOnly, declared outputs `left`, `right`"),
    (FORK, "b", "bare", "returned a Note, declared outputs `left`, `right`"),
    (FORK, "b", "wrong side", "returned as `right` a Memo, declared Note"),
    (FORK, "b", "timed side", "return the message without at()"),
]
YIELDED = [
    (CHAIN, "a", "memo", "yielded a Memo, declared Note"),
    (CHAIN, "a", "list", "yielded a list, declared Note"),
    (CHAIN, "a", "bare", "write `yield at(time_ns, message)`"),
    (CHAIN, "a", "none", "leave the `yield` out"),
    (SOURCES, "a", "bare", "yielded a Note, declared outputs `left`, `right`"),
    (SOURCES, "a", "sides", "write `yield at(time_ns, message)`"),
    (SOURCES, "a", "two times", "give all of them the same time"),
    (SOURCES, "a", "no sides", "leave the `yield` out"),
    (LIVE, "a", "memo", "yielded a Memo, declared Note"),
    (LIVE, "a", "none", "leave the `yield` out"),
]


@pytest.mark.parametrize(("text", "stage", "wrong", "says"), RETURNED + YIELDED)
def test_a_stage_that_hands_out_something_else_fails_the_run_and_is_named(
    tmp_path: Path, text: str, stage: str, wrong: str, says: str
) -> None:
    report, _ = execute(tmp_path, text, f"{stage}.wrong={wrong}")
    assert not report.ok
    (error,) = report.errors
    at_number = 5 if text is LIVE else 3  # a live source may drop all but its newest
    assert error.startswith(f"stage {stage} failed at a#{at_number}, ")
    assert says in error
    assert "Traceback" not in error


@pytest.mark.parametrize(("text", "stage", "wrong", "says"), RETURNED + YIELDED)
def test_with_policy_skip_it_is_left_out_counted_and_said(
    tmp_path: Path, text: str, stage: str, wrong: str, says: str
) -> None:
    report, got = execute(tmp_path, text, f"{stage}.wrong={wrong}", f"{stage}.on_error=skip")
    assert report.ok
    skipped = {s.stage: s.skipped for worker in report.workers for s in worker.stages}
    assert {name for name, count in skipped.items() if count} == {stage}
    assert any(says in warning for warning in report.warnings)
    if text is not LIVE:
        left_out = [] if stage == "c" else [3]
        assert {value for _, value, _ in got} == set(range(6)) - set(left_out)
    for _, count in report.edges:  # what a device gives counts as produced before anybody looks at it
        assert count.invalid == (1 if text is LIVE else 0)
        assert count.produced == count.delivered + count.dropped + count.invalid


@pytest.mark.parametrize(("text", "stage", "wrong", "says"), [RETURNED[0], YIELDED[0], YIELDED[-2]])
def test_with_policy_restart_it_is_built_anew_until_that_helps_no_more(
    tmp_path: Path, text: str, stage: str, wrong: str, says: str
) -> None:
    report, _ = execute(tmp_path, text, f"{stage}.wrong={wrong}", f"{stage}.on_error=restart")
    restarts = {s.stage: s.restarts for worker in report.workers for s in worker.stages}
    if stage == "a":  # its generator begins anew and comes to the same number again
        assert not report.ok
        assert says in report.errors[0]
    else:
        assert report.ok
        assert restarts[stage] == 1


def test_what_stages_return_together_is_checked_for_each(tmp_path: Path) -> None:
    report, got = execute(
        tmp_path, BATCH, *(f"{b}.{p}" for b in ("b", "b2") for p in ("wrong=late", "on_error=skip"))
    )
    assert report.ok
    skipped = {s.stage: s.skipped for worker in report.workers for s in worker.stages}
    assert (skipped["b"], skipped["b2"]) == (1, 1)
    assert [value for name, value, _ in got if name == "d"] == [0, 1, 2, 4, 5]


def test_a_source_that_yields_not_at_all_is_named(tmp_path: Path) -> None:
    report, _ = execute(tmp_path, CHAIN.replace("wrong.count", "wrong.no_generator"))
    assert not report.ok
    assert report.errors[0].startswith("stage a failed")


@pytest.mark.parametrize("text", [CHAIN, FORK, SOURCES, BATCH])
def test_what_is_declared_goes_through_with_the_time_of_what_fired(tmp_path: Path, text: str) -> None:
    report, got = execute(tmp_path, text)
    assert report.ok, report.errors
    assert not report.warnings
    assert {time - value * PERIOD for _, value, time in got} == {0}


class Note(Message):
    value: int


OUT = (OutputSpec("out", Note),)


def test_messages_that_came_in_and_new_ones_may_be_returned() -> None:
    check_returned(OUT, Note(1))
    check_returned(OUT, stamped(Note(1), Header("a", 0, 5)))


def test_at_on_a_message_that_came_in_is_found_too() -> None:
    with pytest.raises(WrongOutput, match="without at"):
        check_returned(OUT, at(7, stamped(Note(1), Header("a", 0, 5))))


def test_only_a_live_source_leaves_the_time_to_the_runtime() -> None:
    assert check_yielded(OUT, Note(1), live=True).seq == -1
    assert check_yielded(OUT, at(5, Note(1), seq=2), live=True)[1:3] == (2, 5)
    with pytest.raises(WrongOutput, match="capture time"):
        check_yielded(OUT, Note(1), live=False)


@pytest.mark.parametrize("time", [1.5, "5", None])
def test_a_time_that_is_no_whole_number_is_refused_where_it_is_given(time: object) -> None:
    with pytest.raises(TypeError, match=r"round\(seconds"):
        at(time, Note(1))  # type: ignore[arg-type]


@pytest.mark.parametrize("time", [(1 << 62) + 1, -(1 << 62) - 1, 1 << 63, 10**30])
def test_a_time_that_no_edge_can_carry_is_refused_where_it_is_given(time: int) -> None:
    with pytest.raises(InvalidMessage, match="within"):
        at(time, Note(1))
    assert at(time // abs(time) * (1 << 62), Note(1)).header.time
