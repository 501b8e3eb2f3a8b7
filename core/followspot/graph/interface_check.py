"""Whether the parameters and ports that the interface of a graph file names are there.

Only for the file that is checked itself: those of its sub-graphs show in what reads and sets them.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

from followspot.errors import Mistake, did_you_mean
from followspot.graph.compose.promises import Noun, Promise
from followspot.graph.expand import Expanded
from followspot.plugins.registry import PluginError, load_stage
from followspot.ports import ports
from followspot.stage import Stage


def check_interface(promises: Sequence[Promise], expanded: Expanded, mistakes: list[Mistake]) -> None:
    """Note every parameter and port that a stage of the graph lacks."""
    classes: dict[str, type[Stage]] = {}
    for instance in expanded.instances.values():
        try:
            classes.setdefault(instance.declared.name, load_stage(instance.uses))
        except PluginError:
            continue  # which is a mistake of its own
    for noun, target in promises:
        stage = classes.get(target.stage)
        if stage is None or target.name is None:
            continue
        name = target.name.partition(".")[0]
        known = _known(noun, stage)
        if name not in known:
            text = f'stage "{target.stage}" has no {noun} "{name}"'
            mistakes.append(Mistake(target.node.place, text, did_you_mean(name, known, f"{noun}s")))


def _known(noun: Noun, stage: type[Stage]) -> Collection[str]:
    if noun == "parameter":
        return stage.Params.model_fields.keys()
    found = ports(stage)
    return [port.name for port in (found.inputs if noun == "input" else found.outputs)]
