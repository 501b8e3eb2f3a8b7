"""Graphs whose streams have different rates, and what came of them."""

from __future__ import annotations

from pathlib import Path

from tests.core.worker.solo import Solo

from followspot.graph.compile import compile_graph
from followspot.graph.plan import Plan
from followspot.operator.coordinator import Coordinator
from followspot.operator.launch import local_run
from followspot.operator.reporting.report import RunReport
from followspot.worker.wiring import RunOptions

STAGES = Path(__file__).parents[2] / "stages" / "rates.py"
GRAPH = """
graph: rates
stages:
  camera: {{uses: rates.sensor, with: {{hz: 60, count: {frames}, shift: {shift}}}}}
  sensor: {{uses: rates.sensor, with: {{hz: {hz}, count: {readings}}}}}
  meet:   {{uses: rates.{meet}, in: {{frame: camera, {port}: {feed}}}}}
  save:   {{uses: rates.write, in: {{readings: meet}}}}
"""


def planned(folder: Path, meet: str, more: str = "", **changes: object) -> Plan:
    """The graph with a stage that meets both rates. more: lines of further stages."""
    values = {
        "frames": 60,
        "shift": 0.0041,
        "hz": 1000,
        "readings": 1000,
        "feed": "sensor",
        "port": "reading",
    }
    (folder / "rates.yaml").write_text((GRAPH + more).format(meet=meet, **{**values, **changes}))
    return compile_graph(folder / "rates.yaml", plugin_files=[STAGES])


def run(plan: Plan, folder: Path) -> RunReport:
    report = Solo(plan, folder).run()
    assert report.ok, report.errors
    assert all(edge.balanced for _, edge in report.edges)
    return report


def written(folder: Path) -> list[tuple[int, list[tuple[int, int]]]]:
    """Of each line its time, ns, and the values with their times, ns."""
    found = []
    for line in (folder / "readings.csv").read_text().splitlines():
        time, _, rest = line.partition(":")
        pairs = [(int(value), int(at)) for value, _, at in (word.partition("@") for word in rest.split())]
        found.append((int(time), pairs))
    return found


def counts(report: RunReport, port: str) -> tuple[int, int, int]:
    """Delivered, dropped and unmatched messages of the edge to a port of `meet`."""
    count = next(count for edge, count in report.edges if edge.to_port == port)
    return count.delivered, count.dropped, count.unmatched


def live(folder: Path, stages: str) -> Coordinator:
    (folder / "live.yaml").write_text(f"graph: live\nstages:\n{stages}")
    return local_run(compile_graph(folder / "live.yaml", plugin_files=[STAGES]), RunOptions(folder))
