"""Where the page looks: a tap beside each stage that sends something to show, in the same worker."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from followspot.graph.plan import Plan, PlannedEdge, PlannedStage
from followspot.plugins.registry import load_stage
from followspot.ports import ports
from followspot_page.views import SHOWN, SMOOTH

TAP = "dashboard.tap"
GROUP = "page"
SMOOTH_RATE = 30.0
"""Tracks and poses shown in a second; they are small, and a target that jumps is hard to follow."""


def with_taps(plan: Plan, folder: Path, rate: float) -> Plan:
    """The plan with a tap for each port of this host that the page can show.

    folder: of the page; rate: pictures in a second.
    """
    near = {worker.name for worker in plan.workers if not worker.host}
    stages, edges = [], []
    for stage in plan.stages:
        found = ports(load_stage(stage.uses))
        for port in found.outputs:
            if stage.worker in near and port.type in SHOWN:
                smooth = SMOOTH_RATE if port.type in SMOOTH else 0.0
                name = f"{GROUP}/{stage.name}.{port.name}"
                params = {
                    "folder": str(folder),
                    "port": f"{stage.name}.{port.name}",
                    "leads": found.source,
                    "rate": rate,
                    "smooth": smooth,
                }
                whole = load_stage(TAP).Params(**params).model_dump(mode="json")
                stages.append(
                    PlannedStage(name, GROUP, TAP, whole, None, stage.worker, live=False, on_error="skip")
                )
                edges.append(PlannedEdge(stage.name, port.name, name, "message", "reference"))
    return replace(plan, stages=(*plan.stages, *stages), edges=(*plan.edges, *edges))


def without_taps(name: str) -> bool:
    """Whether a stage is the user's own, and no tap of the page."""
    return not name.startswith(f"{GROUP}/")
