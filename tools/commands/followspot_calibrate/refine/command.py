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
from followspot_calibrate.places import Places, find_places
from followspot_calibrate.progress import clear_progress, show_progress
from followspot_calibrate.refine.choosing import telling, together
from followspot_calibrate.refine.page import page_of
from followspot_calibrate.refine.solving import Refinement, refine
from followspot_calibrate.refine.text import as_json, as_text
from followspot_calibrate.report import write_report
from followspot_calibrate.tracked import Tracked, track_recording


def refine_room(args: argparse.Namespace) -> int:
    """Track, adjust, write the room and the page, print. Raises FollowspotError."""
    room = load(args.room)
    require(room, args)
    tracked = read_run(args.run, room) if args.run else track_recording(args.graph, args.room, args.frames)
    shown = None
    if args.clips is not None:
        shown = find_places(args.clips, list(room.cameras.values()), show_progress)
    found = refined(room, tracked, shown)
    clear_progress()
    report = args.report or args.room.with_suffix(".refine.html")
    with writing():
        if not args.dry_run:
            update(args.room, cameras={c.name: c for c in found.after.cameras}, planes=found.planes)
        write_report(report, page_of(room, found))
    print_result(args, json.dumps(as_json(found)), as_text(found), report)
    return 0


def require(room: Room, args: argparse.Namespace) -> None:
    """Raises InputError if the room has cameras that cannot be compared with each other."""
    if len(room.cameras) < 3:
        text = f"{args.room} has {len(room.cameras)} cameras"
        raise InputError.of(text, "three or more are needed; calibrate `wand` or `board` instead")
    if not room.targets:
        raise InputError.of(f"{args.room} has no targets", "learn them first: followspot calibrate targets")


def refined(room: Room, tracked: Tracked, shown: Places | None) -> Refinement:
    """Cameras refined with targets, tracked or shown alone in clips. Raises FollowspotError."""
    seen = target_sightings(tracked, room)
    radius = np.array([target.radius for target in room.targets.values()])[seen.target]
    cameras = list(room.cameras.values())
    places = telling(cameras, seen.pixel, radius, room.planes)
    return refine(cameras, together(places, shown), room.planes, show_progress)
