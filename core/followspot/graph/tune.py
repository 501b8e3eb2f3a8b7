"""`tune` of a room: parameters that suit the place, whatever graph runs in it.

A key is `plugin.name.parameter` or `stage.parameter`, with `/member` after the plugin or stage for one
instance. The order is: defaults, the graph, the room's `tune`, `--set`. The more specific of two tunes
wins: that of an instance before that of a stage, that before one of a plugin.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from followspot.document import Node, child
from followspot.errors import Mistake, did_you_mean
from followspot.graph.expand import Expanded, Instance
from followspot.graph.override import is_set
from followspot.plugins.registry import PluginError, load_stage


@dataclass(frozen=True)
class _Tune:
    """One entry. subject: a stage, a plugin's stage, or either with /member."""

    subject: str
    parameter: str
    node: Node

    @property
    def key(self) -> str:
        return f"{self.subject}.{self.parameter}"


@dataclass(frozen=True)
class _Match:
    """A tune of an instance; rank: how specific it is."""

    tune: _Tune
    rank: int


def tuned(expanded: Expanded, mistakes: list[Mistake]) -> Expanded:
    """The graph with the tunes of its room, and with a note for each tune that matches nothing."""
    tunes = _read(expanded.room_node)
    if not tunes:
        return expanded
    wrong: dict[tuple[str, ...], Mistake] = {}
    used: set[str] = set()
    instances = {}
    for name, instance in expanded.instances.items():
        params, own = dict(instance.params), set()
        for parameter, matches in _matches(instance, tunes).items():
            used.update(match.tune.key for match in matches)
            best, *others = sorted(matches, key=lambda match: -match.rank)
            tune = best.tune
            if others and others[0].rank == best.rank:
                other = others[0].tune
                wrong.setdefault((tune.key, other.key), _twice(instance, tune, other))
            elif (mistake := _unknown(instance, tune)) is not None:
                wrong.setdefault((tune.key,), mistake)
            else:
                params[parameter] = _below_set(tune.node, params.get(parameter))
                own.add(parameter)
        instances[name] = replace(instance, params=params, tuned=frozenset(own))
    mistakes += wrong.values()
    idle = [tune for found in tunes.values() for tune in found if tune.key not in used]
    # Of a room or graph with mistakes, the names of some instances are not known.
    notes = [_unmatched(tune, expanded) for tune in idle] if expanded.complete else []
    return replace(expanded, instances=instances, notes=(*expanded.notes, *notes))


def _read(room: Node | None) -> dict[str, list[_Tune]]:
    """The entries by subject."""
    entries = child(room, "tune")
    found: dict[str, list[_Tune]] = {}
    if entries is not None and isinstance(entries.value, Mapping):
        for key, node in entries.value.items():
            subject, _, parameter = key.rpartition(".")
            found.setdefault(subject, []).append(_Tune(subject, parameter, node))
    return found


def _matches(instance: Instance, tunes: Mapping[str, list[_Tune]]) -> dict[str, list[_Match]]:
    """The tunes of an instance by parameter."""
    found: dict[str, list[_Match]] = {}
    for subject, rank in _subjects(instance).items():
        for tune in tunes.get(subject, ()):
            found.setdefault(tune.parameter, []).append(_Match(tune, rank))
    return found


def _subjects(instance: Instance) -> dict[str, int]:
    """All ways to name an instance; two of one rank are equally specific."""
    names = {instance.uses: 0, instance.declared.name: 1}
    if instance.member is None:
        return names
    return {**names, f"{instance.uses}/{instance.member.name}": 1, instance.name: 2}


def _twice(instance: Instance, first: _Tune, second: _Tune) -> Mistake:
    text = f'"{first.key}" and "{second.key}" tune one parameter of "{instance.name}"'
    remedy = f"remove one, or write {instance.name}.{first.parameter}, which is more specific"
    return Mistake(second.node.key.within(first.node.key), text, remedy)


def _unknown(instance: Instance, tune: _Tune) -> Mistake | None:
    """The mistake of a tune whose parameter the stage does not have."""
    try:
        fields = load_stage(instance.uses).Params.model_fields if instance.uses else None
    except PluginError:  # noted where the graph names it
        fields = None
    if fields is None or tune.parameter in fields:
        return None
    text = f'{instance.uses} has no parameter "{tune.parameter}"'
    place = tune.node.key.within(instance.uses_place)
    return Mistake(place, text, did_you_mean(tune.parameter, fields, "parameters"))


def _below_set(tune: Node, given: Node | None) -> Node:
    """The tuned value, in which what `--set` gives keeps its place."""
    if given is None or not _holds_set(given):
        return tune
    # The mapping that `--set STAGE.PARAMETER.KEY=VALUE` makes for KEY has the place of its own key.
    whole = is_set(given) and given.place != given.key
    if whole or not (isinstance(tune.value, Mapping) and isinstance(given.value, Mapping)):
        return given
    kept = {key: node for key, node in given.value.items() if _holds_set(node)}
    below = {key: _below_set(tune.value[key], node) for key, node in kept.items() if key in tune.value}
    return replace(tune, value={**tune.value, **kept, **below})


def _holds_set(node: Node) -> bool:
    """True if `--set` gives the value or a part of it."""
    return is_set(node) or (isinstance(node.value, Mapping) and any(map(_holds_set, node.value.values())))


def _unmatched(tune: _Tune, expanded: Expanded) -> str:
    """The note for a tune that matches no instance."""
    known = {name for instance in expanded.instances.values() for name in _subjects(instance)}
    place = f"{tune.node.key.file}:{tune.node.key.line}"
    text = f'{place}: tune "{tune.key}" matches nothing in this graph'
    near = did_you_mean(tune.subject, known, "").nearest
    return f'{text}; did you mean "{near}"?' if near else text
