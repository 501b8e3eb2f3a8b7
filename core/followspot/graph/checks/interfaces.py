"""Whether the parameters and ports that the interfaces of graph files name are there."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from followspot.errors import Mistake, did_you_mean
from followspot.graph.compose.interface_targets import Noun, StageTarget, is_noted
from followspot.graph.declaration import ROOM_SOURCE
from followspot.graph.expand import ExpandedGraph
from followspot.plugins.registry import PluginError, load_stage
from followspot.ports.signature import ports
from followspot.stage import Stage


def check_interface(targets: Sequence[StageTarget], expanded: ExpandedGraph, mistakes: list[Mistake]) -> None:
    """Note every parameter and port that a stage lacks, unless a use of the file has shown it.

    Of a file that is used, the place of the use stands behind that of the interface.
    """
    sources = {instance.declared.name: instance.uses for instance in expanded.instances.values()}
    for found in targets:
        target = found.target
        uses = sources.get(target.stage, "") if found.uses == ROOM_SOURCE else found.uses
        stage = _class(uses)
        if stage is None or is_noted(target, mistakes):
            continue
        known = _known(found.noun, stage)
        if target.name is None:
            if found.noun == "output" and not known:
                text = f'stage "{target.stage}" ({uses}) is a sink and has no outputs'
                mistakes.append(Mistake(target.node.place, text, "remove it from the interface"))
        elif target.name not in known:
            text = f'stage "{target.stage}" has no {found.noun} "{target.name}"'
            remedy = did_you_mean(target.name, known, f"{found.noun}s")
            mistakes.append(Mistake(target.node.place, text, remedy))


def _class(uses: str) -> type[Stage] | None:
    try:
        return load_stage(uses) if uses else None
    except PluginError:  # which is a mistake of its own
        return None


def _known(noun: Noun, stage: type[Stage]) -> Collection[str]:
    if noun == "parameter":
        return stage.Params.model_fields.keys()
    found = ports(stage)
    return [port.name for port in (found.inputs if noun == "input" else found.outputs)]
