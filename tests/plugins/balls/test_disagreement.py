"""A run whose cameras contradict each other about targets says so at its end."""

import numpy as np
import pytest

from followspot.tracking import Candidates
from followspot_balls.disagreement import EACH, Disagreement

WIDTH = 7.0
BALL = np.pi / 4 * WIDTH**2
YES, NO = np.array([True, False]), np.array([False, True])


def candidates(epipolar: list[float]) -> Candidates:
    """Pairs of the first of two targets with these epipolar distances, px; blobs are 7 px wide."""
    count = len(epipolar)
    return Candidates(
        cameras=("cam0", "cam1"),
        xyz=np.zeros((count, 3)),
        view=np.tile(np.array([0, 1], np.int32), (count, 1)),
        blob=np.zeros((count, 2), np.int32),
        xy=np.zeros((count, 2, 2)),
        area=np.full((count, 2), BALL),
        epipolar=np.array(epipolar),
        labelled=np.ones(count, bool),
        confirmed=np.ones(count, bool),
        evident=np.ones(count, bool),
        targets=np.tile(YES, (count, 1)),
    )


def told(epipolar: list[float], tracked: np.ndarray = YES, frames: int = 50 * EACH) -> str:
    judge = Disagreement()
    for _ in range(frames):
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
