"""`fuse=balls.mean`, `color.similarity=0.7`: changes to the stages of a running plan."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from followspot.errors import InputError, Mistake, Place, did_you_mean
from followspot.graph.change.change_arguments import as_set_option, as_typed, sets_parameter
from followspot.graph.change.replacement import mismatches
from followspot.graph.change.subgraph_change import BY_A_CHANGE, uses_of, with_subgraph_replaced
from followspot.graph.change.subgraph_plan import room_document
from followspot.graph.distinct_mistakes import distinct_mistakes
from followspot.graph.names import enclosing
from followspot.graph.override import SUBGRAPH, Override, read_overrides
from followspot.graph.parameter_origin import origin_of
from followspot.graph.parameters import output_paths, plain_default, validated
from followspot.graph.plan import Plan, PlannedStage
from followspot.graph.provenance import ParameterOrigin
from followspot.graph.subgraph_use import SubgraphUse, is_given_by_set
from followspot.graph.tune import tunes_of
from followspot.plugins.registry import PluginError, load_stage
from followspot.stage import Stage
from followspot.yaml.node import Node, node_of

_BY_SET = ParameterOrigin("--set", kept=True)


@dataclass(frozen=True)
class Change:
    """The stages that change, in their new form, the origins of their parameters, and the sub-graphs then.

    rewired: the plan with stages and edges added and removed, before `stages` change; None if none are.
    """

    stages: tuple[PlannedStage, ...]
    origins: Mapping[str, Mapping[str, ParameterOrigin]]
    subgraphs: tuple[SubgraphUse, ...]
    rewired: Plan | None = None

    def applied(self, plan: Plan) -> Plan:
        """The plan after the change."""
        plan = plan if self.rewired is None else self.rewired
        origins = {**plan.origins, **self.origins}
        return replace(with_stages(plan, self.stages, self.subgraphs), origins=origins)


def change_of(plan: Plan, words: Sequence[str], folder: Path = Path()) -> Change:
    """The change of a plan that the words ask for. Raises InputError with every mistake.

    words: STAGE=USES to swap, STAGE.KEY=VALUE to set a parameter; STAGE is a stage of the graph file or one
    of its instances, or a sub-graph, with FILE for USES; folder: that paths in the words are relative to. A
    replacement keeps the given parameters of the old stage that it also has, and takes the room's tunes for
    the new class, except for parameters that `--set` or a change gave. Words that swap are applied before
    words that set a parameter.
    """
    mistakes: list[Mistake] = []
    requested: dict[str, _Changes] = {}
    begun = plan
    for override in read_overrides(map(as_set_option, sorted(words, key=sets_parameter)), mistakes):
        if not uses_of(plan, override.stage):
            _note(override, plan, requested, mistakes)
        elif override.written in words:  # not STAGE=USES, whose long form it would be
            _note_parameter(override, plan, requested, mistakes)
        else:
            plan = _note_file(override, plan, folder, requested, mistakes)
    found = [_replacement(changes, plan, folder, mistakes) for changes in requested.values()]
    changed = [stage for stage in found if stage is not None]
    if not mistakes:
        _check_outputs(changed, plan, requested, mistakes)
    if mistakes:
        raise InputError(as_typed(distinct_mistakes(mistakes), words))
    new = tuple(stage for stage in changed if stage != requested[stage.name].old)
    origins = {stage.name: _present(requested[stage.name].origins, stage) for stage in new}
    rewired = None if plan.numbers == begun.numbers and plan.edges == begun.edges else plan
    return Change(new, origins, plan.subgraphs, rewired)


def _present(origins: Mapping[str, ParameterOrigin], stage: PlannedStage) -> Mapping[str, ParameterOrigin]:
    """The origins of those parameters that the stage has."""
    return {name: origin for name, origin in origins.items() if name in stage.params}


def with_stages(
    plan: Plan, stages: Iterable[PlannedStage], subgraphs: tuple[SubgraphUse, ...] | None = None
) -> Plan:
    """The plan with these stages instead of those of the same names. subgraphs: None for the present ones."""
    by_name = {stage.name: stage for stage in stages}
    found = tuple(by_name.get(stage.name, stage) for stage in plan.stages)
    return replace(plan, stages=found, subgraphs=plan.subgraphs if subgraphs is None else subgraphs)


@dataclass
class _Changes:
    """The changes that the words request of one instance.

    old: the instance before the change; place: of the first word that names it; uses: the new class, "" for
    the old one; params: the parameters that change.
    """

    old: PlannedStage
    place: Place
    uses: str = ""
    params: dict[str, Node] = field(default_factory=dict)
    origins: dict[str, ParameterOrigin] = field(default_factory=dict)
    """The origin of each parameter that is not a default."""


def _note_file(
    override: Override, plan: Plan, folder: Path, requested: dict[str, _Changes], mistakes: list[Mistake]
) -> Plan:
    """Add a file for a sub-graph to the changes of its instances. Returns the plan with its sub-graphs, and
    with its stages and edges if they differ.
    """
    place, value = override.stage_place, override.value
    if not isinstance(value.value, str) or not value.value:
        mistakes.append(Mistake(value.place, "this is no graph file", f"write {override.stage}=FILE.yaml"))
        return plan
    file = Node(str((folder / value.value).absolute()), place, place)
    for use in uses_of(plan, override.stage):
        try:
            found_plan = with_subgraph_replaced(plan, use, file)
        except InputError as error:
            mistakes += error.mistakes
            return plan
        plan = found_plan.plan
        by_name = {stage.name: stage for stage in plan.stages}
        for found in found_plan.changes or ():
            changes = requested.setdefault(found.name, _no_changes(by_name[found.name], place, plan))
            changes.uses = found.uses
            changes.params |= {key: node_of(value, place) for key, value in found.params.items()}
            changes.origins |= found.origins
    return plan


def _note_parameter(
    override: Override, plan: Plan, requested: dict[str, _Changes], mistakes: list[Mistake]
) -> None:
    """Add a parameter of a sub-graph to the changes of the instances that its interface names."""
    name, place = override.stage, override.stage_place
    keys = override.keys[1:] if override.keys[0] == "with" else override.keys
    if not keys or override.keys[0] in set(SUBGRAPH) - {"with"}:
        text = f'"{override.keys[0]}" of sub-graph "{name}" cannot be changed'
        mistakes.append(Mistake(place, text, f"write {name}.PARAMETER=VALUE, or swap {name}=FILE"))
        return
    for use in uses_of(plan, name):
        if keys[0] not in use.params:
            text = f'sub-graph "{use.name}" has no parameter "{keys[0]}"'
            at = override.places[len(override.keys) - len(keys)]
            mistakes.append(Mistake(at, text, did_you_mean(keys[0], use.params.keys(), "parameters")))
            return
        for leaf in use.params[keys[0]]:
            stage, _, parameter = leaf.rpartition(".")
            _note(replace(override, stage=stage, keys=(parameter, *keys[1:])), plan, requested, mistakes)


def _no_changes(old: PlannedStage, place: Place, plan: Plan) -> _Changes:
    """The changes of an instance that no word has changed yet, with the present origins of its parameters."""
    by_set = [name for name in old.params if is_given_by_set(plan.subgraphs, f"{old.group}.{name}")]
    kept = {**dict.fromkeys(by_set, _BY_SET), **dict.fromkeys(old.kept, BY_A_CHANGE)}
    return _Changes(old, place, origins=kept | dict(plan.origins.get(old.name, {})))


def _note(override: Override, plan: Plan, requested: dict[str, _Changes], mistakes: list[Mistake]) -> None:
    """Add one word to the changes of the instances that it names."""
    name, keys = override.stage, override.keys
    place = override.stage_place
    targets = [stage for stage in plan.stages if name in (stage.group, stage.name)]
    if not targets:
        known = {text for stage in plan.stages for text in (*enclosing(stage.group), stage.name)}
        guess = did_you_mean(name, known, "stages")
        mistakes.append(Mistake(place, f'the graph has no stage "{name}"', guess))
    if keys[0] == "with":
        keys = keys[1:]
    if not keys or (keys[0] == "uses" and not isinstance(override.value.value, str)) or len(keys) > 1:
        remedy = "write STAGE=USES, or STAGE.PARAMETER=VALUE"
        mistakes.append(Mistake(place, "this cannot be changed", remedy))
        return
    for stage in targets:
        changes = requested.setdefault(stage.name, _no_changes(stage, place, plan))
        if keys[0] == "uses":
            changes.uses = str(override.value.value)
        else:
            changes.params[keys[0]] = replace(override.value, key=override.places[0])
            changes.origins[keys[0]] = BY_A_CHANGE


def _replacement(changes: _Changes, plan: Plan, folder: Path, mistakes: list[Mistake]) -> PlannedStage | None:
    """The stage in its new form; None if a mistake was noted."""
    old, place, before = changes.old, changes.place, len(mistakes)
    uses = changes.uses or old.uses
    try:
        present, stage = load_stage(old.uses), load_stage(uses)
    except PluginError as error:
        mistakes.append(Mistake(place, error.problem, error.remedy))
        return None
    noun = f'stage "{old.name}" ({uses})'
    mistakes += [Mistake(place, text, remedy) for text, remedy in mismatches(old, present, stage, plan)]
    given = old.params if stage is present else _given(old, present, stage)
    written = {**({} if stage is present else _tunes(changes, plan, mistakes)), **changes.params}
    params = validated(stage, noun, written, place, mistakes, given=given, folder=folder)
    if params is None or len(mistakes) > before:
        return None
    if uses == old.uses and params == dict(old.params):
        return old
    kept = tuple(name for name in params if name in old.kept or changes.origins.get(name) == BY_A_CHANGE)
    return replace(old, uses=uses, params=params, kept=kept)


def _tunes(changes: _Changes, plan: Plan, mistakes: list[Mistake]) -> dict[str, Node]:
    """The room's tunes for the new stage, without those that `--set` or a change overrides."""
    found = tunes_of(room_document(plan), replace(changes.old, uses=changes.uses), mistakes)
    kept = {name for name, origin in changes.origins.items() if origin.kept} | changes.params.keys()
    tunes = {name: node for name, node in found.items() if name not in kept}
    changes.origins |= {name: ParameterOrigin(origin_of(node, tuned=True)) for name, node in tunes.items()}
    return tunes


def _given(old: PlannedStage, present: type[Stage], stage: type[Stage]) -> dict[str, Any]:
    """Parameters of the old stage that are not its defaults, and that the new one has, too."""
    fields = present.Params.model_fields
    return {
        name: value
        for name, value in old.params.items()
        if name in stage.Params.model_fields
        and (fields[name].is_required() or value != plain_default(present, name))
    }


def _check_outputs(
    stages: Iterable[PlannedStage], plan: Plan, requested: dict[str, _Changes], mistakes: list[Mistake]
) -> None:
    """Note a mistake if old and new stage would write the same file: both are open for a moment."""
    written = {
        path: stage.name
        for stage in plan.stages
        for path in output_paths(load_stage(stage.uses).Params, stage.params)
    }
    for stage in stages:
        old = requested[stage.name].old
        for path in output_paths(load_stage(stage.uses).Params, stage.params):
            if path in written and stage != old:
                text = f'stage "{stage.name}" would write {path}, which "{written[path]}" is writing'
                remedy = f"give it another file, for example {stage.name}.path=2-{path}"
                mistakes.append(Mistake(requested[stage.name].place, text, remedy))
