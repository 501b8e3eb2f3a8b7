"""Balls that cross from one zone of a building to another keep identity and place, against the truth."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

import followspot as fs
from followspot.messages import Array
from followspot.plugins.registry import load_stage
from followspot.room_file import load
from followspot.stage import Context
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


def places(path: Path, frames: int) -> Array:
    """The tracked places in a file, (F, T, 3) m; NaN for targets that are not there."""
    found = np.full((frames, len(NAMES), 3), np.nan)
    with path.open(encoding="utf-8") as lines:
        for row in csv.DictReader(lines):
            found[int(row["frame"]), NAMES.index(row["object"])] = [float(row[axis]) for axis in "xyz"]
    return found


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
    assert np.nanmax(error) < 0.1  # no ball is taken for another: they are further apart
    begun_or_ended = (in_hall[1:] != in_hall[:-1]) | (in_stage[1:] != in_stage[:-1])
    handed_over = begun_or_ended & known[1:] & known[:-1]
    assert handed_over.sum() >= 3
    steps = np.linalg.norm(np.diff(merged - true, axis=0), axis=2)[handed_over]
    assert np.median(steps) < 0.002
    assert steps.max() < 0.02
