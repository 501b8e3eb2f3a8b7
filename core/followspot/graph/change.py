"""`fuse=balls.mean`, `color.similarity=0.7`: changes to the stages of a running plan."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from followspot.document import Node, node_of
from followspot.errors import InputError, Mistake, Place, did_you_mean
from followspot.graph.given import origin_of
from followspot.graph.names import enclosing
from followspot.graph.override import Override, read_override
from followspot.graph.parameters import output_paths, plain_default, validated
from followspot.graph.plan import Origin, Plan, PlannedStage, Recipe
from followspot.graph.replacement import misfits
from followspot.graph.subgraph_change import BY_A_CHANGE, is_subgraph, subgraph_changes
from followspot.graph.told_once import told_once
from followspot.graph.tune import tunes_of
from followspot.plugins.registry import PluginError, load_stage
from followspot.stage import Stage


@dataclass(frozen=True)
class Change:
    """The stages that change, in their new form, the origins of their parameters, and the new recipe."""

    stages: tuple[PlannedStage, ...]
    origins: Mapping[str, Mapping[str, Origin]]
    recipe: Recipe | None

    def applied(self, plan: Plan) -> Plan:
        """The plan after the change."""
        origins = {**plan.origins, **self.origins}
        return replace(with_stages(plan, self.stages), origins=origins, recipe=self.recipe)


def change_of(plan: Plan, words: Sequence[str], folder: Path = Path()) -> Change:
    """What becomes of a plan. Raises InputError with every mistake.

    words: STAGE=USES to swap, STAGE.KEY=VALUE to set a parameter; STAGE is a stage of the graph file or one
    of its instances, or a sub-graph, with FILE for USES; folder: that paths in the words are relative to. A
    replacement keeps the given parameters of the old stage that it also has, and takes those that the room
    tunes of it, unless `--set` or a change gave them. Files of sub-graphs come first, in whatever order.
    """
    mistakes: list[Mistake] = []
    wishes: dict[str, _Wish] = {}
    recipe = plan.recipe
    for word in sorted(words, key=_is_set):
        override = read_override(_spelled(word), mistakes)
        if override is not None and is_subgraph(plan, override.stage):
            recipe = _note_subgraph(override, word, replace(plan, recipe=recipe), folder, wishes, mistakes)
        elif override is not None:
            _note(override, plan, wishes, mistakes)
    found = [_replacement(wish, plan, folder, mistakes) for wish in wishes.values()]
    changed = [stage for stage in found if stage is not None]
    if not mistakes:
        _check_outputs(changed, plan, wishes, mistakes)
    if mistakes:
        raise InputError(told_once(mistakes))
    new = tuple(stage for stage in changed if stage != wishes[stage.name].old)
    return Change(new, {stage.name: _present(wishes[stage.name].origins, stage) for stage in new}, recipe)


def _present(origins: Mapping[str, Origin], stage: PlannedStage) -> Mapping[str, Origin]:
    """Those of the parameters that the stage has."""
    return {name: origin for name, origin in origins.items() if name in stage.params}


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
    origins: dict[str, Origin] = field(default_factory=dict)
    """What gave each parameter that is no default its value."""


def _is_set(word: str) -> bool:
    """True for STAGE.KEY=VALUE, False for STAGE=USES."""
    return "." in word.partition("=")[0]


def _spelled(word: str) -> str:
    """STAGE=USES is short for STAGE.uses=USES."""
    stage, sign, uses = word.partition("=")
    return f"{stage}.uses={uses}" if sign and not _is_set(word) else word


def _note_subgraph(
    override: Override,
    word: str,
    plan: Plan,
    folder: Path,
    wishes: dict[str, _Wish],
    mistakes: list[Mistake],
) -> Recipe | None:
    """Add a word for a sub-graph to the wishes for its instances. Returns how the plan is made with it."""
    place = override.stage_place
    by_name = {stage.name: stage for stage in plan.stages}
    try:
        changes, recipe = subgraph_changes(plan, word, folder, place)
    except InputError as error:
        mistakes += error.mistakes
        return plan.recipe
    for found in changes:
        wish = wishes.setdefault(found.name, _wish(by_name[found.name], place, plan))
        wish.uses = found.uses or wish.uses
        wish.params |= {key: node_of(value, place) for key, value in found.params.items()}
        wish.origins |= found.origins
    return recipe


def _wish(old: PlannedStage, place: Place, plan: Plan) -> _Wish:
    return _Wish(old, place, origins=dict(plan.origins.get(old.name, {})))


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
        wish = wishes.setdefault(stage.name, _wish(stage, place, plan))
        if keys[0] == "uses":
            wish.uses = str(override.value.value)
        else:
            wish.params[keys[0]] = replace(override.value, key=override.places[0])
            wish.origins[keys[0]] = BY_A_CHANGE


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
    written = {**({} if stage is present else _tunes(wish, plan, mistakes)), **wish.params}
    params = validated(stage, noun, written, wish.place, mistakes, given=given, folder=folder)
    if params is None or len(mistakes) > before:
        return None
    return replace(old, uses=uses, params=params)


def _tunes(wish: _Wish, plan: Plan, mistakes: list[Mistake]) -> dict[str, Node]:
    """What the room tunes of the new stage, except what `--set` or a change gave; the wish says so."""
    found = tunes_of(plan.room_document, replace(wish.old, uses=wish.uses), mistakes)
    kept = {name for name, origin in wish.origins.items() if origin.kept} | wish.params.keys()
    tunes = {name: node for name, node in found.items() if name not in kept}
    wish.origins |= {name: Origin(origin_of(node, tuned=True)) for name, node in tunes.items()}
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
