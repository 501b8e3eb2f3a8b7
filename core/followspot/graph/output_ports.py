"""The output ports of a plan, and which of them a word such as `camera` or `track.tracks` names."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from types import MappingProxyType

from followspot.errors import InputError, Mistake, did_you_mean
from followspot.graph.names import enclosing
from followspot.graph.plan import Plan
from followspot.messages import Message
from followspot.plugins.registry import load_stage
from followspot.ports.signature import ports as ports_of


def output_ports(plan: Plan) -> Mapping[str, type[Message]]:
    """Every output port of the plan, STAGE.PORT, with the type of its messages."""
    outputs = {stage.name: ports_of(load_stage(stage.uses)).outputs for stage in plan.stages}
    return {f"{name}.{port.name}": port.type for name, found in outputs.items() for port in found}


def chosen_ports(
    words: str | None,
    ports: Iterable[str],
    option: str,
    offered: Mapping[str, Sequence[str]] = MappingProxyType({}),
) -> tuple[str, ...]:
    """The ports, STAGE.PORT each, that the words name; all if nothing is said. Raises InputError.

    A word is an output of a sub-graph, a stage or a sub-graph (all that is in it), STAGE.PORT (of all its
    cameras), STAGE/CAMERA, or both; several are separated by commas. option: names the words in mistakes;
    offered: the ports behind each output of a sub-graph, see `Plan.offered`.
    """
    known = tuple(ports)
    if words is None:
        return known
    mistakes = []
    found: set[str] = set()
    for word in dict.fromkeys(word.strip() for word in words.split(",")):
        named = ports_named(word, known, offered)
        found.update(named)
        if not named:
            names = {*offered, *(name for port in known for name in port_names(port, offered))}
            remedy = did_you_mean(word, names, "ports")
            mistakes.append(Mistake(None, f'{option}: there is no port "{word}"', remedy))
    if mistakes:
        raise InputError(mistakes)
    return tuple(port for port in known if port in found)


def ports_named(word: str, ports: Sequence[str], offered: Mapping[str, Sequence[str]]) -> list[str]:
    """The ports that a word names; see `chosen_ports`."""
    if word in offered:
        return [port for port in ports if port in offered[word]]
    return [port for port in ports if word in port_names(port, offered)]


def port_names(port: str, offered: Collection[str] = ()) -> list[str]:
    """Names of a port: `hall/camera/cam0.out` is also hall, hall/camera, hall/camera.out, hall/camera/cam0.

    offered: the outputs of sub-graphs, SUBGRAPH.NAME: a sub-graph has the ports of its interface alone.
    """
    stage, _, name = port.rpartition(".")
    subgraphs = {known.partition(".")[0] for known in offered}
    stages = [found for found in enclosing(stage) if found not in subgraphs]
    return [*enclosing(stage), *(f"{found}.{name}" for found in stages)]
