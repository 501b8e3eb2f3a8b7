"""Nothing is said of rooms and recordings with which nothing is wrong."""

from __future__ import annotations

import json

import pytest
from tests.datasets import dataset, needs_data
from tests.tools.calibrate.rooms import camera_of, made_room, off_by, waved_room

from followspot_calibrate.points_file import read_points
from followspot_calibrate.wand.diagnostics import warnings_of
from followspot_calibrate.wand.solving import Solved, solve


@pytest.mark.parametrize(("cameras", "missing"), [(3, 0.1), (6, 0.6)])
@pytest.mark.parametrize("make", [made_room, waved_room])
def test_a_clean_room(make, cameras, missing):
    room = make(cameras, 300, missing=missing, noise=0.4)
    solved = solve(room.sightings, room.cameras)
    assert warnings_of(solved, 1.0) == []
    assert solved.intrinsics == "known"


@pytest.mark.parametrize(
    ("cameras", "missing", "outliers"),
    [(3, 0.3, 0.1), (6, 0.6, 0.3), pytest.param(10, 0.1, 0.3, marks=pytest.mark.thorough)],
)
def test_reflections_are_all_that_is_told_of_a_room_full_of_them(cameras, missing, outliers):
    room = waved_room(cameras, 600, missing=missing, outliers=outliers)
    solved = solve(room.sightings, room.cameras)
    assert not solved.timed.late.any()
    assert off_by(solved.adjusted.cameras, room.cameras)[0].max() < 14
    assert all("fit no other camera" in text for text in warnings_of(solved, 1.0))


@needs_data("selfcal-mcsc-2010")
@pytest.mark.thorough
def test_the_recording_of_the_old_toolbox():
    told = quiet(solve(read_points(dataset("selfcal-mcsc-2010")), None))
    assert all("focal length" in text for text in told)


@needs_data("glowballs-dev")
@pytest.mark.parametrize("intrinsics", ["auto", pytest.param("free", marks=pytest.mark.thorough)])
def test_the_rendered_room(intrinsics):
    folder = dataset("glowballs-dev")
    given = json.loads((folder / "calibration.json").read_text())["cameras"]
    lenses = [camera_of(one["name"], (320, 240), one) for one in given]
    told = quiet(solve(read_points(folder / "wand/points.csv", lenses), lenses, intrinsics))
    assert all("focal length" in text for text in told)


def quiet(solved: Solved) -> list[str]:
    """The warnings of a calibration in which no camera is late."""
    assert not solved.timed.late.any()
    assert not solved.timed.drift.any()
    return warnings_of(solved)
