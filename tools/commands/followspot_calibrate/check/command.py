"""`followspot calibrate check`."""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from followspot import Camera, Room
from followspot.errors import InputError
from followspot.messages import Array
from followspot.room_file import load
from followspot_calibrate.check.against import compare
from followspot_calibrate.check.agreement import Agreement, agreement, bias, typical_error, usual_limits
from followspot_calibrate.check.drift import change, course
from followspot_calibrate.check.findings import Drift, Findings
from followspot_calibrate.check.lengths import measured_length
from followspot_calibrate.check.page import page_of
from followspot_calibrate.check.text import as_json, as_text
from followspot_calibrate.check.tracks import read_run, target_sightings
from followspot_calibrate.output import print_result
from followspot_calibrate.points_file import read_points
from followspot_calibrate.report import write_report
from followspot_calibrate.tracked import track_recording
from followspot_room.calibration import read_calibration

ROOM_FILES = (".yaml", ".yml")


def check_calibration(args: argparse.Namespace) -> int:
    """Measure, judge, write the page, print; returns 1 if a figure is beyond its limit.

    Raises FollowspotError.
    """
    check_options(args)
    room = load(args.room)
    found = findings(args, room)
    report = args.report or args.room.with_suffix(".check.html")
    write_report(report, page_of(room, found))
    print_result(args, as_json(found), as_text(found), report)
    return 1 if found.failures else 0


def check_options(args: argparse.Namespace) -> None:
    """Raises InputError for options that do not go together."""
    if not (args.points or args.run or args.track or args.against):
        text = "there is nothing to check the room with"
        raise InputError.of(text, "give --points, --run, --track or --against")
    if args.length is not None and not args.points:
        raise InputError.of("--length is measured on points", "give them: --points wand.csv")
    for name, value in (("--length", args.length), ("--limit", args.limit)):
        if value is not None and not 0 < value < np.inf:
            raise InputError.of(f"{name} {value:g} is not positive", "for example 0.5")


def findings(args: argparse.Namespace, room: Room) -> Findings:
    """All findings that the evidence allows."""
    cameras = list(room.cameras.values())
    limit = usual_limits(cameras, args.limit)
    points = tracks = length = comparison = None
    drifts: list[Drift] = []
    if args.points:
        seen = read_points(args.points, cameras)
        points = agreement(cameras, seen.pixel, seen.frame, limit, typical_error)
        if args.length is not None:
            length = measured_length(points.points, seen.frame, seen.label, args.length)
    if args.run or args.track:
        targets = target_sightings(
            read_run(args.run, room, "let the check track by itself: --track")
            if args.run
            else track_recording(args.graph, args.room, args.frames),
            room,
        )
        tracks = agreement(cameras, targets.pixel, targets.time, limit, bias)
        drifts = [drift(tracks, number, targets.time) for number in range(len(cameras))]
    if args.against:
        comparison = compare(cameras, cameras_of(args.against))
    return Findings(cameras, points, tracks, drifts, length, comparison, args.limit)


def drift(tracks: Agreement, number: int, time: Array) -> Drift:
    """The course of one camera, and how it changed; one that moved far is not taken to see other things."""
    residual = (tracks.residual if number in tracks.suspects else tracks.inlier_residual)[:, number]
    path = course(tracks.cameras[number].name, time, residual)
    return Drift(path, change(path, time, residual))


def cameras_of(path: Path) -> list[Camera]:
    """The cameras of a room file or of another program's calibration. Raises InputError."""
    if path.suffix.lower() in ROOM_FILES:
        try:
            return list(load(path).cameras.values())
        except InputError as no_room:
            try:
                return list(read_calibration(path).cameras)
            except InputError:
                raise no_room from None
    return list(read_calibration(path).cameras)
