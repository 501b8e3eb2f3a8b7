"""An overlay: the changes of a graph file to the stages of the file that it extends."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from followspot.errors import Mistake, Place, did_you_mean
from followspot.graph.override import SUBGRAPH
from followspot.stage_params import ENVELOPE
from followspot.yaml.node import Node

_OF_BOTH = {"in", "each", "optional"}
_OF_A_STAGE = {*ENVELOPE} - _OF_BOTH
_OF_A_SUBGRAPH = {*SUBGRAPH} - _OF_BOTH


def merged_stages(
    base: Mapping[str, Node], own: Mapping[str, Node], mistakes: list[Mistake]
) -> tuple[dict[str, Node], dict[str, Place]]:
    """The stages of both, those of `base` first, and the removed ones with the places that remove them."""
    stages = dict(base)
    removed: dict[str, Place] = {}
    for name, node in own.items():
        if node.value is not None:
            stages[name] = _merged_stage(stages[name], node) if name in stages else node
        elif name in stages:
            del stages[name]
            removed[name] = node.key
        else:
            remedy = did_you_mean(name, base, "stages")
            mistakes.append(Mistake(node.key, f'there is no stage "{name}" to remove', remedy))
    return stages, removed


def merged_mapping(base: Mapping[str, Node], own: Mapping[str, Node]) -> dict[str, Node]:
    """The entries of both, `own` before `base`; null removes an entry."""
    return {name: node for name, node in {**base, **own}.items() if node.value is not None}


def _merged_stage(old: Node, new: Node) -> Node:
    """A stage with changes: `with` and `in` by key, everything else as a whole.

    A changed `uses` or `graph` drops the parameters.
    """
    if not isinstance(old.value, Mapping) or not isinstance(new.value, Mapping):
        return new
    kept = dict(old.value)
    for key, dropped in (("uses", {"uses", *_OF_A_SUBGRAPH}), ("graph", {"graph", *_OF_A_STAGE})):
        if key in new.value and not _same(kept.get(key), new.value[key]):
            kept = {k: node for k, node in kept.items() if k not in dropped}
    for key, node in new.value.items():
        before = kept.get(key)
        if key in ("in", "with") and before is not None:
            kept[key] = _merged_values(before, node, null_removes=key == "in")
        else:
            kept[key] = node
    value = {key: node for key, node in kept.items() if node.value is not None or key not in old.value}
    return replace(new, value=value)


def _merged_values(old: Node, new: Node, *, null_removes: bool) -> Node:
    """Inputs or parameters by key; null is a value of a parameter, but removes an input."""
    if not isinstance(old.value, Mapping) or not isinstance(new.value, Mapping):
        return new
    if null_removes:
        return replace(new, value=merged_mapping(old.value, new.value))
    return replace(new, value={**old.value, **new.value})


def _same(old: Node | None, new: Node) -> bool:
    return old is not None and old.value == new.value
