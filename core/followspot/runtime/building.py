"""From a plan to the cells of one worker: which queue feeds which stage."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from itertools import groupby
from typing import Protocol

import numpy as np

from followspot.belonging import misfit
from followspot.graph.plan import AHEAD, EdgeKind, PlannedEdge, PlannedStage
from followspot.messages import Array, Message, seal
from followspot.ports import InputPort as PortSpec
from followspot.runtime.cell import Cell
from followspot.runtime.firing import InputPort, Join
from followspot.runtime.inlet import UNCHANGED, HeldInlet, Inlet
from followspot.runtime.ledger import LOST, Ledger
from followspot.runtime.outlet import Outlet
from followspot.runtime.pace import Pace
from followspot.runtime.source import LiveCell, SourceCell
from followspot.runtime.wiring import RunOptions, Wiring
from followspot.runtime.worker import Worker
from followspot.stage import Context
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
        self.pace = Pace()

    def build(self) -> Worker:
        """Inlets first, then the cells that join them, then the calls that wake them."""
        for stage in self.mine:
            for number in self.wiring.into[stage.name]:
                self.inlets[number] = self._inlet(number)
        for rank, stage in enumerate(self.mine):
            self.cells.append(self._cell(rank, stage))
        remote = [inlet for inlet in self.inlets.values() if inlet.reader is not None]
        worker = Worker(self.cells, remote, self.writers, self.pace)
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
            kind = self.wiring.message_type(edge)
            inlet.reader = self.links.reader(number, kind)
            inlet.unfit = misfit(kind, self.plan.room, self.wiring.stages[edge.from_stage].camera)
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
            pause=self.pace.wait_aside if stage.live else self.pace.wait,
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
            for number in numbers:
                self._bury(number)
            outlet.connect([self.inlets[n] for n in numbers])
            return
        writer = self.links.writer(numbers, kind)
        names = [self.plan.edges[n].name for n in numbers]
        outlet.attach(writer, names, [self.ledger.row(n) for n in numbers])
        self.writers.append((writer, rank))

    def _bury(self, number: int) -> None:
        """What was under way within a worker when it died is lost."""
        self.words[self.ledger.row(number) + LOST] += self.ledger.count(number).in_flight

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
