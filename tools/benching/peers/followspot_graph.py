"""The tracker as it is: its graph, with pictures from memory and a sink that notes tracks."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

from benching.peers.parts import Order, read_order
from followspot.graph.compile import compile_graph
from followspot.operator.launch import run_plan
from followspot.plugins.registry import use_plugin_files
from followspot.worker.wiring import RunOptions

STAGES = Path(__file__).with_name("peer_stages.py")


def run(order: Order, placement: str | None) -> None:
    """Run the graph; placement: of its stages, None for one process."""
    use_plugin_files([str(STAGES)])
    plan = compile_graph(order.graph, room=order.room, placement=placement, plugin_files=[str(STAGES)])
    params = {"order": str(order.written())}
    uses = {"camera": "peer_stages.played", "save": "peer_stages.noted"}
    stages = [replace(s, uses=uses[s.group], params=params) if s.group in uses else s for s in plan.stages]
    report = run_plan(replace(plan, stages=tuple(stages)), RunOptions(order.path("out")))
    if not report.ok:
        raise SystemExit("\n".join(report.errors))


if __name__ == "__main__":
    run(read_order(sys.argv[1]), sys.argv[2] if len(sys.argv) > 2 else None)
