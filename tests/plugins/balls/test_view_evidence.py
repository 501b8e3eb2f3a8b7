"""Which places have an image in the picture of a camera."""

from __future__ import annotations

import numpy as np
from tests.plugins.balls.scene import SIZE, make_room
from tests.plugins.balls.sightings import BALL, EVERYWHERE, candidates_of, views
from tests.plugins.balls.test_associate import stage

from followspot.geometry import project


def test_a_place_is_in_a_picture_if_its_image_is_and_it_lies_before_the_camera() -> None:
    cameras = list(make_room().cameras.values())
    center, (aside, _, ahead) = cameras[0].center, cameras[0].rotation
    places = np.array([BALL, center - 2.0 * ahead, center + 0.5 * ahead, center + 2.0 * aside])
    evidence, found = stage().evidence, candidates_of(views({BALL: EVERYWHERE}))
    blobs = evidence.blobs(found, None, np.zeros(2, bool))
    sight, _ = evidence.sight(places, np.zeros(4, int), blobs)
    assert sight.inside[:, 0].tolist() == [True, False, True, False]
    seen = project(cameras[0], places[[0, 2]])
    assert ((seen > 0) & (seen < SIZE)).all()
