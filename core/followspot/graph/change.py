"""`fuse=balls.mean`, `color.similarity=0.7`: changes to the stages of a running plan."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from followspot.document import Node, node_of
from followspot.errors import InputError, Mistake, Place, did_you_mean
from followspot.graph.names import enclosing
from followspot.graph.override import Override, read_override
from followspot.graph.parameters import output_paths, plain_default, validated
from followspot.graph.plan import Plan, PlannedStage
from followspot.graph.replacement import misfits
from followspot.graph.subgraph_change import is_subgraph, subgraph_changes
from followspot.plugins.registry import PluginError, load_stage
from followspot.stage import Stage


def changed_stages(plan: Plan, words: Sequence[str], folder: Path = Path()) -> tuple[PlannedStage, ...]:
    """The stages that change, in their new form. Raises InputError with every mistake.

    words: STAGE=USES to swap, STAGE.KEY=VALUE to set a parameter; STAGE is a stage of the graph file or one
    of its instances, or a sub-graph, with FILE for USES; folder: that paths in the words are relative to. A
    replacement keeps the given parameters of the old stage that it also has.
    """
    mistakes: list[Mistake] = []
    wishes: dict[str, _Wish] = {}
    for word in words:
        override = read_override(_spelled(word), mistakes)
        if override is not None and is_subgraph(plan, override.stage):
            _note_subgraph(override, word, plan, folder, wishes, mistakes)
        elif override is not None:
            _note(override, plan, wishes, mistakes)
    found = [_replacement(wish, plan, folder, mistakes) for wish in wishes.values()]
    changed = [stage for stage in found if stage is not None]
    if not mistakes:
        _check_outputs(changed, plan, wishes, mistakes)
    if mistakes:
        raise InputError(list(dict.fromkeys(mistakes)))
    return tuple(stage for stage in changed if stage != wishes[stage.name].old)


def with_stages(plan: Plan, stages: Iterable[PlannedStage]) -> Plan:
    """The plan with these stages instead of those of the same names."""
    by_name = {stage.name: stage for stage in stages}
    return replace(plan, stages=tuple(by_name.get(stage.name, stage) for stage in plan.stages))


@dataclass
class _Wish:
    """The changes of one instance."""

    old: PlannedStage
    place: Place
    uses: str = ""
    params: dict[str, Node] = field(default_factory=dict)


def _spelled(word: str) -> str:
    """STAGE=USES is short for STAGE.uses=USES."""
    stage, sign, uses = word.partition("=")
    return f"{stage}.uses={uses}" if sign and "." not in stage else word


def _note_subgraph(
    override: Override,
    word: str,
    plan: Plan,
    folder: Path,
    wishes: dict[str, _Wish],
    mistakes: list[Mistake],
) -> None:
    """Add a word for a sub-graph to the wishes for its instances."""
    place = override.stage_place
    by_name = {stage.name: stage for stage in plan.stages}
    try:
        for found in subgraph_changes(plan, word, folder, place):
            wish = wishes.setdefault(found.name, _Wish(by_name[found.name], place))
            wish.uses = found.uses
            wish.params |= {key: node_of(value, place) for key, value in found.params.items()}
    except InputError as error:
        mistakes += error.mistakes


def _note(override: Override, plan: Plan, wishes: dict[str, _Wish], mistakes: list[Mistake]) -> None:
    """Add one word to the wishes for the instances that it names."""
    name, keys = override.stage, override.keys
    place = override.stage_place
    targets = [stage for stage in plan.stages if name in (stage.group, stage.name)]
    if not targets:
        known = {text for stage in plan.stages for text in (*enclosing(stage.group), stage.name)}
        mistakes.append(
            Mistake(place, f'the graph has no stage "{name}"', did_you_mean(name, known, "stages"))
        )
    if keys[0] == "with":
        keys = keys[1:]
    if not keys or (keys[0] == "uses" and not isinstance(override.value.value, str)) or len(keys) > 1:
        mistakes.append(
            Mistake(place, "this cannot be changed", "write STAGE=USES, or STAGE.PARAMETER=VALUE")
        )
        return
    for stage in targets:
        wish = wishes.setdefault(stage.name, _Wish(stage, place))
        if keys[0] == "uses":
            wish.uses = str(override.value.value)
        else:
            wish.params[keys[0]] = replace(override.value, key=override.places[0])


def _replacement(wish: _Wish, plan: Plan, folder: Path, mistakes: list[Mistake]) -> PlannedStage | None:
    """The stage in its new form; None if a mistake was noted."""
    old, before = wish.old, len(mistakes)
    uses = wish.uses or old.uses
    try:
        present, stage = load_stage(old.uses), load_stage(uses)
    except PluginError as error:
        mistakes.append(Mistake(wish.place, error.problem, error.remedy))
        return None
    noun = f'stage "{old.name}" ({uses})'
    mistakes += [Mistake(wish.place, text, remedy) for text, remedy in misfits(old, present, stage, plan)]
    given = old.params if stage is present else _given(old, present, stage)
    params = validated(stage, noun, wish.params, wish.place, mistakes, given=given, folder=folder)
    if params is None or len(mistakes) > before:
        return None
    return replace(old, uses=uses, params=params)


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
    stages: Iterable[PlannedStage], plan: Plan, wishes: dict[str, _Wish], mistakes: list[Mistake]
) -> None:
    """Note a mistake if old and new stage would write the same file: both are open for a moment."""
    written = {
        path: stage.name
        for stage in plan.stages
        for path in output_paths(load_stage(stage.uses).Params, stage.params)
    }
    for stage in stages:
        old = wishes[stage.name].old
        for path in output_paths(load_stage(stage.uses).Params, stage.params):
            if path in written and stage != old:
                text = f'stage "{stage.name}" would write {path}, which "{written[path]}" is writing'
                remedy = f"give it another file, for example {stage.name}.path=2-{path}"
                mistakes.append(Mistake(wishes[stage.name].place, text, remedy))
