"""Silent ports of a run: their stages got messages and never gave any, so sinks downstream got nothing."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from followspot.graph.plan import Plan, PlannedEdge, PlannedStage
from followspot.operator.reporting.scored import class_of
from followspot.ports.firing import FIRINGS
from followspot.ports.signature import gives_always, ports
from followspot.ports.specs import Ports
from followspot.worker.ledger import EdgeCount

Counted = tuple[PlannedEdge, EdgeCount]
Port = tuple[str, str]


@dataclass(frozen=True)
class Silence:
    """A port that never gave a message with rows, although all that feeds its stage did.

    stage: as in the graph file; instances: those of it that were silent, empty if all were; after: stages
    that gave it something; got, unused: messages that came to its inputs, and those that no firing used;
    gave: its messages, all of them empty or refused; refused: those that broke their contract; sinks: those
    that got nothing for that reason; advice: what helps.
    """

    stage: str
    uses: str
    port: str
    instances: tuple[str, ...]
    after: tuple[str, ...]
    got: int
    unused: int
    gave: int
    refused: int
    sinks: tuple[str, ...]
    advice: str

    def __str__(self) -> str:
        members = [name.removeprefix(f"{self.stage}/") for name in self.instances]
        of = f" of {', '.join(members)}" if members else ""
        text = f'stage "{self.stage}" ({self.uses}) gave nothing at {self.port}{of}'
        if self.after:
            text += f": {_quoted(self.after)} gave it {self.got + self.unused} messages"
            text += f", of which {self.unused} were late or unmatched" if self.unused else ""
            text += self._given()
        return text + (f". So {_quoted(self.sinks)} got nothing" if self.sinks else "")

    def _given(self) -> str:
        """The fate of the messages that a stage gave."""
        refused = (
            f"; {self.refused} that it gave broke their contract, see the warnings" if self.refused else ""
        )
        if empty := self.gave - self.refused:
            return f"{refused}; all {empty} {'others' if refused else 'that it gave'} were empty"
        return refused or "; it gave none"


def silences(plan: Plan, edges: Sequence[Counted]) -> tuple[Silence, ...]:
    """The silent ports that come first on the ways from sources to sinks, in the order of the plan."""
    found = _Run(plan, edges)
    silent: dict[Port, list[PlannedStage]] = defaultdict(list)
    for stage in plan.stages:
        for port in found.silent_ports(stage.name):
            if found.is_fed(stage.name):
                silent[stage.group, port].append(stage)
    return tuple(found.silence(port, stages) for (_, port), stages in silent.items())


class _Run:
    """The edges of a run by the stages at their ends."""

    def __init__(self, plan: Plan, edges: Sequence[Counted]) -> None:
        self.plan = plan
        self.stages = {stage.name: stage for stage in plan.stages}
        self.classes = {stage.uses: class_of(stage) for stage in plan.stages}
        self.out: Mapping[str, list[Counted]] = defaultdict(list)
        self.firing: Mapping[str, list[Counted]] = defaultdict(list)
        for edge, count in edges:
            if not {edge.from_stage, edge.to_stage} <= self.stages.keys():
                continue  # it left the graph while it ran
            self.out[edge.from_stage].append((edge, count))
            if not edge.delay and self._fires(edge):
                self.firing[edge.to_stage].append((edge, count))

    def _fires(self, edge: PlannedEdge) -> bool:
        found = self._ports(edge.to_stage)
        port = found.input(edge.to_port) if found is not None else None
        return port is not None and port.fires

    def _ports(self, stage: str) -> Ports | None:
        kind = self.classes[self.stages[stage].uses]
        return None if kind is None else ports(kind)

    def silent_ports(self, stage: str) -> Iterator[str]:
        """The ports of a stage on whose edges no message had rows."""
        for port in dict.fromkeys(edge.from_port for edge, _ in self.out[stage]):
            filled = any(count.filled for edge, count in self.out[stage] if edge.from_port == port)
            if port != FIRINGS and not filled:
                yield port

    def is_fed(self, stage: str) -> bool:
        """Whether messages with rows came to every connected input that fires; true of sources.

        Those that were under way when a worker died did not come.
        """
        into = self.firing[stage]
        filled = {edge.to_port for edge, count in into if count.filled and _came(count)}
        return filled == {edge.to_port for edge, _ in into}

    def silence(self, port: str, stages: Sequence[PlannedStage]) -> Silence:
        """The silence of a port of instances of one stage."""
        first = stages[0]
        whole = sum(stage.group == first.group for stage in self.plan.stages) == len(stages)
        into = [counted for stage in stages for counted in self.firing[stage.name]]
        out = [
            counted for stage in stages for counted in self.out[stage.name] if counted[0].from_port == port
        ]
        after = (self.stages[edge.from_stage].group for edge, count in into if count.filled)
        given = {edge.from_stage: count.produced for edge, count in out}
        refused = {edge.from_stage: count.invalid for edge, count in out}
        return Silence(
            stage=first.group,
            uses=first.uses,
            port=port,
            instances=() if whole else tuple(stage.name for stage in stages),
            after=tuple(dict.fromkeys(after)),
            got=sum(count.delivered for _, count in into),
            unused=sum(count.late + count.unmatched for _, count in into),
            gave=sum(given.values()),
            refused=sum(refused.values()),
            sinks=self.starved([(stage.name, port) for stage in stages]),
            advice=self.advice(first.uses, into, bool(sum(given.values()))),
        )

    def starved(self, ports: Sequence[Port]) -> tuple[str, ...]:
        """The sinks behind silent ports that got no message with rows."""
        found: dict[str, None] = {}
        queue = list(ports)
        seen = set(queue)
        for name, port in queue:
            for edge, _ in self.out[name]:
                end = edge.to_stage
                if edge.from_port != port:
                    continue
                if not self.out[end] and not any(count.filled for _, count in self.firing[end]):
                    found[self.stages[end].group] = None
                more = [(end, silent) for silent in self.silent_ports(end) if (end, silent) not in seen]
                seen.update(more)
                queue += more
        return tuple(found)

    def advice(self, uses: str, into: Sequence[Counted], gave: bool) -> str:
        """The advice of the stage's author; without one, where to look.

        into: edges for whose messages it fires; gave: whether it gave messages, empty or refused.
        """
        kind = self.classes[uses]
        if kind is not None and kind.advice:
            return kind.advice
        if not into:
            return "`followspot doctor` looks at every camera"
        fired = any(count.delivered for _, count in into)
        if kind is not None and fired and not gave and gives_always(kind):
            return f"is a `return` missing in {kind.__name__}.process? It declares a message for each firing"
        return f"`followspot echo` shows what it gets, `followspot plugins {uses}` lists its parameters"


def _came(count: EdgeCount) -> int:
    """The messages of an edge that its reader took, whether a firing used them or not."""
    return count.delivered + count.late + count.unmatched


def _quoted(names: Sequence[str]) -> str:
    return ", ".join(f'"{name}"' for name in names)
