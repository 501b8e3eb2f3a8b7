"""`followspot calibrate refine`."""

from __future__ import annotations

import argparse
import json

import numpy as np

from followspot import Room
from followspot.errors import InputError, writing
from followspot.room_file import load, update
from followspot_calibrate.check.tracks import read_run, target_sightings
from followspot_calibrate.output import print_result
from followspot_calibrate.progress import clear_progress, show_progress
from followspot_calibrate.refine.cross_validation import Comparison, cross_validate
from followspot_calibrate.refine.page import page_of
from followspot_calibrate.refine.selection import concatenated, select_sightings
from followspot_calibrate.refine.solving import Refinement, refine
from followspot_calibrate.refine.text import (
    as_json,
    as_text,
    comparison_as_json,
    left_out,
    warnings_of,
)
from followspot_calibrate.report import write_report
from followspot_calibrate.target_sightings import TargetSightings, find_target_sightings
from followspot_calibrate.tracked import Tracked, track_recording


def refine_room(args: argparse.Namespace) -> int:
    """Track, adjust, write the page, and the room if it is better; print. Raises FollowspotError."""
    room = load(args.room)
    require(room, args)
    tracked = (
        read_run(args.run, room, "leave --run out: the command then tracks the room's recording by itself")
        if args.run
        else track_recording(args.graph, args.room, args.frames)
    )
    shown = None
    if args.clips is not None:
        shown = find_target_sightings(args.clips, list(room.cameras.values()), show_progress)
    found, held = refined(room, tracked, shown)
    clear_progress()
    report = args.report or args.room.with_suffix(".refine.html")
    written = held is None or held.better
    if written and not args.dry_run:
        with writing(args.room):
            update(args.room, cameras={c.name: c for c in found.after.cameras}, planes=found.planes)
    write_report(report, page_of(room, found))
    result = {"left_out_px": comparison_as_json(held), "written": written and not args.dry_run}
    text = as_text(found) if held is None else f"{as_text(found)}\n{left_out(held)}"
    print_result(args, json.dumps(as_json(found) | result), text, report, warnings_of(held))
    return 0


def require(room: Room, args: argparse.Namespace) -> None:
    """Raises InputError if the room has cameras that cannot be compared with each other."""
    if len(room.cameras) < 3:
        text = f"{args.room} has {len(room.cameras)} cameras"
        raise InputError.of(text, "three or more are needed; calibrate `wand` or `board` instead")
    if not room.targets:
        raise InputError.of(f"{args.room} has no targets", "learn them first: followspot calibrate targets")


def refined(
    room: Room, tracked: Tracked, shown: TargetSightings | None
) -> tuple[Refinement, Comparison | None]:
    """Cameras refined with targets, tracked or also shown alone in clips, if these agree with the tracks.

    The comparison is None if there are too few tracks for one. Raises FollowspotError.
    """
    seen = target_sightings(tracked, room)
    radius = np.array([target.radius for target in room.targets.values()])[seen.target]
    cameras = list(room.cameras.values())
    sightings = select_sightings(cameras, seen.pixel, radius, room.planes)
    held = cross_validate(cameras, sightings, shown, room.planes, show_progress)
    used = shown if held is None or held.use_clips else None
    return refine(cameras, concatenated(sightings, used), room.planes, show_progress), held
