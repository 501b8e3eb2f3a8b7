"""`--record`: a plan with one recording sink for each chosen port, all in one worker."""

from __future__ import annotations

import argparse
import errno
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path
from types import MappingProxyType
from typing import Any

from followspot.cli.graph_options import plan_of
from followspot.cli.run import execute
from followspot.errors import FollowspotError, InputError
from followspot.files import read_text
from followspot.graph.load import composed_graph
from followspot.graph.output_ports import chosen_ports, output_ports
from followspot.graph.plan import Plan, PlannedEdge, PlannedStage, PlannedWorker, nearest_kind
from followspot.graph.plan_data import plan_to_data
from followspot.plugins.catalogue import catalogue
from followspot.plugins.registry import load_stage
from followspot.ports.firing import is_firings
from followspot_record.firings import facts_of_firings, firing_types

SINK = "recording.sink"
PLAN = "plan.json"
"""Name of the attachment that says what was run: stages with their parameters, edges, room, seed."""
WORKER = "record"
_DEPTHS = 32, 128
"""Fewest and most messages of a port that may wait for the recorder: of a camera, one half to two seconds."""
_BACKLOG = 64 << 20
"""Memory, bytes, that more than the fewest pictures of one camera may take while they wait."""
_MAX_FILE = 4 << 20
"""Largest graph or room file that is embedded, bytes."""


@dataclass(frozen=True)
class Target:
    """The file and its content. params: of the recording sinks; metadata, attachments: embedded."""

    path: Path
    params: Mapping[str, Any]
    metadata: Mapping[str, str]
    attachments: Mapping[str, str]

    def sink_params(self, port: str, *, first: bool) -> dict[str, Any]:
        """Validated parameters of a port's sink, in JSON types; the first brings the embedded content."""
        embedded = {"metadata": dict(self.metadata), "attachments": dict(self.attachments)} if first else {}
        given = {**self.params, "path": str(self.path), "port": port, **embedded}
        return load_stage(SINK).Params(**given).model_dump(mode="json")


def target_of(
    plan: Plan,
    names: Sequence[str],
    path: Path,
    params: Mapping[str, Any] = MappingProxyType({}),
    files: Mapping[str, str] = MappingProxyType({}),
) -> Target:
    """A recording of these ports of a plan. files: to be embedded besides, by name."""
    attachments = {PLAN: json.dumps(plan_to_data(plan)), **files}
    return Target(path, params, _metadata(plan, names), attachments)


def record_command(args: argparse.Namespace) -> int:
    """Run and record. Returns the exit code."""
    if args.record is None:
        raise InputError.of("followspot record needs a file", "--record FILE.mcap")
    return execute(plan_of(args), args)


def recorded_as_asked(plan: Plan, args: argparse.Namespace) -> Plan:
    """The plan that records as the options say. Raises InputError."""
    path = Path(args.record).absolute()
    if problem := _unsuitable(path):
        raise InputError.of(f"--record: {args.record} {problem}", "name a new file: FILE.mcap")
    names = chosen_ports(args.record_ports, output_ports(plan), "--record-ports", plan.offered)
    params = {
        "picture_format": args.record_pictures,
        "compression": args.record_compression,
        "essential": not plan.live,  # the show goes on
    }
    target = target_of(plan, names, path, params, graph_files(args))
    if not plan.live:  # a replay is verified by running it again
        return with_recording(plan, names, target)
    target = replace(target, metadata={**target.metadata, **facts_of_firings(plan)})
    return with_recording(plan, (*names, *firing_types(plan, names)), target)


def _unsuitable(path: Path) -> str:
    """The reason why a recording cannot use this path; empty if it can."""
    if path.suffix != ".mcap":
        return "is no .mcap"
    return "exists already" if path.exists() else ""


def with_recording(plan: Plan, names: Sequence[str], target: Target) -> Plan:
    """The plan with a recording sink for each of these ports, in a worker of its own.

    names: STAGE.PORT each, or firings as `firings_of` names them.
    """
    worker = _free(WORKER, {worker.name for worker in plan.workers})
    taken = {stage.name for stage in plan.stages}
    depths = {stage.name: _depth(plan, stage) for stage in plan.stages}
    stages: list[PlannedStage] = []
    edges: list[PlannedEdge] = []
    for name in names:
        stage, _, port = name.rpartition(".")
        sink = _free(f"{WORKER}-{name.replace('/', '-').replace('.', '-')}", taken)
        taken.add(sink)
        params = target.sink_params(name, first=not stages)
        stages.append(PlannedStage(sink, sink, SINK, params, None, worker, live=False))
        kind = nearest_kind(plan.placed(stage), PlannedWorker(worker))
        depth = _DEPTHS[plan.live] if is_firings(name) else depths[stage]
        edges.append(PlannedEdge(stage, port, sink, "message", kind, depth=depth))
    return replace(
        plan,
        stages=(*plan.stages, *stages),
        edges=(*plan.edges, *edges),
        workers=(*plan.workers, PlannedWorker(worker)),
    )


def _depth(plan: Plan, stage: PlannedStage) -> int:
    """Messages of a port that may wait: live sources drop what does not fit, replays wait."""
    fewest, most = _DEPTHS
    if not plan.live:
        return fewest
    if stage.camera is None:
        return most
    width, height = plan.room.cameras[stage.camera].size
    return min(most, max(fewest, _BACKLOG // (3 * width * height)))


def _free(name: str, taken: set[str]) -> str:
    while name in taken:
        name += "-"
    return name


def _metadata(plan: Plan, names: Sequence[str]) -> dict[str, str]:
    """Metadata of the recording."""
    used = {stage.uses for stage in plan.stages}
    entries = [entry for name, entry in catalogue().items() if name in used]
    plugins = dict.fromkeys(f"{entry.distribution} {entry.version}" for entry in entries)
    return {
        "graph": plan.graph,
        "room": plan.room.name,
        "seed": str(plan.seed),
        "followspot": version("followspot"),
        "plugins": ", ".join(plugins),
        "plugin_files": ", ".join(Path(file).name for file in plan.plugin_files),
        "ports": ",".join(names),
        "live": str(any(stage.live for stage in plan.stages)).lower(),
    }


def graph_files(args: argparse.Namespace) -> dict[str, str]:
    """The graph file, the files that it uses, and the room file, by name; unreadable ones are left out."""
    graph = getattr(args, "graph", None)
    if graph is None:
        return {}
    composed = composed_graph(graph, room=args.room, cameras=args.cameras)
    found: dict[str, str] = {}
    for path in composed.files:
        text = _text(path)
        if text is not None:
            again = sum(Path(name).name.endswith(path.name) for name in found)
            found[f"graph/{f'{again + 1}-' if again else ''}{path.name}"] = text
    named = composed.room
    room = Path(args.room) if args.room else None
    if room is None and named is not None:
        room = Path(named.place.file).parent / str(named.value)
    if room is not None and (text := _text(room)) is not None:
        found[f"room/{room.name}"] = text
    return found


def _text(path: Path) -> str | None:
    try:
        return read_text(path, _MAX_FILE)
    except OSError as error:
        if error.errno == errno.EFBIG:
            raise FollowspotError(f"{path} is too large to be embedded; at most {_MAX_FILE} bytes") from None
        return None
    except UnicodeError:
        return None
