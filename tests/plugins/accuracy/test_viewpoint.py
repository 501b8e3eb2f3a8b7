"""The viewpoint that directions and distances of persons are measured from."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from followspot.testing import tiny_room
from followspot_accuracy.scorings import viewpoint


def test_the_only_camera_is_the_viewpoint_and_several_have_the_origin() -> None:
    room = tiny_room()
    assert len(room.cameras) == 2
    np.testing.assert_array_equal(viewpoint(room), [0.0, 0.0])
    for name, camera in room.cameras.items():
        alone = replace(room, cameras={name: camera})
        np.testing.assert_array_equal(viewpoint(alone), camera.center[:2])
        assert np.any(camera.center[:2])
