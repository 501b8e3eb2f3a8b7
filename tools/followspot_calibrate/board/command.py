"""What `followspot calibrate board` does."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from followspot import Camera, Room
from followspot.errors import FollowspotError, InputError, Mistake
from followspot.room_file import load, update
from followspot_calibrate.board.solving import BoardCalibration, solve
from followspot_calibrate.board.timestamps import read_timestamps
from followspot_calibrate.boards.board import Board, parse_board
from followspot_calibrate.boards.detection import Detector, View
from followspot_calibrate.boards.pictures import count, pictures, recordings

TIMESTAMPS = "timestamps.csv"
FEW_MOMENTS = 10
"""That link a camera, below which the user is warned."""
SCALE_DOUBT = 0.02
"""Deviation of the scale from 1 at which lenses or board are in doubt."""
ROUGH = 1.0
"""RMS error of a camera at which something is in doubt, px."""
FLEXIBLE_MM = 5.0
"""Error of the board's own lengths at which something is in doubt, mm."""


def calibrate_board(args: argparse.Namespace) -> int:
    """Find the board, solve, update the room file, report; returns the exit code. Raises FollowspotError."""
    board = parse_board(args.board)
    if board.symmetric:
        text = f"--board {args.board}: nobody can tell which end of this chessboard is which"
        raise InputError(
            [Mistake(None, text, "use a ChArUco board, or an odd and an even number of corners")]
        )
    room = load(args.room)
    paths = recordings(args.videos, args.clip, list(room.cameras))
    strange = [name for name in paths if name not in room.cameras]
    if strange or len(paths) < 2:
        text = f'{args.room} has no camera "{strange[0]}"' if strange else "only one camera has a recording"
        raise InputError([Mistake(None, text, f"cameras: {', '.join(room.cameras)}")])
    cameras = [camera for name, camera in room.cameras.items() if name in paths]
    moments = _moments(args, [camera.name for camera in cameras])
    views = find(cameras, paths, board, moments, args.pictures)
    found = solve(cameras, views, board, args.floor, _progress if sys.stderr.isatty() else None)
    _clear()
    write(args.room, room, found)
    notes = warnings_of(found)
    for note in notes:
        print(f"warning: {note}", file=sys.stderr)
    print(_as_json(found, notes) if args.json else summary(found))
    return 0


def _moments(args: argparse.Namespace, names: Sequence[str]) -> Mapping[str, Mapping[int, int]] | None:
    """What belongs together; None where the same number is the same moment. Raises InputError."""
    path = args.timestamps or (args.videos / TIMESTAMPS if args.videos else None)
    return read_timestamps(path, names) if path and (args.timestamps or path.is_file()) else None


def find(
    cameras: Sequence[Camera],
    paths: Mapping[str, Path],
    board: Board,
    moments: Mapping[str, Mapping[int, int]] | None,
    most: int,
) -> dict[str, list[View]]:
    """Camera -> views of the board at the same moments, at most this many. Raises InputError."""
    detector = Detector(board)
    when = moments or {name: {k: k for k in range(count(path))} for name, path in paths.items()}
    everything = sorted({moment for of_camera in when.values() for moment in of_camera.values()})
    chosen = set(everything[:: max(1, -(-len(everything) // most))])
    views: dict[str, list[View]] = {}
    for camera in cameras:
        wanted = {picture: moment for picture, moment in when[camera.name].items() if moment in chosen}
        views[camera.name] = []
        for done, (picture, gray) in enumerate(pictures(paths[camera.name], wanted), 1):
            if gray.shape[::-1] != camera.size:
                raise InputError([_other_size(camera, gray.shape[::-1])])
            view = detector.find(gray, wanted[picture])
            if view is not None:
                views[camera.name].append(view)
            if sys.stderr.isatty():
                _progress(f"{camera.name}: {len(views[camera.name])} views", done / len(wanted))
    return views


def _other_size(camera: Camera, found: tuple[int, ...]) -> Mistake:
    text = f"camera {camera.name} is calibrated for {camera.size[0]}x{camera.size[1]} px, its recording is "
    return Mistake(None, f"{text}{found[0]}x{found[1]}", "calibrate intrinsics at this size first")


def write(path: Path, room: Room, found: BoardCalibration) -> None:
    """Put the poses into the room file. Raises FollowspotError."""
    placed = {
        c.name: replace(room.cameras[c.name], rotation=c.rotation, translation=c.translation)
        for c in found.cameras
    }
    try:
        update(path, cameras={**room.cameras, **placed})
    except OSError as error:
        raise FollowspotError(f"{path} cannot be written: {error.strerror}") from None


def warnings_of(found: BoardCalibration) -> list[str]:
    """What is in doubt, each with its remedy."""
    notes = []
    for number, camera in enumerate(found.cameras):
        links = [relation.moments for pair, relation in found.pairs.items() if number in pair]
        if max(links, default=0) < FEW_MOMENTS:
            notes.append(f"{camera.name} is linked by {max(links, default=0)} moments only: show it more")
        if found.rms[number] > ROUGH:
            notes.append(f"{camera.name} is off by {found.rms[number]:.1f} px: calibrate its lens again")
    if abs(found.scale - 1) > SCALE_DOUBT:
        notes.append(
            f"lengths from the lenses are off by {found.scale - 1:+.1%}: are the squares of --board right?"
        )
    if found.distances.rmse_mm > FLEXIBLE_MM:
        notes.append(
            f"the board's lengths are off by {found.distances.rmse_mm:.1f} mm: "
            "is it flat, are the cameras in step?"
        )
    return notes


def summary(found: BoardCalibration) -> str:
    """A line per camera, then the board's own lengths."""
    lines = [
        f"{camera.name}: {np.isfinite(found.residual[:, i]).sum()} corners, {found.rms[i]:.2f} px RMS, "
        f"at {', '.join(f'{x:.3f}' for x in camera.center)} m"
        for i, camera in enumerate(found.cameras)
    ]
    apart = found.distances
    return "\n".join(
        [
            *lines,
            f"board: lengths off by {apart.rmse_mm:.2f} mm RMS over {len(apart.printed)} pairs of corners, "
            f"{found.rejected} sightings rejected",
        ]
    )


def _as_json(found: BoardCalibration, notes: Sequence[str]) -> str:
    names = [camera.name for camera in found.cameras]
    cameras = {
        camera.name: {
            "rotation": camera.rotation.tolist(),
            "translation": camera.translation.tolist(),
            "center": camera.center.tolist(),
            "corners": int(np.isfinite(found.residual[:, i]).sum()),
            "rms_px": float(found.rms[i]),
        }
        for i, camera in enumerate(found.cameras)
    }
    pairs = [
        {"cameras": [names[a], names[b]], "moments": relation.moments, "shared": relation.shared}
        for (a, b), relation in found.pairs.items()
    ]
    return json.dumps(
        {
            "cameras": cameras,
            "pairs": pairs,
            "rigidity_rmse_mm": found.distances.rmse_mm,
            "distances": len(found.distances.printed),
            "rejected": found.rejected,
            "scale": found.scale,
            "warnings": notes,
        }
    )


def _progress(what: str, share: float) -> None:
    print(f"\r\x1b[K{what} {share:.0%}", end="", file=sys.stderr, flush=True)


def _clear() -> None:
    if sys.stderr.isatty():
        print("\r\x1b[K", end="", file=sys.stderr)
