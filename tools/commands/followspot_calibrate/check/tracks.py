"""Sightings from an ordinary tracking run: the blobs of tracked targets."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from followspot import Room
from followspot.errors import InputError
from followspot.geometry import Views
from followspot.messages import Array
from followspot_accuracy import read_tracks_csv
from followspot_calibrate.tracked import SIGHTINGS, Tracked, in_order, in_room, moments_at, read_blobs

REACH = 0.03
"""Largest distance of a blob from its target's image over the longer side of the picture."""
TRACKS = "tracks.csv"
"""Name of the file with tracks there."""
FILES = ("blobs.csv", SIGHTINGS)
"""Names of files with blobs in a run's folder."""


@dataclass(frozen=True, eq=False)
class TargetSightings:
    """Sightings of targets.

    time: (N,) s; target: (N,) numbers in the order of the room; pixel: (N, C, 2) px with distortion, NaN
    if not seen.
    """

    time: Array
    target: Array
    pixel: Array


def read_run(folder: Path, room: Room, otherwise: str) -> Tracked:
    """Tracks and blobs of a run's output folder. Raises InputError if one is missing or wrong.

    otherwise: what the user of the command may do where the run wrote no blobs.
    """
    blobs = next((folder / name for name in FILES if (folder / name).is_file()), None)
    if blobs is None:
        remedy = (
            "add a stage to the graph: blobs: {uses: sinks.csv, in: {blobs: [color, infrared]}, "
            f"with: {{path: blobs.csv}}}}; or {otherwise}"
        )
        raise InputError.of(f"{folder} has no {FILES[0]}", remedy)
    table = read_tracks_csv(folder / TRACKS)
    targets = tuple(room.targets)
    strange = [name for name in table.objects if name not in targets]
    if strange:
        text = f"{folder / TRACKS} has a target {strange[0]}, which the room does not have"
        raise InputError.of(text, "give the room file that the run used")
    return Tracked(in_room(table, targets), read_blobs(blobs, tuple(room.cameras), targets))


def target_sightings(tracked: Tracked, room: Room) -> TargetSightings:
    """For each moment of a tracked target its blob in each camera, if the match is unambiguous.

    Two blobs near the target's image, such as a ball and the light behind it, count as none.
    """
    cameras = list(room.cameras.values())
    time, target, xyz = in_order(tracked.tracks)
    moment = moments_at(time, target, tracked.blobs)
    expected = Views(cameras).project_local(Views(cameras).local(xyz))
    reach = REACH * np.array([max(camera.size) for camera in cameras])
    known = np.flatnonzero(moment >= 0)
    row, camera, place = moment[known], tracked.blobs.camera[known], tracked.blobs.pixel[known]
    near = np.linalg.norm(expected[camera, row] - place, axis=1) < reach[camera]
    row, camera, place = row[near], camera[near], place[near]
    pixel = np.full((len(time), len(cameras), 2), np.nan)
    pixel[row, camera] = place
    candidates = np.zeros(pixel.shape[:2], int)
    np.add.at(candidates, (row, camera), 1)
    pixel[candidates > 1] = np.nan
    order = np.argsort(time, kind="stable")
    return TargetSightings(time[order], target[order], pixel[order])
