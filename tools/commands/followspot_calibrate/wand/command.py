"""`followspot calibrate wand`."""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from followspot import Camera, Room
from followspot.errors import InputError, Mistake, require_unused, writing
from followspot.room_file import load, save, update
from followspot_calibrate.adjust import Progress
from followspot_calibrate.output import print_result
from followspot_calibrate.points_file import read_points
from followspot_calibrate.progress import clear_progress, show_progress
from followspot_calibrate.report import write_report
from followspot_calibrate.sightings import Sightings
from followspot_calibrate.similarity import on_a_line
from followspot_calibrate.target_sightings import find_target_sightings
from followspot_calibrate.wand.alignment import Alignment, onto_centers, onto_itself, onto_marker
from followspot_calibrate.wand.bulb import find_bulb
from followspot_calibrate.wand.diagnostics import warnings_of
from followspot_calibrate.wand.known_places import read_centers, read_marker
from followspot_calibrate.wand.page import page_of
from followspot_calibrate.wand.result import Calibrated, as_json, summary
from followspot_calibrate.wand.solving import Solved, solve
from followspot_calibrate.wand.targets import with_targets
from followspot_calibrate.wand.timing import with_offsets
from followspot_room.moving import moved

LARGEST = 1 << 15
"""Width or height of a picture, px."""


def calibrate_wand(args: argparse.Namespace) -> int:
    """Solve, align, write the room file, print; returns the exit code. Raises FollowspotError."""
    _check(args)
    room = None if args.room is None else load(args.room)
    result = calibrated(args, room)
    output = args.output or args.room
    report = args.report or output.with_suffix(".wand.html")
    with writing(output):
        write(result.cameras, room, args.room, output)
        write_report(report, page_of(room or Room(output.stem), result))
    print_result(args, as_json(result), summary(result), report, result.warnings, output)
    return 0


def calibrated(args: argparse.Namespace, room: Room | None) -> Calibrated:
    """The calibration from points to the room's frame; nothing is written."""
    known = None if room is None else list(room.cameras.values())
    sightings = _sightings(args, known or (), show_progress)
    solved, targets = solve(sightings, known, args.intrinsics, args.length, show_progress), None
    if args.targets is not None:
        clips = find_target_sightings(args.targets, known or (), show_progress)
        targets = with_targets(solved, clips, progress=show_progress)
        targets = with_targets(targets.solved, clips, aligned(args, targets.solved, room), show_progress)
        solved = targets.solved
    clear_progress()
    alignment = aligned(args, solved, room)
    own = [in_room(alignment.transform.camera(camera), room) for camera in solved.adjusted.cameras]
    if args.clock_offsets:
        own = with_offsets(own, solved.timed, args.fps)
    warnings = warnings_of(solved, alignment.transform.scale if alignment.metric else None, args.fps)
    if alignment.method != "centers" and room is not None and room.planes:
        warnings.append("the room's frame of reference is new; its planes are not: calibrate planes again")
    return Calibrated(
        solved,
        alignment,
        {camera.name: camera for camera in own},
        alignment.transform.points(solved.adjusted.points),
        [*warnings, *alignment.warnings],
        targets,
    )


def _sightings(args: argparse.Namespace, known: Sequence[Camera], progress: Progress | None) -> Sightings:
    """The points of the frames that were asked for. Raises InputError if there are none."""
    if args.clips is not None:
        found = find_bulb(args.clips, known, progress)
    else:
        found = read_points(args.points, known, size=_size(args.size), confidence=args.confidence)
    if args.frames is None:
        return found
    first, last = args.frames
    chosen = (found.frame >= first) & (found.frame <= (found.frame.max() if last is None else last))
    if not chosen.any():
        text = f"there are no points in the frames {first}-{'' if last is None else last}"
        raise InputError.of(text, f"there are {found.frame.min()}-{found.frame.max()}")
    return found.rows(chosen)


def aligned(args: argparse.Namespace, solved: Solved, room: Room | None) -> Alignment:
    """The frame of reference that was asked for, or the one that there is something known of."""
    cameras, scaled = solved.adjusted.cameras, solved.rods is None
    names = solved.sightings.cameras
    centers = {} if room is None else {name: camera.center for name, camera in room.cameras.items()}
    if args.centers is not None:
        centers = read_centers(args.centers, names)
    method = args.align
    if method == "auto":
        usable = args.centers is not None or not on_a_line(np.array(list(centers.values())).reshape(-1, 3))
        method = "marker" if args.marker is not None else "centers" if usable else "none"
    if method == "marker":
        return onto_marker(cameras, read_marker(args.marker, names), scaled=scaled)
    if method == "centers":
        return onto_centers(cameras, centers, scaled=scaled)
    return onto_itself(cameras, metric=not scaled)


def in_room(camera: Camera, room: Room | None) -> Camera:
    """The camera of the room with this calibration; what else the room says of it stays."""
    if room is None:
        return camera
    return replace(
        room.cameras[camera.name],
        model=camera.model,
        matrix=camera.matrix,
        distortion=camera.distortion,
        rotation=camera.rotation,
        translation=camera.translation,
    )


def write(cameras: Mapping[str, Camera], room: Room | None, source: Path | None, output: Path) -> None:
    """The room with these cameras: a new file, or the same with everything else left as it is."""
    if room is None:
        save(Room(output.stem, cameras), output)
    elif source is not None and output.exists() and output.samefile(source):
        update(output, cameras=cameras)
    else:
        save(moved(replace(room, cameras=cameras), output), output)


def _check(args: argparse.Namespace) -> None:
    """Raises InputError for arguments that do not go together."""
    mistakes = []
    if args.room is None and args.output is None:
        mistakes.append(Mistake(None, "there is no room file to write", "give -o ROOM, or --room ROOM"))
    if args.room is None and args.clips is not None:
        mistakes.append(Mistake(None, "--clips needs a room that names the cameras", "give --room ROOM"))
    if args.room is None and args.targets is not None:
        mistakes.append(Mistake(None, "--targets needs a room that names the cameras", "give --room ROOM"))
    if args.room is None and args.intrinsics == "known":
        mistakes.append(Mistake(None, "--intrinsics known needs a room that has them", "give --room ROOM"))
    if args.align == "marker" and args.marker is None:
        mistakes.append(Mistake(None, "--align marker needs its points", "give --marker CSV"))
    if args.fps is not None and not 0 < args.fps < np.inf:
        mistakes.append(Mistake(None, f"--fps {args.fps:g} is no frame rate", "give frames a second, as 60"))
    if args.clock_offsets and args.fps is None:
        mistakes.append(Mistake(None, "--clock-offsets needs the frame rate", "give --fps, as 60"))
    if args.length is not None and not args.length > 0:
        mistakes.append(Mistake(None, f"--length {args.length:g} is not positive", "give metres, as 0.5"))
    if mistakes:
        raise InputError(mistakes)
    if args.output is not None:
        require_unused(args.output, *([args.room] if args.room is not None else []))


def _size(text: str | None) -> tuple[int, int] | None:
    if text is None:
        return None
    width, _, height = text.lower().partition("x")
    if not (width.isdecimal() and height.isdecimal()):
        raise InputError.of(f"--size {text} is no size", "give width and height, as 640x480")
    if not (0 < int(width) <= LARGEST and 0 < int(height) <= LARGEST):
        raise InputError.of(f"--size {text} is no size of a picture", f"from 1 to {LARGEST}")
    return int(width), int(height)
