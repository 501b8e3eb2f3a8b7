"""`followspot calibrate clocks`."""

from __future__ import annotations

import argparse
import json
import sys
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np

from followspot import Room, room_file
from followspot.cli.progress import ProgressBar
from followspot.errors import FollowspotError, InputError, did_you_mean, writing
from followspot.graph.plan import Plan
from followspot.messages import Array
from followspot.notes import progress_is_shown
from followspot.operating_system.standard_output import printed_to_stderr
from followspot.operating_system.temporary_folder import TemporaryFolder
from followspot.tables.terminal import table
from followspot_calibrate.clocks.estimation import Offsets, estimated
from followspot_calibrate.clocks.moments import moments
from followspot_calibrate.clocks.page import HEAD, cells, page_of
from followspot_calibrate.output import print_result
from followspot_calibrate.report import write_report
from followspot_calibrate.tracked import Tracked, require_end, track, tracking_plan

FEWEST = 30
"""Sightings of moving targets that a camera's offset needs."""
SETTLED = 1e-4
"""Change from one round to the next at which no other is needed, s."""
DECIMALS = 6
"""Decimals of an offset, s, in the room file, the page, the table and the JSON object."""


def calibrate_clocks(args: argparse.Namespace) -> int:
    """Track, estimate, and again with what was found; write and report. Returns the exit code.

    Raises InputError for files and options, FollowspotError if the graph fails or too little moves.
    """
    if not 0 < args.limit < np.inf:
        raise InputError.of(f"--limit {args.limit:g} is not positive", "give milliseconds, for example 2")
    room = room_file.load(args.room)
    reference = camera_number(room, args.reference)
    with printed_to_stderr(True), TemporaryFolder("clocks") as folder:
        plan = tracking_plan(args.graph, args.room, args.overrides, args.plugin_files, folder.path)
        require_end(plan, args.room, args.frames)
        found = found_in_rounds(plan, folder.path, args)
    if reference is not None:
        found = found.relative_to(reference)
    found = replace(found, offset=np.round(found.offset, DECIMALS))
    if not args.dry_run:
        write(args.room, room, found)
    report = args.report or args.room.with_suffix(".clocks.html")
    write_report(report, page_of(room, found))
    print_result(args, as_json(room, found), text(room, found), report)
    return 0


def camera_number(room: Room, name: str | None) -> int | None:
    """Number of the camera of that name. Raises InputError if the room has none, or only one camera."""
    names = list(room.cameras)
    if len(names) < 2:
        text = f"room {room.name} has {len(names)} cameras"
        raise InputError.of(text, "clocks are compared: two or more are needed")
    if name is not None and name not in names:
        text = f'--reference: the room has no camera "{name}"'
        raise InputError.of(text, did_you_mean(name, names, "cameras"))
    return None if name is None else names.index(name)


def found_in_rounds(plan: Plan, out: Path, args: argparse.Namespace) -> Offsets:
    """Estimate until it settles: tracks get better by the offsets, and offsets by the tracks."""
    room = plan.room
    P = np.array([c.projection for c in room.cameras.values()])
    start = np.array([c.clock_offset for c in room.cameras.values()])
    for number in range(args.rounds):
        tracked = track_with_progress(replace(plan, room=with_offsets(room, start)), out, args.frames, number)
        found = estimated(moments(tracked, room, start), P, start)
        check(room, found, args.limit / 1e3)
        change = np.abs(found.offset - start).max()
        start = found.offset
        if change < SETTLED:
            break
    return found


def track_with_progress(plan: Plan, out: Path, frames: int | None, number: int) -> Tracked:
    """One round, with progress on a terminal."""
    if not progress_is_shown():
        return track(plan, out, frames, None)
    print(f"round {number + 1}", file=sys.stderr)
    with closing(ProgressBar()) as bar:
        return track(plan, out, frames, bar.show)


def with_offsets(room: Room, offset: Array) -> Room:
    """The room with these clock offsets, (C,) s."""
    pairs = zip(room.cameras.items(), offset.tolist(), strict=True)
    return replace(room, cameras={name: replace(c, clock_offset=value) for (name, c), value in pairs})


def check(room: Room, found: Offsets, limit: float) -> None:
    """Raise FollowspotError that names every camera with an uncertain offset; limit: s."""
    problems = []
    for name, count, sigma in zip(room.cameras, found.sightings, found.sigma, strict=True):
        if count < FEWEST:
            problems.append(
                f"{name}: {count} sightings of moving targets that another camera saw too, {FEWEST} needed: "
                f"move a target through its view, at 1 m/s or faster"
            )
        elif not sigma <= limit:
            problems.append(
                f"{name}: its clock offset is known to {sigma * 1e3:.2g} ms only, {limit * 1e3:g} wanted: "
                f"record faster or longer motion, or raise --limit"
            )
    if problems:
        raise FollowspotError("\n".join(problems))


def write(path: Path, room: Room, found: Offsets) -> None:
    """Put the offsets into the room file. Raises FollowspotError."""
    changed = with_offsets(room, found.offset)
    with writing(path):
        room_file.update(path, cameras=changed.cameras)


def text(room: Room, found: Offsets) -> str:
    """One line per camera."""
    return table(HEAD, cells(room, found))


def as_json(room: Room, found: Offsets) -> str:
    """The offsets as one JSON object, in seconds."""
    columns = (each.tolist() for each in (found.offset, found.sigma, found.sightings))
    cameras = {
        name: {"clock_offset": offset, "sigma": sigma, "sightings": count}
        for name, offset, sigma, count in zip(room.cameras, *columns, strict=True)
    }
    return json.dumps({"room": room.name, "cameras": cameras})
