"""Pairs of blobs of two views, and the homography test (Jin & Qian 2008, section 3.4)."""

from __future__ import annotations

import numpy as np
import pytest
from tests.plugins.balls.scene import blobs_of
from tests.plugins.balls.verified_pairs import BALL, ROOM, named, verify, views

from followspot.context import Context
from followspot.message_checks.sealing import seal
from followspot.tracking import Blobs
from followspot_balls.pairs.blob_pairs import homography_test
from followspot_balls.pairs.two_view_geometry import fundamental_stack
from followspot_balls.verify_pairs import VerifyPairs


def test_one_point_makes_a_pair_in_every_two_views_with_its_labels() -> None:
    pairs = verify({n: [BALL] for n in ROOM.cameras})
    assert views(pairs) == [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]]
    assert pairs.labelled.tolist() == [True, True, True, True, False, True]
    assert pairs.confirmed.tolist() == [True, False, True, True, False, True]
    assert pairs.epipolar == pytest.approx(np.zeros(6), abs=1e-6)
    assert pairs.targets[0].tolist() == [True, False]
    assert pairs.targets[4].tolist() == [True, True]


def test_blobs_of_different_targets_are_never_paired() -> None:
    stage = VerifyPairs(Context(room=ROOM))
    stage.setup()
    red = blobs_of(ROOM.cameras["cam0"], [BALL], [[True, False]])
    green = blobs_of(ROOM.cameras["cam2"], [BALL], [[False, True]])
    assert len(stage.process((red, green)).view) == 0


@pytest.mark.parametrize(("offset", "kept"), [(2.9, 1), (3.1, 0)])
def test_pairs_3_px_off_the_epipolar_line_are_rejected(offset: float, kept: int) -> None:
    stage = VerifyPairs(Context(room=ROOM))
    stage.setup()
    one, other = named(ROOM, "cam0", [BALL]), named(ROOM, "cam1", [BALL])
    line = fundamental_stack(ROOM)[0, 1] @ np.append(one.xy[0], 1.0)
    back = fundamental_stack(ROOM)[0, 1].T @ np.append(other.xy[0], 1.0)
    slope = np.hypot(*line[:2])
    scale = min(1.0, np.hypot(*back[:2]) / slope)  # the larger of both distances counts
    moved = Blobs(**{**vars(other), "xy": other.xy + offset * scale * line[:2] / slope})
    assert len(stage.process((one, seal(moved))).view) == kept


def test_projection_on_floor_is_rejected_unless_infrared_confirms_it() -> None:
    spot = [(0.3, -0.2, 0.0)]
    assert len(verify({"cam0": spot, "cam2": spot}).view) == 0
    with_infrared = verify({"cam0": spot, "cam1": spot, "cam2": spot})
    assert views(with_infrared) == [[0, 1], [0, 2], [1, 2]]


def test_a_point_above_the_floor_passes_the_homography_test() -> None:
    assert views(verify({"cam0": [BALL], "cam2": [BALL]})) == [[0, 2]]


def test_the_homography_test_can_be_switched_off() -> None:
    spot = [(0.3, -0.2, 0.0)]
    assert len(verify({"cam0": spot, "cam2": spot}, homography_tolerance=0.0).view) == 1


def test_list_b_excuses_only_pairs_that_share_the_confirmed_color_blob() -> None:
    # blobs 0, 1: colour camera a; 2, 3: colour camera b; 4: infrared
    pair = np.array([[0, 2], [1, 3], [0, 4]])
    color = np.array([[True, True], [True, True], [True, False]])
    on_plane = np.array([[True, True, True]])
    assert homography_test(pair, color, on_plane, 5).tolist() == [True, False, True]
    # the confirmed blob may be that of either camera
    assert homography_test(np.array([[0, 2], [1, 3], [2, 4]]), color, on_plane, 5).tolist() == [
        True,
        False,
        True,
    ]


def test_pairs_with_an_infrared_camera_on_a_plane_are_no_projections() -> None:
    pair = np.array([[0, 2], [3, 4]])
    color = np.array([[True, False], [False, False]])
    assert homography_test(pair, color, np.array([[True, True]]), 5).tolist() == [True, True]


def test_list_b_of_one_plane_does_not_excuse_another() -> None:
    pair = np.array([[0, 2], [0, 4]])
    color = np.array([[True, True], [True, False]])
    on_plane = np.array([[True, False], [False, True]])
    assert homography_test(pair, color, on_plane, 5).tolist() == [False, True]
