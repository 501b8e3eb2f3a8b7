"""`followspot calibrate intrinsics`."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from followspot import Camera, Room
from followspot.errors import FollowspotError, InputError, writing
from followspot.operating_system.standard_output import printed_to_stderr
from followspot.room_file import load, save, update
from followspot_calibrate.boards.board import Board, parse_board
from followspot_calibrate.boards.detection import Detector
from followspot_calibrate.intrinsics.calibration import LensCalibration, calibrate_lens
from followspot_calibrate.intrinsics.fitting import NoFit
from followspot_calibrate.intrinsics.page import page_of
from followspot_calibrate.intrinsics.text import as_json, summary
from followspot_calibrate.intrinsics.views import collect_views, live_cameras, uncalibrated_camera
from followspot_calibrate.report import write_report


def calibrate_intrinsics(args: argparse.Namespace) -> int:
    """Calibrate each camera, update the room file, report; returns the exit code.

    Raises FollowspotError for cameras without a result; the others are written.
    """
    _check(args)
    board = parse_board(args.board)
    if board.pattern == "aruco":
        text = f"--board {args.board}: four corners in a view hardly determine a lens"
        raise InputError.of(text, "use a ChArUco board or a chessboard")
    room = load(args.room) if args.room.exists() else Room(args.room.stem)
    live = live_cameras(args, room.cameras)
    with printed_to_stderr(True):
        done, failed = _calibrated(args, live, board)
    report = args.report or args.room.with_suffix(".intrinsics.html")
    notes = write(args.room, room, live, done, report) if done else {}
    print(as_json(done, notes) if args.json else summary(done))
    if done and not args.json:
        print(f"written to {args.room}; the page to look at: {report}")
    if failed:
        raise FollowspotError("\n".join(failed))
    return 0


def _check(args: argparse.Namespace) -> None:
    """Raises InputError if options contradict each other."""
    if bool(args.live or args.device) == bool(args.videos or args.clip):
        text = "give recordings (--videos, --clip) or live cameras (--live, --device), one of them"
        raise InputError.of(text)
    if args.pictures < 1:
        raise InputError.of(f"--pictures {args.pictures} is less than 1", "give 50 to 1000")


def _calibrated(
    args: argparse.Namespace, live: Mapping[str, Camera], board: Board
) -> tuple[dict[str, LensCalibration], list[str]]:
    """The lenses by camera, and why there is none of the others."""
    done: dict[str, LensCalibration] = {}
    failed: list[str] = []
    for name, collected in collect_views(args, live, Detector(board)).items():
        if name in live and not collected.looked_at:
            failed.append(f"{name}: its camera gives no pictures: is it connected, and free?")
            continue
        try:
            done[name] = calibrate_lens(name, collected.views, board, collected.size, args.model)
        except NoFit as error:
            failed.append(
                f"{name}: {error} ({collected.looked_at} pictures searched)\n"
                f"    is --board {args.board} right? Hold the whole board still, in good light"
            )
    return done, failed


def write(
    path: Path, room: Room, live: Mapping[str, Camera], done: Mapping[str, LensCalibration], report: Path
) -> dict[str, list[str]]:
    """Put the lenses into the room file, write the page; returns what else to know of each camera.

    A new camera is a colour camera at the origin, with its device as source if it was live.
    Raises FollowspotError.
    """
    notes: dict[str, list[str]] = {name: list(lens.warnings) for name, lens in done.items()}
    cameras = dict(room.cameras)
    for name, lens in done.items():
        known = room.cameras.get(name) or live.get(name) or uncalibrated_camera(name, lens.size)
        cameras[name] = replace(
            known, size=lens.size, matrix=lens.fit.matrix, distortion=lens.fit.distortion, model=lens.model
        )
        if name in room.cameras and known.translation.any():
            notes[name].append("its pose was found with another lens: calibrate board or wand again")
    with writing(path):
        if path.exists():
            update(path, cameras=cameras)
        else:
            path.parent.mkdir(parents=True, exist_ok=True)
            save(replace(room, cameras=cameras), path)
        write_report(report, page_of(room.name, done, notes))
    for name, texts in notes.items():
        for text in texts:
            print(f"warning: {name}: {text}", file=sys.stderr)
    return notes
