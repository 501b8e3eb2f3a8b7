"""The steps of swaps and moves on a host: an agent checks each, and hands it to its workers of the run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from followspot.control.move import MoveOrder
from followspot.control.plan_transfer import unpacked_stages
from followspot.control.swap import ChangeOrder
from followspot.errors import FollowspotError
from followspot.graph.change.stages import with_stages
from followspot.graph.plan_data import plan_from_data, plan_to_data
from followspot.host.agent_options import AgentOptions
from followspot.host.agent_run import AgentRun
from followspot.host.agent_runs import AgentRuns


class AgentChanges:
    """Changes the runs of an agent; the order of a run always has the plan that it goes on with.

    log_line: gets lines for the log.
    """

    def __init__(self, options: AgentOptions, runs: AgentRuns, log_line: Callable[[str], None]) -> None:
        self._options = options
        self._runs = runs
        self._log_line = log_line

    def change(self, order: ChangeOrder) -> None:
        """One step of a hot swap of stages on this host. Raises FollowspotError."""
        agent_run = self._runs.agent_run(order.run)
        own = {stage.name for stage in agent_run.run.plan.stages if stage.worker in agent_run.run.workers}
        if foreign := {stage.name for stage in order.stages} - own:
            raise FollowspotError(f"{', '.join(sorted(foreign))} of run {order.run[:8]} does not run here")
        if missing := set(order.workers) - set(agent_run.run.workers):
            text = f"worker {', '.join(sorted(missing))} of run {order.run[:8]} does not run here"
            raise FollowspotError(text)
        if order.plan is not None:
            self._rewire(order, order.plan, agent_run)
            return
        stages = unpacked_stages(order.stages, self._options.grants)
        agent_run.run.ask(order.model_copy(update={"stages": stages}))
        if order.step == "take_over" and not order.workers:
            plan = with_stages(plan_from_data(agent_run.order.plan), order.stages, order.subgraphs)
            agent_run.order = replace(agent_run.order, plan=plan_to_data(plan))
            names = ", ".join(stage.name for stage in order.stages) or "what its sub-graphs offer"
            self._log_line(f"run {order.run[:8]} of {agent_run.graph}: changed {names}")

    def move(self, order: MoveOrder) -> None:
        """One step of a move of stages to or from this host. Raises FollowspotError."""
        agent_run = self._runs.agent_run(order.run)
        if order.plan is None:
            agent_run.run.ask(order)
            return
        plan = self._options.unpacked(order.plan)
        agent_run.run.ask(order.model_copy(update={"plan": plan}))
        if not order.trial:
            agent_run.order = replace(agent_run.order, plan=order.plan)
            self._log_line(f"run {order.run[:8]} of {agent_run.graph}: stages moved")

    def _rewire(self, order: ChangeOrder, data: dict[str, Any], agent_run: AgentRun) -> None:
        """One step of a change in which stages of a worker here come or go. Raises FollowspotError."""
        plan = self._options.unpacked(data)
        agent_run.run.ask(order.model_copy(update={"plan": plan}))
        if order.step == "take_over":
            agent_run.order = replace(agent_run.order, plan=data)
            self._log_line(
                f"run {order.run[:8]} of {agent_run.graph}: another file in the place of a sub-graph"
            )
