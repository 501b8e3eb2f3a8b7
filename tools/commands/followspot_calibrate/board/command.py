"""`followspot calibrate board`."""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from followspot import Room
from followspot.errors import InputError, writing
from followspot.operating_system.standard_output import printed_to_stderr
from followspot.room_file import load, update
from followspot_calibrate.board.page import page_of
from followspot_calibrate.board.solving import BoardCalibration, solve
from followspot_calibrate.board.text import as_json, summary, warnings_of
from followspot_calibrate.board.timestamps import read_timestamps
from followspot_calibrate.board.views import find_views
from followspot_calibrate.boards.board import parse_board
from followspot_calibrate.boards.pictures import recordings
from followspot_calibrate.output import print_result
from followspot_calibrate.progress import clear_progress, show_progress
from followspot_calibrate.report import Page, write_report

TIMESTAMPS = "timestamps.csv"


def calibrate_board(args: argparse.Namespace) -> int:
    """Find the board, solve, update the room file, report; returns the exit code. Raises FollowspotError."""
    board = parse_board(args.board)
    if board.symmetric:
        text = f"--board {args.board}: the two ends of this chessboard cannot be told apart"
        raise InputError.of(text, "use a ChArUco board, or an odd and an even number of corners")
    room = load(args.room)
    paths = recordings(args.videos, args.clip, list(room.cameras))
    strange = [name for name in paths if name not in room.cameras]
    if strange or len(paths) < 2:
        text = f'{args.room} has no camera "{strange[0]}"' if strange else "only one camera has a recording"
        raise InputError.of(text, f"cameras: {', '.join(room.cameras)}")
    if args.pictures < 1:
        raise InputError.of(f"--pictures {args.pictures} is less than 1", "give 50 to 1000")
    cameras = [camera for name, camera in room.cameras.items() if name in paths]
    moments = _moments(args, [camera.name for camera in cameras])
    with printed_to_stderr(True):
        views = find_views(cameras, paths, board, moments, args.pictures)
    found = solve(cameras, views, board, args.floor, show_progress)
    clear_progress()
    still = [name for name in room.cameras if name not in paths]
    notes = [*warnings_of(found), *(f"{name} has no recording and keeps its pose" for name in still)]
    report = args.report or args.room.with_suffix(".board.html")
    page = page_of(room.name, found, room.planes if args.floor is None else {}, notes)
    write(args.room, room, found, report, page)
    print_result(args, as_json(found, notes), summary(found), report, notes, args.room)
    return 0


def _moments(args: argparse.Namespace, names: Sequence[str]) -> Mapping[str, Mapping[int, int]] | None:
    """The time stamps that match frames; None if equal numbers are equal moments. Raises InputError."""
    path = args.timestamps or (args.videos / TIMESTAMPS if args.videos else None)
    return read_timestamps(path, names) if path and (args.timestamps or path.is_file()) else None


def write(path: Path, room: Room, found: BoardCalibration, report: Path, page: Page) -> None:
    """Put the poses into the room file, write the page. Raises FollowspotError."""
    placed = {
        c.name: replace(room.cameras[c.name], rotation=c.rotation, translation=c.translation)
        for c in found.cameras
    }
    with writing(path):
        update(path, cameras={**room.cameras, **placed})
        write_report(report, page)
