"""The sub-graphs of a composed graph with all names resolved, as a running graph keeps them."""

from __future__ import annotations

from collections.abc import Iterator

from followspot.graph.compose.feeds import items
from followspot.graph.compose.interface import InterfaceTarget
from followspot.graph.compose.senders import senders
from followspot.graph.compose.unit import Unit
from followspot.graph.names import below
from followspot.graph.override import WHILE_IT_RAN, is_set
from followspot.graph.selector import Selector
from followspot.graph.subgraph_use import SubgraphUse
from followspot.room import Member
from followspot.yaml.node import plain


def resolved_uses(unit: Unit) -> Iterator[SubgraphUse]:
    """The uses of files below a unit, outer ones first."""
    for stage, inners in unit.units.items():
        for inner in inners:
            yield resolved(inner, below(unit.name, stage))
            yield from resolved_uses(inner)


def resolved(unit: Unit, stage: str) -> SubgraphUse:
    """One use of a file. stage: see `SubgraphUse`."""
    feeds = {name: items(wired.feeds) for name, wired in unit.inputs.items()}
    return SubgraphUse(
        unit.name,
        stage,
        {
            name: [plain(one) for item in found for one in senders(unit.inputs[name].unit, item, [])]
            for name, found in feeds.items()
        },
        tuple(limit.text for limit in unit.limits if isinstance(limit, Selector)),
        tuple(limit for limit in unit.limits if isinstance(limit, Member)),
        {
            name: tuple(dict.fromkeys(leaf for target in targets for leaf in _leaves(unit, target)))
            for name, targets in unit.interface.params.items()
        },
        {n: is_set(node) for n, node in unit.given.items() if node.place.file != WHILE_IT_RAN},
    )


def _leaves(unit: Unit, target: InterfaceTarget) -> Iterator[str]:
    """The parameters of stages, STAGE.PARAMETER, that a parameter of an interface stands for."""
    for inner in unit.units.get(target.stage, ()):
        for below_it in inner.interface.params.get(target.name or "", ()):
            yield from _leaves(inner, below_it)
    if target.stage not in unit.units and target.stage not in unit.replaced:
        yield f"{below(unit.name, target.stage)}.{target.name}"
