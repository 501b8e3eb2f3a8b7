"""Where the page looks: at each port of this machine that sends something to show."""

from __future__ import annotations

from pathlib import Path

from followspot.graph.plan import Plan
from followspot.plugins.registry import load_stage
from followspot.ports import ports
from followspot.runtime.tapping import Tapping
from followspot_page.views import SHOWN, SMOOTH

TAP = "dashboard.tap"
SMOOTH_RATE = 30.0
"""Tracks and poses shown in a second; they are small, and a target that jumps is hard to follow."""


def tappings(plan: Plan, folder: Path, rate: float) -> list[Tapping]:
    """A tap for each port that the page can show. folder: of the page; rate: pictures in a second."""
    near = {worker.name for worker in plan.workers if not worker.host}
    found = []
    for stage in plan.stages:
        its = ports(load_stage(stage.uses))
        for port in its.outputs if stage.worker in near else ():
            if port.type in SHOWN:
                name = f"{stage.name}.{port.name}"
                smooth = SMOOTH_RATE if port.type in SMOOTH else 0.0
                params = {"folder": str(folder), "port": name, "rate": rate}
                found.append(Tapping(name, TAP, {**params, "leads": its.source, "smooth": smooth}))
    return found
