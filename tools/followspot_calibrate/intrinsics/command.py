"""What `followspot calibrate intrinsics` does."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from followspot import Camera, Room
from followspot.errors import FollowspotError, InputError, Mistake, did_you_mean
from followspot.room_file import load, save, update
from followspot_calibrate.boards.board import parse_board
from followspot_calibrate.boards.detection import Detector
from followspot_calibrate.boards.pictures import count, live_pictures, pictures, recordings
from followspot_calibrate.intrinsics.calibration import LensCalibration, calibrate_lens
from followspot_calibrate.intrinsics.collecting import Collected, collect
from followspot_calibrate.intrinsics.fitting import NoFit


def calibrate_intrinsics(args: argparse.Namespace) -> int:
    """Calibrate each camera, update the room file, report; returns the exit code.

    Raises FollowspotError for cameras without a result; the others are written.
    """
    if args.live == bool(args.videos or args.clip):
        raise InputError([Mistake(None, "give recordings (--videos, --clip) or --live, one of them")])
    if args.pictures < 1:
        raise InputError([Mistake(None, f"--pictures {args.pictures} is less than 1", "give 50 to 1000")])
    board = parse_board(args.board)
    room = load(args.room) if args.room.exists() else Room(args.room.stem)
    detector = Detector(board)
    done: dict[str, LensCalibration] = {}
    failed: dict[str, str] = {}
    for name, collected in _collected(args, room, detector):
        try:
            done[name] = calibrate_lens(name, collected.views, board, collected.size, args.model)
        except NoFit as error:
            failed[name] = f"{name}: {error} ({collected.looked_at} pictures searched)"
    notes = write(args.room, room, done) if done else {}
    print(_as_json(done, notes) if args.json else summary(done))
    if failed:
        remedy = f"\n    is --board {args.board} right? Hold the whole board still, in good light"
        raise FollowspotError("\n".join(failed.values()) + remedy)
    return 0


def _collected(args: argparse.Namespace, room: Room, detector: Detector) -> Sequence[tuple[str, Collected]]:
    """The views of each camera that is wanted. Raises InputError."""
    if args.live:
        chosen = args.camera or list(room.cameras)
        unknown = [name for name in chosen if name not in room.cameras]
        if unknown or not chosen:
            text = f'{args.room} has no camera "{unknown[0]}"' if unknown else f"{args.room} has no cameras"
            remedy = did_you_mean(unknown[0] if unknown else "", room.cameras, "cameras")
            raise InputError([Mistake(None, text, remedy)])
        return [(n, collect(n, live_pictures(room.cameras[n]), None, detector)) for n in chosen]
    found = recordings(args.videos, args.clip, args.camera)
    return [(name, _recorded(name, path, args.pictures, detector)) for name, path in found.items()]


def _recorded(name: str, path: Path, most: int, detector: Detector) -> Collected:
    """Views in a recording, of at most this many pictures, evenly spread."""
    total = count(path)
    chosen = range(0, max(total, 1), max(1, -(-total // most)))
    return collect(name, pictures(path, chosen), len(chosen), detector)


def write(path: Path, room: Room, done: Mapping[str, LensCalibration]) -> dict[str, list[str]]:
    """Put the lenses into the room file; returns what else the user should know of each camera.

    A new camera is a colour camera at the origin. Raises FollowspotError.
    """
    notes: dict[str, list[str]] = {name: list(lens.warnings) for name, lens in done.items()}
    cameras = dict(room.cameras)
    for name, lens in done.items():
        known = room.cameras.get(name) or Camera(
            name, "color", lens.size, np.eye(3), np.zeros(5), np.eye(3), np.zeros(3)
        )
        cameras[name] = replace(
            known, size=lens.size, matrix=lens.fit.matrix, distortion=lens.fit.distortion, model=lens.model
        )
        if name in room.cameras and known.translation.any():
            notes[name].append("its pose was found with another lens: calibrate board or wand again")
    try:
        if path.exists():
            update(path, cameras=cameras)
        else:
            path.parent.mkdir(parents=True, exist_ok=True)
            save(replace(room, cameras=cameras), path)
    except OSError as error:
        raise FollowspotError(f"{path} cannot be written: {error.strerror}") from None
    for name, texts in notes.items():
        for text in texts:
            print(f"warning: {name}: {text}", file=sys.stderr)
    return notes


def summary(done: Mapping[str, LensCalibration]) -> str:
    """A line and the coverage per camera."""
    return "\n".join(_lines(lens) for lens in done.values()) or "no lens was calibrated"


def _lines(lens: LensCalibration) -> str:
    found = lens.fit
    head = (
        f"{lens.camera}: {found.rms:.2f} px RMS in {len(found.views)} of {lens.seen} views, "
        f"focal {found.matrix[0, 0]:.1f} +- {found.sigma[0]:.1f} px, "
        f"covered {lens.coverage.share:.0%}, tilt {lens.tilt:.0f} deg"
    )
    left = [f"{len(x)} {word}" for x, word in ((lens.blurred, "blurred"), (lens.rejected, "outliers")) if x]
    return "\n".join([head + (f" ({', '.join(left)})" if left else ""), *lens.coverage.drawing()])


def _as_json(done: Mapping[str, LensCalibration], notes: Mapping[str, Sequence[str]]) -> str:
    return json.dumps({name: {**_fields(lens), "warnings": notes[name]} for name, lens in done.items()})


def _fields(lens: LensCalibration) -> dict[str, Any]:
    found = lens.fit
    return {
        "model": lens.model,
        "size": lens.size,
        "matrix": found.matrix.tolist(),
        "distortion": found.distortion.tolist(),
        "rms_px": found.rms,
        "views": [
            {"frame": view.frame, "corners": len(view.label), "rms_px": float(error)}
            for view, error in zip(found.views, found.per_view, strict=True)
        ],
        "seen": lens.seen,
        "blurred": lens.blurred,
        "rejected": lens.rejected,
        "sigma_focal_px": found.sigma[:2].tolist(),
        "sigma_center_px": found.sigma[2:4].tolist(),
        "tilt_deg": lens.tilt,
        "coverage": {
            "share": lens.coverage.share,
            "missing": lens.coverage.missing,
            "count": lens.coverage.count.tolist(),
        },
    }
