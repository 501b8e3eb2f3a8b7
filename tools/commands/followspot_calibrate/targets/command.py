"""`followspot calibrate targets`."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from followspot import Room, Target
from followspot.errors import FollowspotError, writing
from followspot.operating_system.standard_output import printed_to_stderr
from followspot.room_file import load, update
from followspot_calibrate.clips import folders_of
from followspot_calibrate.output import print_result
from followspot_calibrate.progress import clear_progress, show_progress
from followspot_calibrate.refine.solving import Refinement
from followspot_calibrate.report import write_report
from followspot_calibrate.targets.cameras import Agreement, agreement
from followspot_calibrate.targets.learning import Learnt, learn, refuse_radius, with_templates
from followspot_calibrate.targets.page import page_of
from followspot_calibrate.targets.result import TargetsResult
from followspot_calibrate.targets.separability import Separability, separability
from followspot_calibrate.targets.text import as_json, summary


def calibrate_targets(args: argparse.Namespace, usual: float) -> int:
    """Learn all targets, update the room file, write the page, report; returns the exit code.

    usual: radius, m, if neither the user nor the room file gives it. A clip without a usable target is a
    warning, and so are two targets that look alike. Raises FollowspotError for targets that no camera saw;
    the others are written.
    """
    refuse_radius(args.radius)
    room_file, radius = args.room, args.radius
    room = load(room_file)
    folders = folders_of(args.clips, "target")
    with printed_to_stderr(True):
        report = {folder.name: learn_with_progress(folder, room) for folder in folders}
    failed = [name for name, found in report.items() if all(one.problem for one in found)]
    learnt = {
        name: with_templates(room.targets.get(name, Target(name, usual)), radius, found)
        for name, found in report.items()
        if name not in failed
    }
    targets = {**room.targets, **learnt}
    with printed_to_stderr(True):
        held = Agreement() if args.keep_cameras else agreement(room, args.clips, show_progress)
    clear_progress()
    result = TargetsResult(report, separability_of(room, targets, report), held)
    page = args.report or room_file.with_suffix(".targets.html")
    with writing(room_file):
        write_room(room_file, targets, held.correction)
        write_report(page, page_of(room.name, result))
    print_result(args, as_json(result), summary(result), page, result.warnings)
    if failed:
        raise FollowspotError(f"no camera saw {', '.join(failed)}; {room_file} has the other targets")
    return 0


def write_room(file: Path, targets: Mapping[str, Target], correction: Refinement | None) -> None:
    """The targets, and cameras and planes if they were corrected."""
    if correction is None:
        update(file, targets=targets)
    else:
        cameras = {camera.name: camera for camera in correction.after.cameras}
        update(file, targets=targets, cameras=cameras, planes=correction.planes)


def learn_with_progress(folder: Path, room: Room) -> list[Learnt]:
    """Let all cameras learn one target, with progress and warnings on the way."""
    found = []
    for number, one in enumerate(learn(folder, room), 1):
        found.append(one)
        show_progress(folder.name, number / len(room.cameras))
        if one.problem:
            clear_progress()
            print(f"warning: {folder.name}, {one.camera.name}: {one.problem}", file=sys.stderr)
    clear_progress()
    return found


def separability_of(
    room: Room, targets: Mapping[str, Target], report: Mapping[str, Sequence[Learnt]]
) -> list[Separability]:
    """Separability of all targets in each colour camera: those of the clips and those known before."""
    found = []
    for name, camera in room.cameras.items():
        seen = ((target, one) for target, learnt in report.items() for one in learnt)
        spots = {t: one.spots for t, one in seen if one.camera.name == name and one.spots is not None}
        one = separability(name, targets, spots) if camera.kind == "color" else None
        found += [] if one is None else [one]
    return found
