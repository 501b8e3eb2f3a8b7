"""`followspot calibrate planes`."""

from __future__ import annotations

import argparse
from collections.abc import Mapping

from followspot import Room
from followspot.errors import InputError, did_you_mean, writing
from followspot.messages import Array
from followspot.room_file import load, update
from followspot_calibrate.output import print_result
from followspot_calibrate.planes.dots import find_marks
from followspot_calibrate.planes.fit import fit_plane
from followspot_calibrate.planes.frame import moved_plane, onto_floor
from followspot_calibrate.planes.marks import read_marks
from followspot_calibrate.planes.page import page_of
from followspot_calibrate.planes.text import as_json, summary
from followspot_calibrate.report import write_report
from followspot_calibrate.similarity import Similarity


def calibrate_planes(args: argparse.Namespace) -> int:
    """Fit all planes, update the room file, write the page, print; returns the exit code.

    Raises FollowspotError if a plane cannot be measured; the room file is untouched then.
    """
    room = load(args.room)
    cameras = list(room.cameras.values())
    marks = read_marks(args.points, cameras) if args.points else find_marks(args.clips, cameras)
    fits = [fit_plane(name, cameras, seen) for name, seen in marks.items()]
    planes = {**room.planes, **{fit.name: fit.plane for fit in fits}}
    motion = None if args.floor is None else onto_floor(floor_of(planes, args.floor))
    warnings = [text for fit in fits for text in fit.warnings] + moved_truth(room, motion)
    cameras_after, planes_after = room.cameras, planes
    if motion is not None:
        cameras_after = {name: motion.camera(camera) for name, camera in room.cameras.items()}
        planes_after = {name: moved_plane(plane, motion) for name, plane in planes.items()}
    report = args.report or args.room.with_suffix(".planes.html")
    with writing(args.room):
        update(args.room, cameras=None if motion is None else cameras_after, planes=planes_after)
    write_report(report, page_of(room.name, cameras_after, planes_after, marks, fits, motion, warnings))
    data, text = as_json(fits, planes_after, args.floor, warnings), summary(fits, planes_after, args.floor)
    print_result(args, data, text, report, warnings, args.room)
    return 0


def floor_of(planes: Mapping[str, Array], name: str) -> Array:
    """The plane of that name. Raises InputError."""
    if name not in planes:
        raise InputError.of(f'there is no plane "{name}" for --floor', did_you_mean(name, planes, "planes"))
    return planes[name]


def moved_truth(room: Room, motion: Similarity | None) -> list[str]:
    """A warning if the room moves and its truth does not."""
    if motion is None or room.truth is None:
        return []
    return ["the room's truth is still given in the old frame; remove `truth:` or move it too"]
