"""A worker starts, and starts again after a fault, as soon as what every stage needs is imported."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from tests.integration.running import wait_until

from followspot.control.lifecycle import StopRun
from followspot.control.worker_messages import Built, Log
from followspot.control.worker_orders import BuildWorker
from followspot.graph.compile import compile_graph
from followspot.graph.plan_data import plan_to_data
from followspot.host.worker_process import WorkerProcess
from followspot.host.worker_thread import WorkerThread
from followspot.transport.zenoh.network import Network

TICKS = Path(__file__).parents[2] / "stages" / "ticks.py"
PAIR = """
graph: pair
stages:
  a: {uses: ticks.count}
  b: {uses: ticks.write, in: {number: a}}
"""
NEEDLESS = ("asyncio", "cryptography", "cv2", "mcap", "packaging", "pluggy", "zenoh")


def test_a_worker_imports_nothing_that_only_some_stages_or_edges_need() -> None:
    program = (
        "import sys, followspot.worker.main; from followspot.plugins.catalogue import catalogue; catalogue();"
        f"print([name for name in {NEEDLESS!r} if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


def test_a_worker_that_looks_for_the_others_ends_when_the_run_is_stopped(tmp_path: Path) -> None:
    """They may have ended already: on their host the stop arrived first."""
    (tmp_path / "pair.yaml").write_text(PAIR)
    plan = compile_graph(tmp_path / "pair.yaml", placement="stage", plugin_files=[TICKS], edges="zenoh")
    built: list[Built] = []
    worker = WorkerProcess("b", 0, WorkerThread, {Built: built.append, Log: lambda _: None})
    order = BuildWorker(
        worker="b",
        plan=plan_to_data(plan),
        out=str(tmp_path),
        frames=None,
        run="run",
        network=Network(),
        incarnation=0,
        restart=False,
        over=(),
        states={},
        clock=(0, 0, 0),
    )
    memory = os.memfd_create("ledger")
    os.truncate(memory, 1 << 16)
    worker.channel.send(order, (memory,))
    while not built:
        worker.receive()
    worker.channel.send(StopRun())
    assert wait_until(lambda: worker.process.poll() is not None)
    while worker.report is None:
        worker.receive()
    worker.end()
    os.close(memory)
    assert (worker.report.error, worker.phase) == ("", "starting")
