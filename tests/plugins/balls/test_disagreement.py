"""A run whose cameras contradict each other about targets says so at its end."""

from dataclasses import replace

import numpy as np
import pytest
from tests.plugins.balls.epipolar_pairs import NO, YES, candidates
from tests.plugins.balls.scene import RADIUS, blobs_of, forecast_at, make_room

from followspot.context import Context
from followspot.message_checks.sealing import seal
from followspot_balls.pairs.disagreement import EACH, Disagreement
from followspot_balls.triangulate import Triangulate
from followspot_balls.verify_pairs import VerifyPairs


def told(epipolar: list[float], tracked: np.ndarray = YES, frames: int = 50 * EACH) -> str:
    judge = Disagreement()
    for _ in range(frames):
        if judge.due():
            judge.add(candidates(epipolar), tracked)
    return judge.warning()


def test_cameras_that_contradict_each_other_are_told_with_the_remedy():
    text = told([0.3, 0.5, 0.5, 0.5, 0.9])
    assert "by 0.50 px" in text
    assert "7 % of a target's width" in text
    assert "followspot calibrate refine" in text


@pytest.mark.parametrize("epipolar", [[0.1, 0.15, 0.2, 0.2, 0.2], [0.1, 0.15, 0.2, 3.0, 3.0]])
def test_well_calibrated_cameras_are_not_blamed_for_targets_that_are_hidden_in_part(epipolar):
    assert told(epipolar) == ""


def test_pairs_of_a_target_that_is_sought_tell_nothing():
    assert told([0.9] * 5, tracked=NO) == ""


def test_a_few_frames_are_no_reason_to_warn():
    assert told([0.9] * 5, frames=3 * EACH) == ""
    assert Disagreement().warning() == ""


@pytest.mark.parametrize(("shown", "warns"), [(1.0, True), (0.85, True), (0.7, False)])
def test_pairs_of_covered_balls_are_no_sign_of_a_wrong_calibration(shown: float, warns: bool) -> None:
    """Blobs of two cameras are a pixel too low; of a ball that shows less, that is what covers it."""
    room, ball, told = make_room(), (0.1, 0.2, 1.2), list[str]()
    verify, triangulate = VerifyPairs(Context(room=room)), Triangulate(Context(room=room, warn=told.append))
    verify.setup()
    triangulate.setup()
    blobs = []
    for number, camera in enumerate(room.cameras.values()):
        found = blobs_of(camera, [ball], [[True, False]])
        whole = np.pi * (camera.matrix[0, 0] * RADIUS / np.linalg.norm(np.array(ball) - camera.center)) ** 2
        low = found.xy + np.array([0.0, number % 2])
        blobs.append(seal(replace(found, xy=low, area=np.full(1, shown * whole))))
    pairs, there = seal(verify.process(tuple(blobs))), forecast_at([ball, (-1.0, 0.0, 0.5)])
    for _ in range(60 * EACH):
        triangulate.process(pairs, there)
    triangulate.close()
    assert any("contradict each other" in text for text in told) == warns
