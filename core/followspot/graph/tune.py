"""`tune` of a room: parameters that suit the room, for every graph that runs in it.

A key is `plugin.name.parameter` or `stage.parameter`, with `/member` after the plugin or stage for one
instance, or `sub-graph.parameter`, which `followspot.graph.compose` has applied. The order is: defaults, the
graph, the room's `tune`, `--set`. The more specific of two tunes wins: that of an instance before that of a
stage, that before one of a sub-graph, that before one of a plugin.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

from followspot.errors import Mistake, Place, did_you_mean
from followspot.graph.expand import ExpandedGraph
from followspot.graph.instances import Instance
from followspot.graph.names import enclosing
from followspot.graph.override import below_set
from followspot.graph.plan import PlannedStage
from followspot.plugins.registry import PluginError, load_stage
from followspot.room import Member
from followspot.yaml.node import Node, child


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


def tuned_graph(expanded: ExpandedGraph, mistakes: list[Mistake]) -> ExpandedGraph:
    """The graph with the tunes of its room, and with a note for each tune that matches nothing."""
    tunes = _read(expanded.room_node)
    if not tunes:
        return expanded
    written = {tune.node.place for found in tunes.values() for tune in found}
    wrong: dict[tuple[str, ...], Mistake] = {}
    used: set[str] = set()
    instances = {}
    for name, instance in expanded.instances.items():
        subjects = _subjects(instance.uses, instance.declared.name, instance.name, instance.member)
        matches = _matches(subjects, tunes)
        used.update(match.tune.key for found in matches.values() for match in found)
        instances[name] = _tuned_instance(instance, matches, written, wrong)
    mistakes += wrong.values()
    idle = [
        tune
        for found in tunes.values()
        for tune in found
        if tune.key not in used and tune.node.key not in expanded.tuned
    ]
    # Of a room or graph with mistakes, the names of some instances are not known.
    notes = [_unmatched(tune, expanded) for tune in idle] if expanded.complete else []
    return replace(expanded, instances=instances, notes=(*expanded.notes, *notes))


def _tuned_instance(
    instance: Instance,
    matches: Mapping[str, Sequence[_Match]],
    written: Collection[Place],
    wrong: dict[tuple[str, ...], Mistake],
) -> Instance:
    """The instance with the most specific tune of each parameter.

    matches: by parameter; written: places of all tunes in the room; wrong: receives the mistake of each tune
    that cannot be applied, once for all instances.
    """
    params = dict(instance.params)
    # Tunes of sub-graphs have come through the interface already; one of a plugin, rank 0, is less specific.
    own = {name for name, node in params.items() if replace(node.place, outer=None) in written}
    for parameter, found in matches.items():
        best, *others = sorted(found, key=lambda match: -match.rank)
        tune = best.tune
        if others and others[0].rank == best.rank:
            other = others[0].tune
            wrong.setdefault((tune.key, other.key), _twice(instance.name, tune, other))
        elif (mistake := _unknown(instance, tune)) is not None:
            wrong.setdefault((tune.key,), mistake)
        elif best.rank or parameter not in own:
            params[parameter] = below_set(tune.node, params.get(parameter))
            own.add(parameter)
    return replace(instance, params=params, tuned=frozenset(own))


def tunes_of(room: Node | None, stage: PlannedStage, mistakes: list[Mistake]) -> dict[str, Node]:
    """The parameters that the room tunes of a stage that takes the place of another in a plan.

    room: its document. Tunes of the stage's name that its plugin does not have were meant for the old one.
    """
    fields = load_stage(stage.uses).Params.model_fields
    found: dict[str, Node] = {}
    subjects = _subjects(stage.uses, stage.group, stage.name, stage.member)
    for parameter, matches in _matches(subjects, _read(room)).items():
        meant = [m for m in matches if m.tune.subject.startswith(stage.uses) or parameter in fields]
        ordered = sorted(meant, key=lambda match: -match.rank)
        if len(ordered) > 1 and ordered[0].rank == ordered[1].rank:
            mistakes.append(_twice(stage.name, ordered[0].tune, ordered[1].tune))
        if ordered:
            found[parameter] = ordered[0].tune.node
    return found


def _read(room: Node | None) -> dict[str, list[_Tune]]:
    """The entries by subject."""
    entries = child(room, "tune")
    found: dict[str, list[_Tune]] = {}
    if entries is not None and isinstance(entries.value, Mapping):
        for key, node in entries.value.items():
            subject, _, parameter = key.rpartition(".")
            found.setdefault(subject, []).append(_Tune(subject, parameter, node))
    return found


def _matches(subjects: Mapping[str, int], tunes: Mapping[str, list[_Tune]]) -> dict[str, list[_Match]]:
    """The tunes of an instance by parameter. subjects: see `_subjects`."""
    found: dict[str, list[_Match]] = {}
    for subject, rank in subjects.items():
        for tune in tunes.get(subject, ()):
            found.setdefault(tune.parameter, []).append(_Match(tune, rank))
    return found


def _subjects(uses: str, group: str, name: str, member: Member | None) -> dict[str, int]:
    """All ways to name an instance, with how specific each is; two of one rank are equally specific."""
    names = {uses: 0, group: 1}
    return names if member is None else {**names, f"{uses}/{member.name}": 1, name: 2}


def _twice(name: str, first: _Tune, second: _Tune) -> Mistake:
    text = f'"{first.key}" and "{second.key}" tune one parameter of "{name}"'
    remedy = f"remove one, or write {name}.{first.parameter}, which is more specific"
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


def _unmatched(tune: _Tune, expanded: ExpandedGraph) -> str:
    """The note for a tune that matches no instance."""
    known: set[str] = set()
    for found in expanded.instances.values():
        known |= {*_subjects(found.uses, found.declared.name, found.name, found.member)}
        known |= {*enclosing(found.declared.name)}
    place = f"{tune.node.key.file}:{tune.node.key.line}"
    text = f'{place}: tune "{tune.key}" matches nothing in this graph'
    near = did_you_mean(tune.subject, known, "").nearest
    return f'{text}; did you mean "{near}"?' if near else text
