"""What a run says of its stages while it runs."""

from __future__ import annotations

from pathlib import Path

from followspot.deploy.local import LocalRun
from followspot.deploy.status import run_status_from_data
from followspot.graph.compile import compile_graph
from followspot.runtime.stage_status import StageStatus, paths_now, stages_now
from followspot.runtime.wiring import RunOptions

STAGES = Path(__file__).parents[2] / "stages" / "ticks.py"
GRAPH = """\
graph: count
stages:
  count: {uses: ticks.count, with: {count: 30}}
  half:  {uses: ticks.add, in: {number: count}, with: {raise_at: 7}, on_error: skip}
  write: {uses: ticks.write, in: {number: half}}
"""


def local_run(folder: Path) -> LocalRun:
    path = folder / "count.yaml"
    path.write_text(GRAPH)
    return LocalRun(compile_graph(path, plugin_files=[STAGES]), RunOptions(folder))


def stages(run: LocalRun) -> dict[str, StageStatus]:
    return {stage.stage: stage for stage in stages_now(run.worker, run.warnings.last)}


def test_a_stage_says_for_whom_it_waits(tmp_path: Path) -> None:
    found = stages(local_run(tmp_path))
    assert found["half"].state == "getting"
    assert found["half"].on == ("count.out -> half.number",)
    assert found["count"].state == "processing"


def test_a_stage_says_who_blocks_it(tmp_path: Path) -> None:
    run = local_run(tmp_path)
    run.worker.setup()
    count, half, _ = run.worker.cells
    while count.has_room():
        run.worker.sources[0].pull()
    count.blocked = not count.has_room()
    assert stages(run)["count"].state == "sending"
    assert stages(run)["count"].on == (half.join.members[0].name,)
    run.worker.close()


def test_the_status_tells_counts_errors_and_latency(tmp_path: Path) -> None:
    run = local_run(tmp_path)
    report = run.execute()
    status = run_status_from_data(run.status().to_data())  # as those who look on get it
    found = {stage.stage: stage for stage in status.workers[0].stages}
    assert {stage.state for stage in found.values()} == {"over"}
    assert found["half"].skipped > 0
    assert "half failed" in found["half"].error
    assert list(status.edges(run.plan)) == list(report.edges)
    assert [(path.origin, path.sink) for path in paths_now(run.worker)] == [("count", "write")]
