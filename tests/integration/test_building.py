"""Balls that cross from one zone of a building to another keep identity and place, against the truth."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

import followspot as fs
from followspot.context import Context
from followspot.messages import Array
from followspot.plugins.registry import load_stage
from followspot.room_file import load
from followspot.tracking import Truth

GRAPHS = Path(__file__).parents[2] / "graphs"
ROOM = load(GRAPHS / "rooms/building.yaml")
NAMES = list(ROOM.targets)


def truth(frames: int) -> Array:
    """The true places of all targets, (F, T, 3) m."""
    assert ROOM.truth is not None
    params = {**ROOM.truth.params, "frames": frames}
    stage = load_stage(ROOM.truth.uses)(Context("truth", ROOM), **params)
    stage.setup()
    found = np.full((frames, len(NAMES), 3), np.nan)
    for message in stage.process():
        assert isinstance(message, Truth)
        found[message.header.seq, [NAMES.index(name) for name in message.objects]] = message.xyz
    return found


def places(path: Path, frames: int, states: tuple[str, ...] = ("tracked", "predicted")) -> Array:
    """The places of targets in these states in a file, (F, T, 3) m; NaN for targets that are not there."""
    found = np.full((frames, len(NAMES), 3), np.nan)
    with path.open(encoding="utf-8") as lines:
        for row in csv.DictReader(lines):
            if row["state"] in states:
                found[int(row["frame"]), NAMES.index(row["object"])] = [float(row[axis]) for axis in "xyz"]
    return found


def from_others(found: Array, true: Array) -> Array:
    """Distances of places from the nearest other ball, (F, T) m."""
    distance = np.linalg.norm(found[:, :, None] - true[:, None], axis=3)
    own = np.eye(len(NAMES), dtype=bool)
    return np.asarray(np.where(own, np.inf, distance).min(axis=2))


def jump(merged: Array, zones: Sequence[Array], true: Array) -> Array:
    """Distances by which merged places move otherwise than a zone that goes on, (F - 1, T) m.

    Without such a zone: otherwise than the truth. Errors of a zone are its own, and no jump of the merging.
    """
    steps = np.array([np.diff(zone, axis=0) for zone in zones])
    steps = np.where(np.isnan(steps).all(axis=0), np.diff(true, axis=0), steps)
    return np.asarray(np.nanmin(np.linalg.norm(np.diff(merged, axis=0) - steps, axis=3), axis=0))


@pytest.mark.filterwarnings("error:.*each works alone")
@pytest.mark.parametrize("frames", [120, pytest.param(1200, marks=pytest.mark.thorough)])
def test_merged_tracks_are_where_the_balls_are(tmp_path: Path, frames: int) -> None:
    with fs.run(GRAPHS / "building.yaml", out=tmp_path, frames=frames) as run:
        run.wait()
    true = truth(frames)
    hall, stage, merged = (places(tmp_path / f"{name}.csv", frames) for name in ("hall", "stage", "tracks"))
    in_hall, in_stage, known = (~np.isnan(found[..., 0]) for found in (hall, stage, merged))
    np.testing.assert_array_equal(known, in_hall | in_stage)
    error = np.linalg.norm(merged - true, axis=2)
    assert np.sqrt(np.nanmean(error**2)) < 0.008
    assert (error[known] < from_others(merged, true)[known]).all(), "no ball is taken for another"
    seen = places(tmp_path / "tracks.csv", frames, ("tracked",))
    assert np.nanmax(np.linalg.norm(seen - true, axis=2)) < 0.1
    begun_or_ended = (in_hall[1:] != in_hall[:-1]) | (in_stage[1:] != in_stage[:-1])
    handed_over = begun_or_ended & known[1:] & known[:-1]
    assert handed_over.sum() >= 3
    jumps = jump(merged, (hall, stage), true)[handed_over]
    assert jumps.max() < 0.002
