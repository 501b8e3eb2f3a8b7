"""What a run says of its stages while it runs."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from tests.core.worker.solo import Solo

from followspot.control.dispatch import answer_from_wire, answer_to_wire
from followspot.control.stage_status import StageStatus
from followspot.graph.arrange import EdgeChoice
from followspot.graph.compile import compile_graph
from followspot.messages import Message
from followspot.operator.launch import local_run
from followspot.operator.run_requests import GetStatus
from followspot.worker.reporting.stage_status import Idleness, stages_now
from followspot.worker.wiring import RunOptions

STAGES = Path(__file__).parents[2] / "stages" / "ticks.py"
GRAPH = """\
graph: count
stages:
  count: {uses: ticks.count, with: {count: 30}}
  half:  {uses: ticks.add, in: {number: count}, with: {raise_at: 7}, on_error: skip}
  write: {uses: ticks.write, in: {number: half}}
"""


FEEDBACK = """\
graph: loop
stages:
  count: {uses: ticks.count, with: {count: 30}}
  first: {uses: ticks.accumulate, in: {number: count, before: {from: second, delay: 1}}}
  second: {uses: ticks.add, in: {number: first}}
  write: {uses: ticks.write, in: {number: second}}
"""


def solo(folder: Path, graph: str = GRAPH, edges: EdgeChoice = "auto") -> Solo:
    path = folder / "count.yaml"
    path.write_text(graph)
    return Solo(compile_graph(path, plugin_files=[STAGES], edges=edges), folder)


def stages(run: Solo) -> dict[str, StageStatus]:
    return {stage.stage: stage for stage in stages_now(run.scheduler, run.warnings.last)}


def test_a_stage_says_for_whom_it_waits(tmp_path: Path) -> None:
    found = stages(solo(tmp_path))
    assert found["half"].state == "getting"
    assert found["half"].on == ("count.out -> half.number",)
    assert found["count"].state == "waiting"  # until the worker pulls it


def test_a_stage_says_who_blocks_it(tmp_path: Path) -> None:
    run = solo(tmp_path)
    run.scheduler.setup()
    count, half, _ = run.scheduler.runners
    while count.outputs.has_room():
        run.scheduler.sources.all[0].pull()
    count.blocked = not count.outputs.has_room()
    assert stages(run)["count"].state == "sending"
    assert stages(run)["count"].on == (half.join.members[0].name,)
    run.scheduler.close()


def test_a_stage_says_which_edge_to_another_worker_blocks_it(tmp_path: Path) -> None:
    run = solo(tmp_path, edges="ring")
    run.scheduler.setup()
    count = run.scheduler.runners[0]
    while count.outputs.has_room():
        run.scheduler.sources.all[0].pull()
    count.blocked = not count.outputs.has_room()
    assert (stages(run)["count"].state, stages(run)["count"].on) == ("sending", ("count.out -> half.number",))
    run.scheduler.close()


def test_an_edge_to_another_worker_whose_credit_does_not_come_back_blocks_a_stage(tmp_path: Path) -> None:
    run = solo(tmp_path, edges="ring")
    run.scheduler.setup()
    count = run.scheduler.runners[0]
    count.blocked = True
    assert (stages(run)["count"].state, stages(run)["count"].on) == ("sending", ("count.out -> half.number",))
    run.scheduler.close()


def test_a_stage_says_that_it_waits_for_feedback(tmp_path: Path) -> None:
    run = solo(tmp_path, FEEDBACK)
    run.scheduler.setup()
    first = run.scheduler.runners[1]
    for _ in range(2):
        run.scheduler.sources.all[0].pull()
        first.step()
    assert (stages(run)["first"].state, stages(run)["first"].on) == (
        "getting",
        ("second.out -> first.before",),
    )
    run.scheduler.close()


def test_a_stage_that_is_at_work_says_so_though_nothing_waits_for_it(tmp_path: Path) -> None:
    run = solo(tmp_path)
    run.scheduler.setup()
    half = run.scheduler.runners[1]
    seen: list[str] = []

    def process(number: Message) -> Message:
        seen.append(stages(run)["half"].state)
        return number

    half.stage.process = process
    run.scheduler.sources.all[0].pull()
    half.step()
    assert seen == ["processing"]
    assert stages(run)["half"].state == "getting"
    run.scheduler.close()


def test_a_stage_that_has_all_it_needs_says_at_which_stage_its_worker_is(tmp_path: Path) -> None:
    run = solo(tmp_path)
    run.scheduler.setup()
    count, half, _ = run.scheduler.runners
    seen: list[dict[str, StageStatus]] = []

    numbers = count.stage.process()

    def process() -> Iterator[Message]:
        yield next(numbers)
        seen.append(stages(run))  # the first number has come to half by then, and the worker is here
        yield next(numbers)

    count.stage.process = process
    for _ in range(2):
        run.scheduler.sources.all[0].pull()
    assert seen[0]["count"].state == "processing"
    assert (seen[0]["half"].state, seen[0]["half"].on) == ("waiting", ("count",))
    assert (stages(run)["half"].state, stages(run)["half"].on) == ("waiting", ())
    half.step()
    assert stages(run)["half"].state == "getting"
    run.scheduler.close()


def test_a_live_source_whose_device_gives_nothing_is_getting(tmp_path: Path) -> None:
    run = solo(tmp_path, GRAPH.replace("ticks.count, with: {count: 30}", "ticks.live, with: {count: 0}"))
    assert (stages(run)["count"].state, stages(run)["count"].on) == ("getting", ())


def test_a_stage_says_for_how_long_it_has_not_fired() -> None:
    now = [0.0]
    idleness = Idleness(lambda: now[0])

    def idle(fired: int) -> float:
        (noted,) = idleness.noted([StageStatus("a", "processing", fired=fired)])
        return noted.idle_s

    assert idle(0) == 0.0
    now[0] = 2.5
    assert idle(0) == 2.5
    assert idle(1) == 0.0
    now[0] = 4.0
    assert idle(1) == 1.5


def test_the_status_tells_counts_errors_and_latency(tmp_path: Path) -> None:
    path = tmp_path / "count.yaml"
    path.write_text(GRAPH)
    run = local_run(compile_graph(path, plugin_files=[STAGES]), RunOptions(tmp_path))
    report = run.execute()
    status = answer_from_wire(GetStatus, answer_to_wire(GetStatus, run.status()))  # as observers get it
    found = {stage.stage: stage for stage in status.workers[0].stages}
    assert {stage.state for stage in found.values()} == {"over"}
    assert found["half"].skipped > 0
    assert "half failed" in found["half"].error
    assert list(status.edges(run.plan)) == list(report.edges)
    ages = {age.name: age for stage in found.values() for age in stage.edges}
    assert set(ages) == {edge.name for edge in run.plan.edges}
    assert all(0 < age.p50_ms <= age.p95_ms for age in ages.values() if age.p50_ms and age.p95_ms)
    assert not any(age.p50_ms is None or age.error for age in ages.values())
    assert [(path.origin, path.sink) for path in status.workers[0].paths] == [("count", "write")]
