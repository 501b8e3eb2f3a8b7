"""From a plan to the cells of one worker: which queue feeds which stage, and what may be promised when."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import groupby
from pathlib import Path
from typing import Protocol

import numpy as np

from followspot.graph.plan import AHEAD, EdgeKind, Plan, PlannedEdge, PlannedStage
from followspot.messages import Array, Message, seal
from followspot.plugins.registry import load_stage
from followspot.ports import InputPort as PortSpec
from followspot.ports import Ports, ports
from followspot.runtime.cell import Cell
from followspot.runtime.clock import Clock
from followspot.runtime.firing import InputPort, Join
from followspot.runtime.inlet import UNCHANGED, HeldInlet, Inlet
from followspot.runtime.ledger import Ledger
from followspot.runtime.outlet import Outlet
from followspot.runtime.source import LiveCell, SourceCell
from followspot.runtime.worker import Worker
from followspot.stage import Context, Stage
from followspot.transport.edge import PortReader, PortWriter
from followspot.transport.token import ABSENT

_ENDLESS = 1 << 30
"""Depth of an edge that is never full, for it drops."""


class Links(Protocol):
    """Makes the ends of edges that are not plain references; edges are named by their number in the plan."""

    def reader(self, edge: int, kind: type[Message]) -> PortReader:
        """The reading end of one edge."""

    def writer(self, edges: Sequence[int], kind: EdgeKind) -> PortWriter:
        """The writing end of all edges of one output port that have the same kind and codec."""


class NoLinks:
    """For plans in which every edge is a reference."""

    def reader(self, edge: int, kind: type[Message]) -> PortReader:
        """There is none. Raises LookupError."""
        raise LookupError(f"edge {edge} ({kind.__name__}) has no link")

    def writer(self, edges: Sequence[int], kind: EdgeKind) -> PortWriter:
        """There is none. Raises LookupError."""
        raise LookupError(f"edges {edges} ({kind}) have no link")


@dataclass(frozen=True)
class RunOptions:
    """What the user said about this run and not about the graph.

    out: folder for outputs; frames: messages per source, None for all; warn: stage name and text;
    rejoin: whether workers that die are started again: live joins then go on without them, others wait;
    clock: of this host.
    """

    out: Path = Path()
    frames: int | None = None
    warn: Callable[[str, str], None] = lambda stage, text: None
    rejoin: bool = False
    clock: Clock = field(default_factory=Clock)


class Wiring:
    """What the workers of a plan agree on: port types, windows, which held inputs are sampled by time."""

    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        self.stages = {stage.name: stage for stage in plan.stages}
        self.classes: dict[str, type[Stage]] = {s.name: load_stage(s.uses) for s in plan.stages}
        self.ports: dict[str, Ports] = {name: ports(cls) for name, cls in self.classes.items()}
        self.live = plan.live
        self.into: dict[str, list[int]] = defaultdict(list)
        self.out_of: dict[str, list[int]] = defaultdict(list)
        for number, edge in enumerate(plan.edges):
            self.into[edge.to_stage].append(number)
            self.out_of[edge.from_stage].append(number)
        self.slack = self._slacks()
        self.deadline = self._deadlines()

    def message_type(self, edge: PlannedEdge) -> type[Message]:
        """Type of the messages on an edge: what its sender declares."""
        outputs = {port.name: port.type for port in self.ports[edge.from_stage].outputs}
        return outputs[edge.from_port]

    def input_port(self, edge: PlannedEdge) -> PortSpec:
        """The declaration of the port that an edge leads to."""
        return next(port for port in self.ports[edge.to_stage].inputs if port.name == edge.to_port)

    def held(self, edge: PlannedEdge) -> bool:
        """Whether the edge is sampled at a firing instead of firing itself."""
        return edge.delay > 0 or self.input_port(edge).kind == "latest"

    def timed(self, edge: PlannedEdge) -> bool:
        """Whether a held edge is sampled by capture time; `Latest` is not where it is live or fed back."""
        return edge.delay > 0 or not (self.live or edge.from_stage in self._reachable(edge.to_stage))

    def window(self, stage: PlannedStage) -> int:
        """Largest difference in capture time within the stage's join, ns; 0 for a single input."""
        members = [n for n in self.into[stage.name] if not self.held(self.plan.edges[n])]
        return round(stage.tolerance * 1e9) if len(members) > 1 else 0

    def _slacks(self) -> dict[str, int]:
        """For each stage, ns after a message's time for which the message promises that nothing else comes.

        A join takes the earliest time of its members as its own and gives up what comes within its window
        later; that lets a feedback edge be certain as soon as its message is there.
        """
        slack: dict[str, int] = {}
        for stage in self.plan.stages:
            edges = [self.plan.edges[n] for n in self.into[stage.name]]
            inherited = [slack[e.from_stage] for e in edges if not self.held(e)]
            slack[stage.name] = self.window(stage) + max(inherited, default=0)
        return slack

    def _deadlines(self) -> dict[str, float]:
        """For each stage, s from a message's entering the graph until those still missing are given up.

        A join waits on top of what joins upstream of it wait: else what they make of the rest comes too late.
        """
        deadline: dict[str, float] = {}
        for stage in self.plan.stages:
            edges = [self.plan.edges[n] for n in self.into[stage.name]]
            members = [deadline[e.from_stage] for e in edges if not self.held(e)]
            own = stage.deadline if len(members) > 1 else 0.0
            deadline[stage.name] = own + max(members, default=0.0)
        return deadline

    def _reachable(self, start: str) -> set[str]:
        """Stages downstream of one, itself included."""
        seen, queue = {start}, [start]
        while queue:
            for number in self.out_of[queue.pop()]:
                target = self.plan.edges[number].to_stage
                if target not in seen:
                    seen.add(target)
                    queue.append(target)
        return seen


def build_worker(
    wiring: Wiring, name: str, ledger: Ledger, options: RunOptions, links: Links | None = None
) -> Worker:
    """The worker of that name with all its stages built, none of them set up."""
    return _Builder(wiring, name, ledger, options, links or NoLinks()).build()


class _Builder:
    """Collects the parts of one worker while its stages are built in order."""

    def __init__(self, wiring: Wiring, name: str, ledger: Ledger, options: RunOptions, links: Links) -> None:
        self.wiring = wiring
        self.plan = wiring.plan
        self.words = ledger.words
        self.ledger = ledger
        self.options = options
        self.links = links
        self.mine = [stage for stage in self.plan.stages if stage.worker == name]
        self.names = {stage.name for stage in self.mine}
        self.inlets: dict[int, Inlet] = {}
        self.writers: list[tuple[PortWriter, int]] = []
        self.cells: list[Cell] = []

    def build(self) -> Worker:
        """Inlets first, then the cells that join them, then the calls that wake them."""
        for stage in self.mine:
            for number in self.wiring.into[stage.name]:
                self.inlets[number] = self._inlet(number)
        for rank, stage in enumerate(self.mine):
            self.cells.append(self._cell(rank, stage))
        remote = [inlet for inlet in self.inlets.values() if inlet.reader is not None]
        worker = Worker(self.cells, remote, self.writers)
        ranks = {stage.name: rank for rank, stage in enumerate(self.mine)}
        for number, inlet in self.inlets.items():
            edge = self.plan.edges[number]
            inlet.wake = partial(worker.mark, ranks[edge.to_stage])
            if edge.kind == "reference":
                inlet.reopened = partial(worker.mark, ranks[edge.from_stage])
        for cell in self.cells:
            for held in cell.join.held:
                wake = partial(worker.mark_waiting, cell)
                held.inlet.wake = wake if held.inlet.keep is None else partial(_shed, held.inlet, wake)
        return worker

    def _inlet(self, number: int) -> Inlet:
        edge = self.plan.edges[number]
        slack = self.wiring.slack[edge.from_stage]
        depth, keep = self._limits(edge)
        inlet = Inlet(edge.name, self.words, self.ledger.row(number), depth=depth, slack=slack, keep=keep)
        if edge.kind != "reference":
            inlet.reader = self.links.reader(number, self.wiring.message_type(edge))
            if self.options.rejoin:
                inlet.after_loss = ABSENT if self.wiring.live else UNCHANGED
        return inlet

    def _limits(self, edge: PlannedEdge) -> tuple[int, int | None]:
        """Messages with which an edge is full for its sender, and beyond which its oldest goes, if ever.

        What a live stage only samples does not wait for it to fire: else a camera that falls silent, or comes
        back after a while, would hold up those whose results it samples, and they what it waits for.
        """
        if self.wiring.live and edge.drops:
            return _ENDLESS, edge.depth
        if self.wiring.live and self.wiring.held(edge):
            return edge.room, max(edge.room - AHEAD, edge.delay + 1)
        return edge.room, None

    def _cell(self, rank: int, stage: PlannedStage) -> Cell:
        outlets = self._outlets(rank, stage)
        warn = partial(self.options.warn, stage.name)
        for outlet in outlets.values():
            outlet.refused = warn
            outlet.patient = self.options.rejoin and not self.wiring.live
        context = Context(
            name=stage.name,
            room=self.plan.room,
            camera=self.plan.room.cameras[stage.camera] if stage.camera else None,
            out=self.options.out,
            seed=self.plan.seed,
            warn=warn,
            loan=partial(_loan, tuple(outlets.values())),
        )
        build = partial(self.wiring.classes[stage.name], context, **stage.params)
        if self.wiring.ports[stage.name].source:
            kind = LiveCell if stage.live else SourceCell
            source = kind(
                stage.name,
                rank,
                build,
                Join((), window=0, slack=0),
                outlets,
                on_error=stage.on_error,
                clock=self.options.clock,
            )
            source.limit = self.options.frames
            return source
        deadline = self.wiring.deadline[stage.name] if self.wiring.live else None
        return Cell(
            stage.name,
            rank,
            build,
            self._join(stage),
            outlets,
            on_error=stage.on_error,
            deadline=deadline,
            clock=self.options.clock,
        )

    def _outlets(self, rank: int, stage: PlannedStage) -> dict[str, Outlet]:
        outlets = {}
        for port in self.wiring.ports[stage.name].outputs:
            outlet = Outlet(port.type, self.words, slack=self.wiring.slack[stage.name])
            numbers = [n for n in self.wiring.out_of[stage.name] if self.plan.edges[n].from_port == port.name]
            for _, group in groupby(sorted(numbers, key=self._way), key=self._way):
                self._attach(outlet, list(group), rank)
            outlets[port.name] = outlet
        return outlets

    def _attach(self, outlet: Outlet, numbers: list[int], rank: int) -> None:
        kind = self.plan.edges[numbers[0]].kind
        if kind == "reference":
            outlet.inlets += [self.inlets[n] for n in numbers]
            return
        writer = self.links.writer(numbers, kind)
        names = [self.plan.edges[n].name for n in numbers]
        outlet.attach(writer, names, [self.ledger.row(n) for n in numbers])
        self.writers.append((writer, rank))

    def _join(self, stage: PlannedStage) -> Join:
        by_port: Mapping[str, list[int]] = defaultdict(list)
        for number in self.wiring.into[stage.name]:
            by_port[self.plan.edges[number].to_port].append(number)
        input_ports = [self._input(port, by_port[port.name]) for port in self.wiring.ports[stage.name].inputs]
        slack = self.wiring.slack[stage.name]
        return Join(input_ports, window=self.wiring.window(stage), slack=slack)

    def _input(self, port: PortSpec, numbers: Iterable[int]) -> InputPort:
        numbers = list(numbers)
        if numbers and self.wiring.held(self.plan.edges[numbers[0]]):
            edge = self.plan.edges[numbers[0]]
            initial = seal(self.wiring.message_type(edge).empty()) if edge.delay else None
            timed = self.wiring.timed(edge)
            held = HeldInlet(self.inlets[numbers[0]], delay=edge.delay, timed=timed, initial=initial)
            return InputPort(port.name, joined=False, held=held)
        members = tuple(self.inlets[n] for n in numbers)
        return InputPort(port.name, joined=port.kind == "joined", members=members)

    def _way(self, number: int) -> str:
        """What edges must have in common to share a writer; one that drops has its own."""
        edge = self.plan.edges[number]
        return f"{edge.way}, {number}" if edge.drops and edge.kind != "reference" else edge.way


def _shed(inlet: Inlet, wake: Callable[[], None]) -> None:
    """What comes to an input that is only sampled takes the place of what is too old."""
    inlet.shed()
    wake()


def _loan(outlets: Sequence[Outlet], shape: tuple[int, ...], dtype: str) -> Array:
    """An output array in shared memory where an edge offers it, else in private memory."""
    for outlet in outlets:
        array = outlet.loan(shape, dtype)
        if array is not None:
            return array
    return np.empty(shape, dtype)
