"""From files to a plan: load -> expand -> check -> place -> plan. Nothing is started."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from followspot.errors import FollowspotError, Guess, InputError, Mistake, Place
from followspot.graph.arrange import EdgeChoice, plan
from followspot.graph.check import CheckedGraph, check
from followspot.graph.checks.interfaces import check_interface
from followspot.graph.distinct_mistakes import distinct_mistakes
from followspot.graph.expand import expand
from followspot.graph.load import LoadedGraph, load
from followspot.graph.placement import Placement, place
from followspot.graph.plan import Plan
from followspot.graph.provenance import SourceFiles
from followspot.graph.tune import tuned_graph
from followspot.plugins.registry import use_plugin_files


def compile_graph(
    path: str | Path,
    *,
    room: str | Path | None = None,
    cameras: Sequence[str] = (),
    placement: str | Path | None = None,
    overrides: Sequence[str] = (),
    plugin_files: Sequence[str | Path] = (),
    edges: EdgeChoice = "auto",
    seed: int | None = None,
    change: Callable[[LoadedGraph], LoadedGraph] | None = None,
    strict: bool = False,
    subscribed: Sequence[str] = (),
) -> Plan:
    """The plan of a graph file. Raises InputError with every mistake.

    room: a room file instead of the graph's own; cameras: those of the room that take part, all if there are
    none; placement: "camera", "stage" or a placement file; overrides: STAGE.KEY=VALUE; plugin_files: Python
    files that offer stages; seed: of all random numbers; change: changes the declared stages before they are
    looked up; strict: treat everything that can make two runs differ as a mistake; subscribed: STAGE.PORT
    that a script reads, which are not warned about.
    """
    files = tuple(str(Path(file).absolute()) for file in plugin_files)
    checked, placed = checked_graph(
        path,
        room=room,
        cameras=cameras,
        placement=placement,
        overrides=overrides,
        plugin_files=files,
        change=change,
        strict=strict,
        subscribed=subscribed,
    )
    found = plan(checked, placed, edges, seed=seed, plugin_files=files)
    if change is not None:
        return found
    named = "" if room is None else str(Path(room).absolute())
    return replace(found, source_files=SourceFiles(str(Path(path).absolute()), named, tuple(cameras)))


def checked_graph(
    path: str | Path,
    *,
    room: str | Path | None = None,
    cameras: Sequence[str] = (),
    placement: str | Path | None = None,
    overrides: Sequence[str] = (),
    plugin_files: Sequence[str] = (),
    change: Callable[[LoadedGraph], LoadedGraph] | None = None,
    strict: bool = False,
    subscribed: Sequence[str] = (),
) -> tuple[CheckedGraph, Placement]:
    """The graph before it is planned, with the places of all that is written; see `compile_graph`."""
    refused = _refused(plugin_files)
    mistakes = list(refused)
    try:
        file = None if room is None else str(room)
        loaded = load(path, mistakes, room=file, cameras=cameras, overrides=overrides)
    except InputError as error:
        raise InputError(_ordered(error.mistakes)) from None
    expanded = expand(loaded if change is None else change(loaded), mistakes)
    expanded = tuned_graph(expanded, mistakes)
    checked = check(replace(expanded, offered=expanded.offered | _stages(subscribed)), mistakes)
    check_interface(loaded.interface_targets, expanded, mistakes)
    mistakes += checked.risks if strict else ()
    placed = place(expanded, None if placement is None else str(placement), mistakes)
    if mistakes:
        raise InputError(_ordered([m for m in mistakes if not (refused and _may_follow(m))]))
    return checked, placed


def _stages(ports: Sequence[str]) -> set[str]:
    """The stages of ports: instances, and their stages in the graph file."""
    names = {port.partition(".")[0] for port in ports}
    return names | {name.rpartition("/")[0] for name in names}


def _refused(files: Sequence[str]) -> list[Mistake]:
    """The mistakes of plugin files that cannot be used; the others are loaded."""
    mistakes = []
    for file in files:
        try:
            use_plugin_files([file], changed=True)
        except FollowspotError as error:
            mistakes.append(Mistake(None, f"--plugin: {error}"))
    return mistakes


def _may_follow(mistake: Mistake) -> bool:
    """Whether a mistake may be due to a refused plugin file: an unknown stage that is like no other."""
    unknown = mistake.text.startswith("no stage ") and mistake.text.endswith(" is installed")
    return unknown and isinstance(mistake.help, Guess) and not mistake.help.nearest


def _ordered(mistakes: Sequence[Mistake]) -> list[Mistake]:
    """Each mistake once, file by file, from the top to the bottom of each."""
    files = dict.fromkeys(m.place.file for m in mistakes if m.place is not None)
    rank = {file: number for number, file in enumerate(files)}

    def position(mistake: Mistake) -> tuple[int, int, int]:
        at: Place | None = mistake.place
        return (-1, 0, 0) if at is None else (rank[at.file], at.line, at.column)

    return sorted(distinct_mistakes(mistakes), key=position)
