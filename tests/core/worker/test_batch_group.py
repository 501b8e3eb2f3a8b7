"""Stages that are alike work together, and nothing but the cost shows it."""

from __future__ import annotations

import sys
import threading
from pathlib import Path
from types import ModuleType

import pytest
from tests.core.worker.solo import Solo

from followspot.graph.compile import compile_graph
from followspot.operator.reporting.report import RunReport
from followspot.plugins.registry import load_stage

ALIKE = Path(__file__).parents[2] / "stages" / "alike.py"
THREE = """
a: {uses: alike.count, with: {count: 10}}
b: {uses: alike.count, with: {count: 10, skip: 4}}
c: {uses: alike.count, with: {count: 7}}
x: {uses: alike.double, in: {note: a, before: {from: x, delay: 1}}}
y: {uses: alike.double, in: {note: b, before: {from: y, delay: 1}}}
z: {uses: alike.double, in: {note: c, before: {from: z, delay: 1}}}
p: {uses: alike.collect, in: {note: x}}
q: {uses: alike.collect, in: {note: y}}
r: {uses: alike.collect, in: {note: z}}
"""
EXPECTED = sorted(
    [("p", n, 2 * n) for n in range(10)]
    + [("q", n, 2 * n) for n in range(10) if n != 4]
    + [("r", n, 2 * n) for n in range(7)]
)


def stages(folder: Path, text: str, *overrides: str) -> tuple[Solo, ModuleType]:
    """A run of a graph of these stages that has not begun, and their module."""
    path = folder / "graph.yaml"
    path.write_text("graph: g\nstages:\n" + "".join(f"  {line}\n" for line in text.strip().splitlines()))
    plan = compile_graph(path, plugin_files=[ALIKE], overrides=overrides)
    module = sys.modules[load_stage("alike.double").__module__]
    module.Double.sizes.clear()
    module.Collect.got.clear()
    module.Heard.spoken = threading.Event()
    return Solo(plan, folder), module


def execute(
    folder: Path, text: str, *overrides: str
) -> tuple[RunReport, list[int], list[tuple[str, int, int]]]:
    """The report of a run, how many stages worked together each time, and what was collected."""
    run, module = stages(folder, text, *overrides)
    return run.run(), module.Double.sizes, sorted(module.Collect.got)


def fired(report: RunReport) -> dict[str, int]:
    return {s.stage: s.fired for worker in report.workers for s in worker.stages}


def test_stages_that_are_alike_work_together_and_give_what_each_gives_alone(tmp_path: Path) -> None:
    report, sizes, got = execute(tmp_path, THREE)
    assert got == EXPECTED
    assert sizes[:4] == [3, 3, 3, 3]
    assert sizes[-3:] == [2, 2, 2], "one stream has ended, the others go on together"
    assert sum(sizes) >= 10 + 9 + 7 - 2, "at most the gap is bridged alone"
    assert report.ok
    assert [fired(report)[name] for name in "xyz"] == [10, 9, 7]
    assert 0 < sum(stage.busy_ms for worker in report.workers for stage in worker.stages) < 60_000


def test_stages_with_other_parameters_work_alone(tmp_path: Path) -> None:
    report, sizes, got = execute(tmp_path, THREE, "x.at=5", "y.at=6")
    assert (sizes, got, report.ok) == ([], EXPECTED, True)


def test_a_stage_that_feeds_one_like_it_does_not_wait_for_it(tmp_path: Path) -> None:
    chain = """
a: {uses: alike.count, with: {count: 20}}
x: {uses: alike.double, in: {note: a}}
y: {uses: alike.double, in: {note: x}}
p: {uses: alike.collect, in: {note: y}}
"""
    report, _, got = execute(tmp_path, chain)
    assert report.ok
    assert got == [("p", n, 4 * n) for n in range(20)]


def test_the_guilty_one_is_named(tmp_path: Path) -> None:
    report, _, _ = execute(tmp_path, THREE, "x.fault=y", "y.fault=y", "z.fault=y")
    assert len(report.errors) == 1
    assert "stage y failed at b#3" in report.errors[0]
    assert "cannot double 3" in report.errors[0]


def test_only_the_guilty_one_loses_its_message(tmp_path: Path) -> None:
    faulty = THREE.replace("delay: 1}}}", "delay: 1}}, on_error: skip}")
    report, _, got = execute(tmp_path, faulty, "x.fault=y", "y.fault=y", "z.fault=y")
    assert got == [row for row in EXPECTED if row[:2] != ("q", 3)]
    assert {s.stage: s.skipped for s in report.workers[0].stages if s.skipped} == {"y": 1}
    assert report.ok


@pytest.mark.parametrize(
    ("fault", "reason"), [("together", "together we are lost"), ("few", "returned 2 outputs for 3 stages")]
)
def test_what_fails_only_together_is_done_alone_and_told(tmp_path: Path, fault: str, reason: str) -> None:
    report, _, got = execute(tmp_path, THREE, f"x.fault={fault}", f"y.fault={fault}", f"z.fault={fault}")
    assert got == EXPECTED
    assert report.ok
    assert any(reason in warning for warning in report.warnings)


def test_the_time_spent_together_is_shared(tmp_path: Path) -> None:
    report, _, _ = execute(tmp_path, THREE)
    busy = {s.stage: s.busy_ms for s in report.workers[0].stages}
    assert min(busy[name] for name in "xyz") > 0


def test_a_silent_camera_is_not_waited_for(tmp_path: Path) -> None:
    live = """
a: {uses: alike.early}
b: {uses: alike.silent}
x: {uses: alike.double, in: {note: a}}
y: {uses: alike.double, in: {note: b}}
h: {uses: alike.heard, in: {note: x}}
p: {uses: alike.collect, in: {note: h}}
q: {uses: alike.collect, in: {note: y}}
"""
    report, _, got = execute(tmp_path, live)
    assert report.ok
    assert got == [("p", 0, 2), ("q", 1, 4)]
