"""The order for a new run, which every host gets."""

from __future__ import annotations

import uuid

from followspot.control.host import RunOrder
from followspot.graph.plan import Plan
from followspot.graph.plan_data import plan_to_data
from followspot.host.clocks.host import reference
from followspot.worker.wiring import RunOptions


def new_order(plan: Plan, options: RunOptions, *, restart: bool, detached: bool = False) -> RunOrder:
    """A new order for a plan. restart: whether hosts restart workers that die; detached: see `RunOrder`."""
    out = str(options.out.resolve())
    shipped, by = plan_to_data(plan), reference(plan)
    return RunOrder(uuid.uuid4().hex, shipped, options.frames, out, restart, detached, reference=by)
