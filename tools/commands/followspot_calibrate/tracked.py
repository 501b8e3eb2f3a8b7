"""The room's own recording, tracked by a graph: tracks, and each camera's sightings of them."""

from __future__ import annotations

import json
from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from followspot.cli.progress import ProgressBar
from followspot.csv_rows import read_rows
from followspot.errors import FollowspotError, InputError
from followspot.graph.compile import compile_graph
from followspot.graph.plan import Plan
from followspot.library.execute import OnProgress, RunOptions, run_plan, scored_file
from followspot.messages import Array
from followspot.operating_system.standard_output import printed_to_stderr
from followspot.operating_system.temporary_folder import TemporaryFolder
from followspot.plugins.registry import load_stage
from followspot.ports.signature import ports
from followspot.tracking import TRACKED, Blobs, Tracks
from followspot_accuracy import TrackTable, read_tracks_csv

SIGHTINGS = "sightings.csv"
"""Written by the stage that is added to the graph, in the run's output folder."""
SAME = 1e-6
"""Time stamps that differ by less are of one time, s."""


@dataclass(frozen=True, eq=False)
class BlobTable:
    """M blobs, one row for each target that a blob may belong to.

    time: (M,) s, by the camera's stamp; camera, target: (M,) numbers in the order of the room; pixel: (M, 2)
    px with lens distortion.
    """

    time: Array
    camera: Array
    target: Array
    pixel: Array


@dataclass(frozen=True, eq=False)
class Tracked:
    """The outputs of a run. The targets of the tracks are numbered in the order of the room."""

    tracks: TrackTable
    blobs: BlobTable


def tracking_plan(
    graph: str, room: Path, overrides: Sequence[str], plugin_files: Sequence[str], folder: Path
) -> Plan:
    """The plan of a graph with one more stage, which writes down the blobs that are paired.

    folder: for the changed graph. Raises InputError if graph or room have mistakes, or nothing is paired.
    """
    plan = compile_graph(graph, room=room, overrides=overrides, plugin_files=plugin_files)
    found = detectors(plan)
    if not found:
        text = f"graph {plan.graph} has no stage that joins the blobs of several cameras"
        raise InputError.of(text, "give one that tracks, for example graphs/glowballs.yaml")
    stage = {"uses": "sinks.csv", "in": {"blobs": list(found)}, "with": {"path": SIGHTINGS}}
    changed = {"extends": str(Path(graph).absolute()), "stages": {"write_sightings": stage}}
    file = folder / "graph.yaml"
    file.write_text(json.dumps(changed), encoding="utf-8")  # which is YAML, too
    return compile_graph(file, room=room, overrides=overrides, plugin_files=plugin_files)


def detectors(plan: Plan) -> tuple[str, ...]:
    """The graph's stages with blobs that a stage of another kind reads, in their order."""
    spoken = {stage.name: ports(load_stage(stage.uses)) for stage in plan.stages}
    blobs = {name for name, each in spoken.items() if any(port.type is Blobs for port in each.outputs)}
    group = {stage.name: stage.group for stage in plan.stages}
    ends = (e for e in plan.edges if e.from_stage in blobs and spoken[e.to_stage].outputs)
    return tuple(dict.fromkeys(group[e.from_stage] for e in ends if e.to_stage not in blobs))


def track(plan: Plan, out: Path, frames: int | None, show: OnProgress | None) -> Tracked:
    """Run a plan of `tracking_plan`. Raises FollowspotError if it fails, KeyboardInterrupt on Ctrl-C."""
    report = run_plan(plan, RunOptions(out, frames), show)
    if report.stopped:
        raise KeyboardInterrupt
    if not report.ok:
        raise FollowspotError("\n".join(report.errors) or "messages are unaccounted for")
    file = scored_file(plan, Tracks)
    if file is None:
        raise FollowspotError(f"graph {plan.graph} writes no tracks; it needs a stage sinks.csv")
    targets = tuple(plan.room.targets)
    tracks = in_room(read_tracks_csv(out / file), targets)
    return Tracked(tracks, read_blobs(out / SIGHTINGS, tuple(plan.room.cameras), targets))


def in_room(table: TrackTable, targets: tuple[str, ...]) -> TrackTable:
    """The tracks with the targets numbered in the order of the room, which has them all."""
    number = np.array([targets.index(name) for name in table.objects], int)
    return TrackTable(targets, table.time, number[table.target], table.state, table.xyz)


def track_recording(graph: str, room: Path, frames: int | None) -> Tracked:
    """Track the room's own recording, with progress on a terminal; standard output is left to the result.

    Raises FollowspotError.
    """
    with (
        printed_to_stderr(True),
        TemporaryFolder("track") as folder,
        closing(ProgressBar()) as bar,
    ):
        plan = tracking_plan(graph, room, (), (), folder.path)
        require_end(plan, room, frames)
        return track(plan, folder.path, frames, bar.show if bar.terminal else None)


def require_end(plan: Plan, room: Path, frames: int | None) -> None:
    """Raises InputError if the run would never end."""
    if frames is None and any(stage.live for stage in plan.stages):
        remedy = "record them first, or say how many frames to use: --frames 1000"
        raise InputError.of(f"the cameras of {room} are live and never end", remedy)


def read_blobs(path: Path, cameras: Sequence[str], targets: Sequence[str]) -> BlobTable:
    """Blobs as `sinks.csv` writes them. Raises InputError with line numbers."""
    rows = [
        (row.choice("camera", cameras), row.choice("target", targets), *row.numbers("time", "u", "v"))
        for row in read_rows(path, ("time", "camera", "target", "u", "v"))
    ]
    table = np.array(rows, float).reshape(-1, 5)
    return BlobTable(table[:, 2], table[:, 0].astype(int), table[:, 1].astype(int), table[:, 3:])


def in_order(tracks: TrackTable) -> tuple[Array, Array, Array]:
    """Time, target and position of each measurement, by target and time."""
    measured = np.flatnonzero(tracks.state == TRACKED)
    order = measured[np.lexsort([tracks.time[measured], tracks.target[measured]])]
    return tracks.time[order], tracks.target[order], tracks.xyz[order]


def moments_at(time: Array, target: Array, blobs: BlobTable) -> Array:
    """The moment of each blob's target that its message was joined to: (M,), -1 if there is none.

    Messages are joined to the earliest of them, within less than half a frame interval.
    """
    found = np.full(len(blobs.time), -1)
    window = frame_interval(time, target) / 2
    for number in np.unique(target):
        rows, own = np.flatnonzero(target == number), np.flatnonzero(blobs.target == number)
        place = np.searchsorted(time[rows], blobs.time[own] + SAME) - 1
        near = (place >= 0) & (blobs.time[own] - time[rows[place]] < window)
        found[own[near]] = rows[place[near]]
    return found


def frame_interval(time: Array, target: Array) -> float:
    """Median time between two moments of a target, s; infinite if there are none."""
    step = np.diff(time)[np.diff(target) == 0]
    return float(np.median(step)) if len(step) else np.inf
