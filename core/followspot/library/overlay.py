"""Saves the changes of a run as an overlay: a graph file that extends the run's own."""

from __future__ import annotations

import json
import os
import re
import time
from collections.abc import Iterator, Mapping, Sequence
from itertools import groupby
from pathlib import Path
from tempfile import NamedTemporaryFile
from typing import Any

from followspot.errors import FollowspotError, require_unused, writing
from followspot.graph.compile import compile_graph
from followspot.graph.plan import Plan, PlannedStage
from followspot.graph.provenance import SourceFiles
from followspot.operator.run_handle import RunHandle
from followspot.valid_values.names import is_name

Entries = Mapping[str, Mapping[str, Any]]
"""The entry of each stage in an overlay: `uses`, if the plugin stage is another, and `with`."""


def save_overlay(run: RunHandle, path: str | Path) -> tuple[str, ...]:
    """Write a new graph file with the differences between the run and its own graph file.

    Returns the stages that it names, after `seed` if the run has another.

    The file extends the run's, of which nothing is copied or changed; it is written only if what it says
    gives the stages and parameters of the run. Raises FollowspotError if it cannot.
    """
    present, source_files, target = run.plan(), run.metadata().source_files, Path(path).absolute()
    if source_files is None:
        raise FollowspotError("this run was not made from a graph file on this host: nothing to extend")
    if target.suffix != ".yaml" or not is_name(target.stem):
        raise FollowspotError(f"{target.name} is no name of a graph file; write NAME.yaml")
    require_unused(target)
    base = _compiled(Path(source_files.graph), source_files, present)
    entries: dict[str, dict[str, Any]] = {group: {"uses": uses} for group, uses in _swapped(base, present)}
    lines = [f"seed: {present.seed}"] if present.seed != base.seed else []
    start = _tried(_text(target, present, source_files, entries), target.parent, source_files, present)
    for group, params in _changed(start, present):
        entries[group] = {**entries.get(group, {}), "with": params}
    _check_edges(start, present, source_files)
    if not entries and not lines:
        raise FollowspotError("nothing differs from the graph file")
    text = _text(target, present, source_files, entries, lines)
    _check(_tried(text, target.parent, source_files, present), present)
    with writing(target), target.open("x", encoding="utf-8") as file:
        file.write(text)
    return (*(["seed"] if lines else []), *entries)


def _tried(text: str, folder: Path, source_files: SourceFiles, present: Plan) -> Plan:
    """The plan of a graph file with this text in a folder. Raises FollowspotError."""
    with writing(folder), NamedTemporaryFile("w", dir=folder, suffix=".yaml", encoding="utf-8") as file:
        file.write(text)
        file.flush()
        return _compiled(Path(file.name), source_files, present)


def _compiled(path: Path, source_files: SourceFiles, present: Plan) -> Plan:
    """The plan of a file, in the room of the run. Raises InputError."""
    room = source_files.room or None
    return compile_graph(path, room=room, cameras=source_files.cameras, plugin_files=present.plugin_files)


def _swapped(base: Plan, present: Plan) -> Iterator[tuple[str, str]]:
    """The stages of the graph file that another plugin serves now. Raises FollowspotError."""
    before = {stage.name: stage.uses for stage in base.stages}
    found = {stage.name for stage in present.stages}
    if gone := sorted(before.keys() - found):
        raise FollowspotError(f"{', '.join(gone)}: stages that left a sub-graph cannot be saved")
    for group, stages in _groups(base, present):
        uses = {stage.uses for stage in stages}
        if any(stage.uses != before[stage.name] for stage in stages):
            yield _own(group), _one(group, "uses", uses)


def _changed(base: Plan, present: Plan) -> Iterator[tuple[str, dict[str, Any]]]:
    """The parameters of each stage of the graph file that differ now. Raises FollowspotError."""
    before = {stage.name: stage.params for stage in base.stages}
    for group, stages in _groups(base, present):
        names = dict.fromkeys(
            name
            for stage in stages
            for name, value in stage.params.items()
            if name not in before[stage.name] or before[stage.name][name] != value
        )
        params = {
            name: json.loads(_one(group, name, {json.dumps(stage.params[name]) for stage in stages}))
            for name in names
        }
        if params:
            yield _own(group), params


def _groups(base: Plan, present: Plan) -> Iterator[tuple[str, Sequence[PlannedStage]]]:
    """The stages of the graph file with their instances; stages that options add are left out."""
    known = {stage.name for stage in base.stages}
    stages = sorted((s for s in present.stages if s.name in known), key=lambda stage: stage.group)
    for group, members in groupby(stages, key=lambda stage: stage.group):
        yield group, list(members)


def _own(group: str) -> str:
    """The stage, if an overlay can change it. Raises FollowspotError."""
    if "/" in group:
        raise FollowspotError(f"{group} is in a sub-graph, whose stages an overlay cannot change")
    return group


def _one(group: str, what: str, values: set[str]) -> str:
    """The only value. Raises FollowspotError if instances differ."""
    if len(values) > 1:
        raise FollowspotError(f"{what} of {group} differs between its instances, which an overlay cannot say")
    return next(iter(values))


def _text(
    target: Path, present: Plan, source_files: SourceFiles, entries: Entries, more: Sequence[str] = ()
) -> str:
    """The file. more: lines beside the stages."""
    folder = target.parent
    lines = [
        f"# Saved from a run of {present.graph}, {time.strftime('%Y-%m-%d %H:%M:%S')}.",
        f"graph: {target.stem}",
        f"extends: {_quoted(os.path.relpath(source_files.graph, folder))}",
        *([f"room: {_quoted(os.path.relpath(source_files.room, folder))}"] if source_files.room else []),
        *more,
        *(["stages:"] if entries else []),
        *(f"  {group}: {_quoted(entry)}" for group, entry in entries.items()),
    ]
    return "\n".join(lines) + "\n"


def _quoted(value: Any) -> str:
    """A value as YAML in ASCII. JSON is not: its escapes of characters beyond U+FFFF come in two halves."""
    text = json.dumps(value, ensure_ascii=False)
    return re.sub(r"[^\x00-\x7e]", lambda one: f"\\U{ord(one[0]):08x}", text)


def _check_edges(saved: Plan, present: Plan, source_files: SourceFiles) -> None:
    """Raises FollowspotError if edges between stages that both have differ; an overlay cannot say so."""
    both = {stage.name for stage in saved.stages} & {stage.name for stage in present.stages}
    found, wanted = (
        {
            edge.name: (edge.delay, edge.tolerance, edge.policy, edge.codec)
            for edge in plan.edges
            if {edge.from_stage, edge.to_stage} <= both
        }
        for plan in (saved, present)
    )
    if other := sorted(name for name in found | wanted if found.get(name) != wanted.get(name)):
        text = f"{', '.join(other[:3])}: not in {Path(source_files.graph).name} as in this run"
        raise FollowspotError(f"{text}; was a file changed since the run began?")


def _check(saved: Plan, present: Plan) -> None:
    """Raises FollowspotError if the saved file gives other stages than the run has."""
    found = {stage.name: (stage.uses, stage.params) for stage in saved.stages}
    wrong = [s.name for s in present.stages if s.name in found and found[s.name] != (s.uses, s.params)]
    if wrong:
        raise FollowspotError(f"what {', '.join(wrong)} became cannot be said by an overlay")
