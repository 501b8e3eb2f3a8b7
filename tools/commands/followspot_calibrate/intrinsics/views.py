"""Views of the board for each camera that is to be calibrated: recorded, or live."""

from __future__ import annotations

import argparse
import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from followspot import Camera
from followspot.errors import InputError, did_you_mean
from followspot.room import StageUse
from followspot_calibrate.boards.detection import Detector
from followspot_calibrate.boards.pictures import count, live_pictures, pictures, recordings
from followspot_calibrate.intrinsics.collecting import Collected, collect

_SIZE = re.compile(r"(\d{1,5})x(\d{1,5})")


def live_cameras(args: argparse.Namespace, known: Mapping[str, Camera]) -> dict[str, Camera]:
    """The live cameras: of --device, and with --live of the room. Raises InputError."""
    size = _SIZE.fullmatch(args.size)
    if size is None:
        raise InputError.of(f"--size {args.size} is no WIDTHxHEIGHT", "for example 1280x720")
    found = {}
    for text in args.device:
        name, _, device = text.partition("=")
        if not device:
            raise InputError.of(f"--device {text} is no CAMERA=DEVICE", "for example cam0=0")
        source = StageUse("cameras.device", {"device": int(device) if device.isdecimal() else device})
        found[name] = uncalibrated_camera(name, (int(size[1]), int(size[2])), source)
    if not args.live:
        return found
    chosen = args.camera or list(known)
    unknown = [name for name in chosen if name not in known]
    if unknown or not chosen:
        text = f'{args.room} has no camera "{unknown[0]}"' if unknown else f"{args.room} has no cameras"
        remedy = did_you_mean(unknown[0], known, "cameras") if unknown else "name one: --device cam0=0"
        raise InputError.of(text, remedy)
    return {**{name: known[name] for name in chosen}, **found}


def uncalibrated_camera(name: str, size: tuple[int, int], source: StageUse | None = None) -> Camera:
    """A colour camera at the origin with an unknown lens."""
    return Camera(name, "color", size, np.eye(3), np.zeros(5), np.eye(3), np.zeros(3), source=source)


def collect_views(
    args: argparse.Namespace, live: Mapping[str, Camera], detector: Detector
) -> dict[str, Collected]:
    """The views of each camera that is chosen. Raises InputError, also if one of them has no pictures."""
    recorded = recordings(args.videos, args.clip, args.camera) if args.videos or args.clip else {}
    given = [*live, *recorded]
    lacking = [name for name in args.camera if name not in given]
    if lacking:
        text = f"--camera {lacking[0]}: no pictures of it are given"
        raise InputError.of(text, did_you_mean(lacking[0], given, "cameras"))
    seen = {}
    for name in given:
        if args.camera and name not in args.camera:
            continue
        seen[name] = (
            collect(name, live_pictures(live[name]), None, detector)
            if name in live
            else _recorded(name, recorded[name], args.pictures, detector)
        )
    return seen


def _recorded(name: str, path: Path, most: int, detector: Detector) -> Collected:
    """Views in a recording, of at most this many pictures, evenly spread."""
    total = count(path)
    chosen = range(0, max(total, 1), max(1, -(-total // most)))
    return collect(name, pictures(path, chosen), len(chosen), detector)
