"""A wand of two bulbs: the wrong length, no metres, bulbs that are taken for each other or are loose."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from tests.tools.calibrate.rooms import MadeRoom, wand_file, wand_of_two, waved_room

from followspot import Room
from followspot.cli.main import main
from followspot.errors import FollowspotError
from followspot.room_file import save
from followspot_calibrate.wand.diagnostics import warnings_of
from followspot_calibrate.wand.solving import solve

LENGTH = 0.5


@pytest.fixture(scope="module")
def wand() -> MadeRoom:
    return wand_of_two(waved_room(4, 200), LENGTH)


def test_the_right_length_is_not_told(wand):
    assert warnings_of(solve(wand.sightings, wand.cameras, "known", LENGTH), 1.0) == []


def test_known_centres_tell_a_wrong_length(wand, tmp_path, capsys):
    save(Room("studio", {camera.name: camera for camera in wand.cameras}), tmp_path / "room.yaml")
    points = wand_file(wand, tmp_path / "wand.csv")
    always = ["calibrate", "wand", "--points", str(points), "--room", str(tmp_path / "room.yaml"), "--json"]
    assert main([*always, "--length", "0.6", "-o", str(tmp_path / "new.yaml")]) == 0
    told = json.loads(capsys.readouterr().out)["warnings"]
    assert told[0].startswith("the wand says that lengths are 1.2")
    assert told[0].endswith("check --length")


@pytest.mark.parametrize("length", [500.0, 0.005])
def test_lengths_in_millimetres_or_such_are_told(wand, length):
    told = warnings_of(solve(wand.sightings, wand.cameras, "known", length), 1.0)
    assert "m from their middle: is --length in metres?" in told[-1]


def test_a_camera_with_the_bulbs_the_wrong_way_round_is_named(wand):
    pixel = wand.sightings.pixel.copy()
    pixel[:, 2] = np.roll(pixel[:, 2], 200, axis=0)
    with pytest.raises(
        FollowspotError, match=r"^cam2 takes the two bulbs .* exchange 0 and 1 of the column point"
    ):
        solve(replace(wand.sightings, pixel=pixel), wand.cameras, "known", LENGTH)


def test_bulbs_taken_for_each_other_now_and_then_are_told(wand):
    pixel = wand.sightings.pixel.copy()
    wrong = np.tile(np.random.default_rng(1).random(200) < 0.15, 2)
    pixel[wrong, 1] = np.roll(pixel[:, 1], 200, axis=0)[wrong]
    solved = solve(replace(wand.sightings, pixel=pixel), wand.cameras, "known", LENGTH)
    told = warnings_of(solved, 1.0)
    assert len(told) == 1
    assert told[0].startswith("cam1 takes the bulbs of the wand for each other in 1")


def test_a_wand_that_is_not_rigid_is_told():
    loose = wand_of_two(waved_room(4, 200), LENGTH, spread=0.1)
    told = warnings_of(solve(loose.sightings, loose.cameras, "known", LENGTH), 1.0)
    assert "the wand is 500 mm long, but measured that within" in " ".join(told)
