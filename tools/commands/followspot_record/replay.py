"""`followspot replay`: the recorded graph, or another one, on the ports of a recording."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial

from followspot.cli.run import execute
from followspot.errors import InputError, Mistake, did_you_mean
from followspot.frame_times import to_seconds
from followspot.graph.compile import compile_graph
from followspot.graph.declaration import ROOM_SOURCE
from followspot.graph.load import LoadedGraph
from followspot.graph.output_ports import chosen_ports, output_ports
from followspot.graph.plan import Plan
from followspot.graph.sampling import plan_sampled_cycles
from followspot.operating_system.standard_output import printed_to_stderr
from followspot.plugins.loaded_hooks import load_plan_options
from followspot.plugins.registry import load_stage
from followspot.ports.signature import ports
from followspot.yaml.node import Node
from followspot_record.embedded import offered_ports, recorded_plan
from followspot_record.replay_plan import NAMES, Clip, replay_plan, replay_stages
from followspot_recording.recording import Recording

_SHORTEST, _LONGEST = 1e-9, 4e9
"""Smallest and largest time in a recording that --from and --to name, s."""


def replay_command(args: argparse.Namespace) -> int:
    """Run on recorded ports. Returns the exit code."""
    mistakes = list(_mistakes(args))
    if mistakes:
        raise InputError(mistakes)
    with printed_to_stderr(args.json), Recording(args.recording) as recording:
        if recording.problem:
            print(f"followspot: {recording.problem}", file=sys.stderr)
        _check_begin(args.start, recording)
        offered = offered_ports(recording)
        more = chosen_ports(args.ports, recording.ports, "--ports", offered) if args.ports else ()
        plan = _other_graph(args, recording) if args.graph else recorded_plan(recording, args.plugin_files)
        if args.seed is not None:
            plan = replace(plan, seed=args.seed)
        clip = Clip(recording.path, args.start, args.stop, args.speed, args.loop)
        plan = _replayed(plan, replay_stages(recording, plan, _ports(plan, recording, more)), clip)
    _check_live(plan)
    check_sampled_cycles(plan, "--graph GRAPH, or play the port, too, with --ports")
    for options in load_plan_options():
        plan = options.change(plan, args)
    return execute(plan, args)


def _check_begin(start: float, recording: Recording) -> None:
    """Raises InputError if nothing was recorded so many seconds after the beginning."""
    lasts = to_seconds(recording.end - recording.begin)
    if recording.ports and start > lasts:
        raise InputError.of(f"--from {start:g} is after the end of {recording.path}", f"it lasts {lasts:g} s")


def source_ports(plan: Plan) -> tuple[str, ...]:
    """The ports of the plan's sources, STAGE.PORT."""
    sources = {stage.name for stage in plan.stages if ports(load_stage(stage.uses)).source}
    return tuple(port for port in output_ports(plan) if port.rpartition(".")[0] in sources)


def _ports(plan: Plan, recording: Recording, more: Sequence[str]) -> Iterator[str]:
    """The ports to play: the recorded sources, and those in `more`. Raises InputError."""
    known = output_ports(plan)
    mistakes = [
        Mistake(
            None, f'--ports: graph "{plan.graph}" has no port "{port}"', did_you_mean(port, known, "ports")
        )
        for port in more
        if port not in known
    ]
    asked = {*more, *(port for port in source_ports(plan) if port in recording.ports)}
    if not asked:
        remedy = f"name some with --ports; recorded: {', '.join(recording.ports) or 'none'}"
        mistakes.append(Mistake(None, f'no source of graph "{plan.graph}" was recorded', remedy))
    if mistakes:
        raise InputError(mistakes)
    return (port for port in known if port in asked)


def _replayed(plan: Plan, chosen: Mapping[str, str], clip: Clip) -> Plan:
    """The plan on these ports, with a note that names the sources that are not played.

    chosen: the stage that replays each port, STAGE.PORT. Raises FollowspotError.
    """
    replayed = replay_plan(plan, chosen, clip)
    needed = {stage.name for stage in replayed.stages}
    others = (port.rpartition(".")[0] for port in source_ports(plan) if port not in chosen)
    anew = [name for name in dict.fromkeys(others) if name in needed]
    if not anew:
        return replayed
    note = f"not recorded, so the sources run that the graph or the room declares: {', '.join(anew)}"
    return replace(replayed, notes=(*replayed.notes, note))


def _mistakes(args: argparse.Namespace) -> Iterator[Mistake]:
    """Options that contradict each other or are out of range."""
    if args.overrides and not args.graph:
        yield Mistake(None, "--set changes a graph file, and none is named", "add --graph GRAPH")
    if args.room and not args.graph:
        yield Mistake(None, "--room serves another graph, and none is named", "add --graph GRAPH")
    if args.cameras and not args.graph:
        yield Mistake(None, "--cameras serves another graph, and none is named", "add --graph GRAPH")
    if args.speed and not 1e-6 <= args.speed <= 1000.0:
        yield Mistake(None, f"--speed cannot be {args.speed:g}", "1e-6 to 1000; 0 is as fast as it can")
    begins = args.start == 0.0 or _SHORTEST <= args.start <= _LONGEST
    ends = args.stop is None or (args.start < args.stop <= _LONGEST and args.stop >= _SHORTEST)
    if not (begins and ends):
        yield Mistake(None, "--from and --to name no part of the recording", "seconds, 0 <= from < to")


def _other_graph(args: argparse.Namespace, recording: Recording) -> Plan:
    """The plan of another graph file; the cameras' own sources need not exist. Raises InputError."""
    return compile_graph(
        args.graph,
        room=args.room,
        cameras=args.cameras,
        overrides=args.overrides,
        plugin_files=args.plugin_files,
        change=partial(_without_room_sources, recording=recording),
    )


def _without_room_sources(loaded: LoadedGraph, recording: Recording) -> LoadedGraph:
    """The declared stages, with a replay for each that stands for the sources of recorded cameras."""
    stages = dict(loaded.stages)
    for name, stage in loaded.stages.items():
        recorded = (channel for port, channel in recording.ports.items() if port.startswith(f"{name}/"))
        kind = next((NAMES.get(channel.schema) for channel in recorded), None)
        if stage.uses == ROOM_SOURCE and kind is not None:
            path = Node(str(recording.path.absolute()), stage.place, stage.place)
            stages[name] = replace(stage, uses=kind, params={"path": path})
    return replace(loaded, stages=stages)


def check_sampled_cycles(plan: Plan, remedy: str) -> None:
    """Raises InputError if the result of this replay would depend on timing; remedy: where to delay it."""
    mistakes = plan_sampled_cycles(plan)
    if mistakes:
        raise InputError([replace(m, help=f"{m.remedy} in {remedy}") for m in mistakes])


def _check_live(plan: Plan) -> None:
    """Raises InputError if a live source would have to be opened."""
    live = [stage.name for stage in plan.stages if stage.live]
    if live:
        remedy = "name with --ports what is played instead of what follows it"
        raise InputError.of(f"{', '.join(live)} is live and was not recorded", remedy)
