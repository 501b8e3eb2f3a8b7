"""Settings that follow from the plan alone, so that all workers have the same: types of ports, windows and
deadlines of joins, allowed lateness.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from followspot.errors import InputError
from followspot.frame_times import to_ns
from followspot.graph.cycles import cyclic
from followspot.graph.plan import Plan, PlannedEdge, PlannedStage
from followspot.graph.sampling import plan_sampled_cycles
from followspot.messages import Message
from followspot.plugins.registry import load_stage
from followspot.ports.signature import ports
from followspot.ports.specs import InputSpec, Ports
from followspot.stage import Stage
from followspot.transport.token import END
from followspot.worker.clock import Clock

_ANY_LAG = 3 * END
"""Lag, ns, of a stage whose lag is unknown: longer than any two times are apart."""


@dataclass(frozen=True)
class RunOptions:
    """Options of a run that are not part of the graph.

    out: folder for outputs; frames: of each camera, None for all; warn: gets stage name and text;
    rejoin: whether workers that die are started again, while live joins go on without them and others wait;
    clock: of this host; resumed: whether the worker's stages have worked in this run before.
    """

    out: Path = Path()
    frames: int | None = None
    warn: Callable[[str, str], None] = lambda stage, text: None
    rejoin: bool = False
    clock: Clock = field(default_factory=Clock)
    resumed: bool = False


class Wiring:
    """The types, windows, deadlines and allowed lateness of a plan, equal in all its workers."""

    def __init__(self, plan: Plan) -> None:
        """Raises InputError if the plan is a replay whose result would depend on timing."""
        if not plan.live and (mistakes := plan_sampled_cycles(plan)):
            raise InputError(mistakes)
        self.plan = plan
        self.stages = {stage.name: stage for stage in plan.stages}
        self.groups = {stage.name: stage.group for stage in plan.stages}
        self.classes: dict[str, type[Stage]] = {s.name: load_stage(s.uses) for s in plan.stages}
        self.ports: dict[str, Ports] = {name: ports(cls) for name, cls in self.classes.items()}
        self.live = plan.live
        self.into: dict[str, list[int]] = defaultdict(list)
        self.out_of: dict[str, list[int]] = defaultdict(list)
        for number, edge in plan.numbered():
            self.into[edge.to_stage].append(number)
            self.out_of[edge.from_stage].append(number)
        self._circular = cyclic([(edge.from_stage, edge.to_stage) for edge in plan.edges])
        self.closing, self.lateness = self._latenesses()
        self.lag = self._lag()
        self.deadline = self._deadlines()

    def limits(self, stage: PlannedStage) -> Mapping[str, int]:
        """Budgets, ns, of the paths that end at a stage, by their origin."""
        return {b.origin: to_ns(b.limit) for b in self.plan.budgets if b.end == stage.group}

    def message_type(self, edge: PlannedEdge) -> type[Message]:
        """Type of the messages on an edge: what its sender declares."""
        port = self.ports[edge.from_stage].output(edge.from_port)
        assert port is not None, f"{edge.name} comes from nowhere"
        return port.type

    def received_types(self, stage: str) -> tuple[type[Message], ...]:
        """Types of the messages on the edges that lead to a stage, each once."""
        return tuple(dict.fromkeys(self.message_type(self.plan.edge(n)) for n in self.into[stage]))

    def input_port(self, edge: PlannedEdge) -> InputSpec:
        """The declaration of the port that an edge leads to."""
        port = self.ports[edge.to_stage].input(edge.to_port)
        assert port is not None, f"{edge.name} leads nowhere"
        return port

    def sampled(self, edge: PlannedEdge) -> bool:
        """Whether the edge is a sampled input, which never fires."""
        return edge.delay > 0 or not self.input_port(edge).fires

    def tolerance(self, edge: PlannedEdge) -> int:
        """Largest difference in capture time between a message of the edge and its matches, ns."""
        own = self.stages[edge.to_stage].tolerance if edge.tolerance is None else edge.tolerance
        return to_ns(own)

    def circular(self, edge: PlannedEdge) -> bool:
        """Whether the edge is part of a cycle, feedback included."""
        return (edge.from_stage, edge.to_stage) in self._circular

    def timed(self, edge: PlannedEdge) -> bool:
        """Whether a sampled input goes by capture time; a `Latest` of a live run goes by arrival."""
        return edge.delay > 0 or not self.live

    def window(self, stage: PlannedStage) -> int:
        """Largest difference in capture time within the stage's join, ns; 0 for a single input."""
        edges = [self.plan.edge(n) for n in self.into[stage.name]]
        members = [self.tolerance(edge) for edge in edges if not self.sampled(edge)]
        return max(members) if len(members) > 1 else 0

    def waits(self, stage: str) -> tuple[int, int, float]:
        """How long a stage does not fire after a firing, ns; how long nothing comes after a message, ns; its
        deadline, s.
        """
        return self.closing[stage], self.lateness[stage], self.deadline[stage]

    def _latenesses(self) -> tuple[dict[str, int], dict[str, int]]:
        """For each stage the time, ns, for which it does not fire after a firing, and that for which nothing
        comes after a message: the same, but 0 for a stage that gives several messages for a firing, or lags.

        A join fires at the earliest time of its members and discards what comes later within its window. A
        feedback edge is therefore certain as soon as its message is there.
        """
        closing: dict[str, int] = {}
        lateness: dict[str, int] = {}
        for stage in self.plan.stages:
            edges = [self.plan.edge(n) for n in self.into[stage.name]]
            inherited = [lateness[e.from_stage] for e in edges if not self.sampled(e)]
            closing[stage.name] = self.window(stage) + max(inherited, default=0)
            timed = self.ports[stage.name].gives in ("several", "lagged")
            lateness[stage.name] = 0 if timed else closing[stage.name]
        return closing, lateness

    def _lag(self) -> int:
        """Longest time, ns, by which the watermark of a port can trail that of the sources upstream.

        A join of several members looks ahead by twice its window, for the nearest may lie on either side of
        another's first message; a `Nearest` looks ahead by its tolerance. How much a lagging stage lags is
        unknown: only their sources hold up the others, and these are upstream of it, too.
        """
        lag: dict[str, int] = {}
        for stage in self.plan.stages:
            edges = [edge for n in self.into[stage.name] if not (edge := self.plan.edge(n)).delay]
            near = [self.tolerance(edge) for edge in edges if self.input_port(edge).kind == "nearest"]
            lagging = _ANY_LAG if self.ports[stage.name].gives == "lagged" else 0
            ahead = max(2 * self.window(stage), *near, lagging)
            lag[stage.name] = ahead + max((lag.get(edge.from_stage, 0) for edge in edges), default=0)
        return max(lag.values(), default=0)

    def _deadlines(self) -> dict[str, float]:
        """Deadline of each stage, s from a message's entering the graph until it fires without the missing.

        A join adds its own deadline to those of the joins upstream: else their outputs would come too late.
        So does a stage with a `Nearest` or a `Window`, which it waits for, too.
        """
        deadline: dict[str, float] = {}
        for stage in self.plan.stages:
            edges = [self.plan.edge(n) for n in self.into[stage.name]]
            awaited = [deadline[e.from_stage] for e in edges if self._awaited(e)]
            own = stage.deadline if len(awaited) > 1 else 0.0
            deadline[stage.name] = own + max(awaited, default=0.0)
        return deadline

    def _awaited(self, edge: PlannedEdge) -> bool:
        """Whether a live stage waits for messages of the edge."""
        return not edge.delay and self.input_port(edge).kind != "latest"
