"""Edges between ports: which output feeds an input, whether the types fit, whether a cycle can start."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from followspot.errors import Mistake, did_you_mean
from followspot.graph.cycles import cycles, cyclic, successors
from followspot.graph.instances import Wire
from followspot.graph.sampling import FlowEdge
from followspot.messages import Message
from followspot.ports.signature import ports
from followspot.ports.specs import InputKind, InputSpec, OutputSpec, Ports, accepts
from followspot.stage import Stage


@dataclass(frozen=True)
class CheckedEdge:
    """A wire with both ports known; kind: of the input that it leads to."""

    wire: Wire
    output: str
    kind: InputKind

    @property
    def sampled(self) -> bool:
        """Whether it leads to a `Latest` and has no delay."""
        return self.kind == "latest" and not self.wire.feed.delay

    @property
    def held(self) -> bool:
        """True if it is delayed or sampled, so that it may close a cycle."""
        return self.sampled or self.wire.feed.delay > 0

    @property
    def flow_edge(self) -> FlowEdge:
        """The edge between the stages of the file."""
        feed, end = self.wire.feed, self.wire.target.declared.name
        return FlowEdge(
            start=feed.stage,
            origin=feed.origin,
            end=end,
            port=self.wire.port,
            delay=feed.delay,
            sampled=self.sampled,
            policy=feed.policy,
            place=feed.place,
        )


def connect(
    wires: Sequence[Wire], classes: Mapping[str, type[Stage]], mistakes: list[Mistake]
) -> list[CheckedEdge]:
    """Both ports of every wire whose stages are known."""
    edges = []
    into: dict[tuple[str, str], list[Wire]] = defaultdict(list)
    given: dict[tuple[str, str], OutputSpec] = {}
    for wire in wires:
        ends = _ends(wire, classes)
        if ends is None:
            continue
        source, port = ends
        into[wire.target.name, port.name].append(wire)
        output = _output(wire, source, port, mistakes)
        _check_settings(wire, port, mistakes)
        if output is not None:
            first = given.setdefault((wire.target.name, port.name), output)
            if port.uniform and first.type is not output.type:
                mistakes.append(_two_types(wire, first, output))
            edges.append(CheckedEdge(wire, output.name, port.kind))
    _check_twice(edges, mistakes)
    for (name, port_name), members in into.items():
        read = ports(classes[name]).input(port_name)
        if read is not None:
            _check_multiplicity(members, read, mistakes)
    return edges


def check_types(wires: Iterable[Wire], classes: Mapping[str, type[Stage]], mistakes: list[Mistake]) -> None:
    """Note each wire whose ends have different types, even if another wire feeds its input."""
    for wire in wires:
        found = _ends(wire, classes)
        if found is not None:
            _output(wire, *found, mistakes)
            _check_settings(wire, found[1], mistakes)


def _ends(wire: Wire, classes: Mapping[str, type[Stage]]) -> tuple[Ports, InputSpec] | None:
    """The ports of the source and the input that a wire leads to; None if one is not known."""
    source, target = classes.get(wire.source.name), classes.get(wire.target.name)
    port = None if target is None else ports(target).input(wire.port)
    return None if source is None or port is None else (ports(source), port)


def _check_twice(edges: Sequence[CheckedEdge], mistakes: list[Mistake]) -> None:
    """A message feeds an input once; with another delay it is another message."""
    seen: dict[tuple[str, str, str, str, int], CheckedEdge] = {}
    for edge in edges:
        wire = edge.wire
        ends = (wire.source.name, edge.output, wire.target.name, wire.port, wire.feed.delay)
        first = seen.setdefault(ends, edge).wire.feed
        if first is not wire.feed:
            text = (
                f'input "{wire.port}" of stage "{wire.target.declared.name}" gets "{wire.feed.origin}" twice'
            )
            same = first.place == wire.feed.place
            place = wire.feed.place if same else wire.feed.place.beside(first.place)
            mistakes.append(Mistake(place, text, "feed it once"))


def _check_settings(wire: Wire, port: InputSpec, mistakes: list[Mistake]) -> None:
    """Note a delay of inputs other than plain and `Latest`, and a tolerance of inputs without matching."""
    feed, end = wire.feed, wire.target.declared.name
    kind = port.kind.capitalize()
    if feed.delay and port.kind in ("nearest", "window"):
        text = (
            f'input "{port.name}" of stage "{end}" is a {kind}, which goes by capture time and has no delay'
        )
        mistakes.append(Mistake(feed.places["delay"], text, f"declare it as Latest[{port.type.__name__}]"))
    if feed.tolerance is not None and (feed.delay or port.kind in ("latest", "window")):
        what = "has a delay" if feed.delay else f"is a {kind}"
        text = f'input "{port.name}" of stage "{end}" {what} and matches no times'
        mistakes.append(Mistake(feed.places["tolerance"], text, "remove the tolerance"))


def _check_multiplicity(members: Sequence[Wire], port: InputSpec, mistakes: list[Mistake]) -> None:
    """Note an input for one message that several edges feed."""
    if port.several or len(members) < 2:
        return
    first = members[0]
    senders = ", ".join(wire.source.name for wire in members[:6]) + (", ..." if len(members) > 6 else "")
    text = (
        f'input "{port.name}" of stage "{first.target.declared.name}" takes one message, {len(members)} come'
    )
    each = first.source.declared.each.set if first.source.declared.each else "cameras"
    remedy = (
        f"from {senders}: give the stage each: {each}, or declare the input as Joined[{port.type.__name__}]"
    )
    mistakes.append(Mistake(first.port_place, text, remedy))


def _two_types(wire: Wire, first: OutputSpec, other: OutputSpec) -> Mistake:
    stage = wire.target.declared.name
    text = f'stage "{stage}" takes messages of one type, {first.type.__name__} and {other.type.__name__} come'
    return Mistake(wire.feed.place, text, "give each type a stage of its own")


def _output(wire: Wire, source: Ports, port: InputSpec, mistakes: list[Mistake]) -> OutputSpec | None:
    """The output that feeds a wire: the named one, else the only one of the right type."""
    name, feed = wire.source.declared.name, wire.feed
    offer = ", ".join(f"{output.name} ({output.type.__name__})" for output in source.outputs)
    fitting = [output for output in source.outputs if accepts(port.type, output.type)]
    wanted = f'input "{port.name}" of stage "{wire.target.declared.name}" takes {port.type.__name__}'
    if not source.outputs:
        mistakes.append(Mistake(feed.place, f'stage "{name}" is a sink and has no outputs', wanted))
    elif feed.port is not None:
        named = source.output(feed.port)
        if named is None:
            guess = did_you_mean(feed.port, [output.name for output in source.outputs], "outputs")
            mistakes.append(Mistake(feed.place, f'stage "{name}" has no output "{feed.port}"', guess))
        elif named not in fitting:
            text = f'"{name}.{named.name}" gives {named.type.__name__}, but {wanted}'
            remedy = _defined_again(named.type, port.type) or f"outputs of {name}: {offer}"
            mistakes.append(Mistake(feed.place, text, remedy))
        return named if named in fitting else None
    elif len(fitting) == 1:
        return fitting[0]
    elif port.type is Message and (same := source.output(wire.port)) is not None:
        return same  # of several, the one with the name that the graph gives the input
    elif len(source.outputs) == 1:
        given = source.outputs[0].type
        text = f'"{name}" gives {given.__name__}, but {wanted}'
        remedy = _defined_again(given, port.type) or f"name a stage that gives {port.type.__name__}"
        mistakes.append(Mistake(feed.place, text, remedy))
    else:
        several = "several outputs" if fitting else "no output"
        text = f'stage "{name}" has {several} of type {port.type.__name__}; {wanted}'
        twins = (_defined_again(output.type, port.type) for output in source.outputs)
        remedy = next(filter(None, twins), "") or f"name the port; outputs: {offer}"
        mistakes.append(Mistake(feed.place, text, remedy))
    return None


def _defined_again(given: type[Message], wanted: type[Message]) -> str:
    """The remedy if a type is not taken although it bears the name of the wanted one; else empty."""
    if given is wanted or given.__name__ != wanted.__name__:
        return ""
    if given.__module__ != wanted.__module__:
        return f"these are two classes of one name, of the modules {given.__module__} and {wanted.__module__}"
    return (
        f"these are two classes of one name, for {wanted.__name__} was defined again: define the stages that"
        " use it again, too; in a notebook, run their cells"
    )


def check_cycles(edges: Sequence[CheckedEdge], mistakes: list[Mistake]) -> None:
    """Every cycle needs a delay or a `Latest`: all other inputs wait for the streams that feed them."""
    plain: dict[tuple[str, str], CheckedEdge] = {}
    for edge in edges:
        if not edge.held:
            plain.setdefault((edge.wire.source.declared.name, edge.wire.target.declared.name), edge)
    names = dict.fromkeys(name for ends in plain for name in ends)
    for cycle in cycles(successors(names, plain)):
        feed = plain[cycle[-2], cycle[-1]].wire.feed
        text = f"the stages {' -> '.join(cycle)} wait for each other"
        mistakes.append(Mistake(feed.place, text, f"delay one edge: {{from: {feed.stage}, delay: 1}}"))


def check_lagged_cycles(
    edges: Sequence[CheckedEdge], classes: Mapping[str, type[Stage]], mistakes: list[Mistake]
) -> None:
    """A stage that lags waits for later inputs: none of these may wait for its output, delayed or not."""
    ends = {(edge.wire.source.name, edge.wire.target.name): edge for edge in edges}
    circular = cyclic(ends)
    lagging = {name for name, stage in classes.items() if ports(stage).gives == "lagged"}
    told: set[str] = set()
    for start, end in ends:
        edge = ends[start, end]
        name = edge.wire.source.declared.name
        if start in lagging and (start, end) in circular and name not in told:
            told.add(name)
            text = f'stage "{name}" lags and would wait for its own output, which "{end}" reads'
            mistakes.append(Mistake(edge.wire.feed.place, text, "feed back what does not lag"))
