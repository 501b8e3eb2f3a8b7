"""Intermediate results that a graph recorded: fused positions before the filter, and their candidates."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from followspot.files import open_text
from followspot.frame_times import NANOSECOND
from followspot.messages import Array
from followspot.room import Camera
from followspot.tracking import TRACKED
from followspot_accuracy import TrackTable

POSITIONS = "positions.jsonl"
"""Messages `Positions` in a run's output folder."""
CANDIDATES = "candidates.jsonl"
"""Messages `Candidates`, likewise."""
PAIRS = "pairs.jsonl"
"""Messages `Pairs`, likewise."""


@dataclass(frozen=True, eq=False)
class Fused:
    """Positions as the fusion gave them, and the (N,) steps that each took."""

    tracks: TrackTable
    iterations: Array


def read_fused(folder: Path, tracks: TrackTable, objects: Sequence[str]) -> Fused | None:
    """Fused positions of those targets and frames that have a track; None if none were recorded."""
    time, target, xyz, steps = [], [], [], []
    for message in _messages(folder / POSITIONS):
        for row in message["rows"]:
            time.append(message["time"])
            target.append(objects.index(row["object"]))
            xyz.append([row["x"], row["y"], row["z"]])
            steps.append(row["iterations"])
    if not time:
        return None
    stamp, number = np.array(time, "i8"), np.array(target, "i4")
    kept = np.isin(keys(stamp, number), track_keys(tracks, objects))
    table = TrackTable(
        tuple(objects),
        stamp[kept] * NANOSECOND,
        number[kept],
        np.full(int(kept.sum()), TRACKED, "u1"),
        np.array(xyz, "f8")[kept],
    )
    return Fused(table, np.array(steps, "i4")[kept])


def detection_errors(
    folder: Path, tracks: TrackTable, objects: Sequence[str], cameras: Sequence[Camera]
) -> dict[str, Array]:
    """Distances from each target's reprojected tracks to the detections, px, over frames and cameras.

    In each camera the nearest blob counts that is part of a candidate of the target, as the 2D candidates
    of Jin & Qian 2008 are (section 4). Empty without candidates or tracks.
    """
    blobs = list(_blobs(folder / CANDIDATES, objects, [camera.name for camera in cameras]))
    if not blobs or not len(tracks.time):
        return {}
    time, target, camera, pixel = (np.array(column) for column in zip(*blobs, strict=True))
    key, known = keys(time, target), track_keys(tracks, objects)
    order = np.argsort(known)
    row = order[np.searchsorted(known[order], key).clip(max=len(known) - 1)]
    found = known[row] == key
    row, target, camera, pixel = row[found], target[found], camera[found], pixel[found]
    apart = np.linalg.norm(_images(cameras, camera, tracks.xyz[row]) - pixel, axis=1)
    view, index = np.unique(np.column_stack([row, camera]), axis=0, return_inverse=True)
    nearest = np.full(len(view), np.inf)
    np.minimum.at(nearest, index.ravel(), apart)
    owner = tracks.target[view[:, 0]]
    return {name: nearest[owner == tracks.objects.index(name)] for name in tracks.objects}


def pair_counts(folder: Path, tracks: TrackTable, objects: Sequence[str]) -> dict[str, Array]:
    """Number of pairs that may show each target, in each frame in which it has a track.

    These are the pairs of the final set of Jin & Qian 2008 (section 3.4), of which six cameras have 10 to
    18 for an object (section 4). Empty if none were recorded.
    """
    counts: Counter[int] = Counter()
    for message in _messages(folder / PAIRS):
        named = Counter(name for row in message["rows"] for name in row["targets"].split())
        for name, count in named.items():
            counts[int(keys(np.array(message["time"]), np.array(objects.index(name))))] += count
    if not counts:
        return {}
    number = np.array([counts[key] for key in track_keys(tracks, objects).tolist()], int)
    return {name: number[tracks.target == tracks.objects.index(name)] for name in tracks.objects}


def track_keys(tracks: TrackTable, objects: Sequence[str]) -> Array:
    """One number for time and target of each row of the tracks. Targets are numbered like `objects`."""
    number = np.array([objects.index(name) for name in tracks.objects], "i8")
    return keys(np.rint(tracks.time / NANOSECOND).astype("i8"), number[tracks.target])


def keys(time: Array, target: Array) -> Array:
    """One number for a time, ns, and a target; times are compared by the microsecond."""
    return np.asarray(np.rint(time / 1000).astype("i8") * 1000 + target)


def _images(cameras: Sequence[Camera], camera: Array, xyz: Array) -> Array:
    """Undistorted images of points (N, 3) m, each in the camera of that number: (N, 2) px."""
    P = np.array([c.projection for c in cameras])[camera]
    homogeneous = np.einsum("nij,nj->ni", P[:, :, :3], xyz) + P[:, :, 3]
    return np.asarray(homogeneous[:, :2] / homogeneous[:, 2:])


def _blobs(
    path: Path, objects: Sequence[str], cameras: Sequence[str]
) -> Iterator[tuple[int, int, int, tuple[float, float]]]:
    """Both ends of every candidate, once per target that it may belong to: time, target, camera, xy."""
    for message in _messages(path):
        for row in message["rows"]:
            for name in row["targets"].split():
                for end in "01":
                    xy = row[f"xy_{end}_0"], row[f"xy_{end}_1"]
                    yield message["time"], objects.index(name), cameras.index(row[f"view_{end}"]), xy


def _messages(path: Path) -> Iterator[dict[str, Any]]:
    if not path.exists():
        return
    with open_text(path) as lines:
        for line in lines:
            yield json.loads(line)
