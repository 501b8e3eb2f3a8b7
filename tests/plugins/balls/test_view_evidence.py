"""Which positions have an image in the picture of a camera."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from tests.plugins.balls.made_candidates import BALL, EVERYWHERE, candidates_of, stage, views
from tests.plugins.balls.scene import SIZE, make_room

from followspot.geometry import project, ray, undistort
from followspot_balls.association.view_evidence import ViewEvidence
from followspot_balls.association.view_params import ViewParams


def test_a_place_is_in_a_picture_if_its_image_is_and_it_lies_before_the_camera() -> None:
    cameras = list(make_room().cameras.values())
    center, (aside, _, ahead) = cameras[0].center, cameras[0].rotation
    places = np.array([BALL, center - 2.0 * ahead, center + 0.5 * ahead, center + 2.0 * aside])
    evidence, found = stage().evidence, candidates_of(views({BALL: EVERYWHERE}))
    blobs = evidence.blobs(found, None, np.zeros(2, bool))
    residuals, _ = evidence.residuals(places, np.zeros(4, int), blobs)
    assert residuals.in_picture[:, 0].tolist() == [True, False, True, False]
    seen = project(cameras[0], places[[0, 2]])
    assert ((seen > 0) & (seen < SIZE)).all()


def test_a_place_that_a_distorted_picture_shows_at_its_border_is_in_it() -> None:
    """Barrel distortion draws the border inwards: undistorted, such an image lies outside the picture."""
    room = make_room()
    first = room.cameras["cam0"]
    barrel = replace(first, distortion=np.array([-0.3, 0.1, 0.0, 0.0, -0.012]))
    border = np.array([[3.0, 60.0], [157.0, 60.0], [80.0, 119.0]])
    assert not ((undistort(barrel, border) >= 0) & (undistort(barrel, border) < SIZE)).all(axis=1).any()
    evidence = ViewEvidence(replace(room, cameras={**room.cameras, "cam0": barrel}), ViewParams())
    blobs = evidence.blobs(candidates_of(views({BALL: EVERYWHERE})), None, np.zeros(2, bool))
    residuals, _ = evidence.residuals(first.center + 2.0 * ray(barrel, border), np.zeros(3, int), blobs)
    assert residuals.in_picture[:, 0].all()
