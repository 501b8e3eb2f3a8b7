"""Candidates that pairs become, and what they are evidence of (Jin & Qian 2008, section 3.5)."""

from __future__ import annotations

import numpy as np
import pytest
from tests.plugins.balls.scene import RADIUS, forecast_at
from tests.plugins.balls.verified_pairs import BALL, ROOM, verify

from followspot.context import Context
from followspot.message_checks.sealing import seal
from followspot.messages import Array
from followspot.room import Room
from followspot.tracking import LOST, MISSING, TRACKED, Forecast, Pairs
from followspot_balls.pairs.three_views import threefold
from followspot_balls.scene.bounding_planes import facing_planes
from followspot_balls.triangulate import Triangulate


def candidates_for(pairs: Pairs, forecast: Forecast | None) -> Array:
    stage = Triangulate(Context(room=ROOM))
    stage.setup()
    return stage.process(pairs, forecast)


def test_every_pair_becomes_the_point_that_made_it() -> None:
    pairs = verify({n: [BALL] for n in ROOM.cameras})
    found = candidates_for(pairs, forecast_at([BALL, BALL]))
    assert found.xyz == pytest.approx(np.tile(BALL, (6, 1)), abs=1e-6)
    assert found.labelled.tolist() == pairs.labelled.tolist()


@pytest.mark.parametrize(("distance", "kept"), [(0.22, 6), (0.23, 0)])
def test_candidates_outside_the_sphere_are_rejected(distance: float, kept: int) -> None:
    away = (BALL[0] + distance, BALL[1], BALL[2])
    pairs = verify({n: [BALL] for n in ROOM.cameras})
    assert len(candidates_for(pairs, forecast_at([away, (2.0, 2.0, 1.0)])).xyz) == kept


def test_an_unlabelled_candidate_serves_every_target_near_it() -> None:
    pairs = verify({"cam1": [BALL], "cam3": [BALL]})
    left, right = (BALL[0] + 0.1, BALL[1], BALL[2]), (BALL[0] - 0.1, BALL[1], BALL[2])
    assert candidates_for(pairs, forecast_at([left, right])).targets.tolist() == [[True, True]]
    assert candidates_for(pairs, forecast_at([BALL, (2.0, 2.0, 1.0)])).targets.tolist() == [[True, False]]


def test_two_balls_at_rest_17_cm_apart_keep_their_own_infrared_candidates() -> None:
    near = (BALL[0] + 0.17, BALL[1], BALL[2])
    both = verify({"cam1": [BALL, near], "cam3": [BALL, near]})
    found = candidates_for(both, forecast_at([BALL, near]))
    own = np.linalg.norm(found.xyz[:, None] - [BALL, near], axis=2) < 0.01
    assert own.any(axis=0).all()
    assert (found.targets[own.any(axis=1)] == own[own.any(axis=1)]).all()


def test_a_labelled_candidate_may_be_any_target_s_of_its_colour_near_it() -> None:
    pairs = verify({"cam0": [BALL], "cam1": [BALL]})
    near = (BALL[0] + 0.17, BALL[1], BALL[2])
    assert candidates_for(pairs, forecast_at([near, BALL])).targets[0, 0]


@pytest.mark.parametrize(("share", "evident"), [(0.31, False), (0.35, True)])
def test_a_pair_is_evident_where_both_blobs_show_a_third_of_the_ball(share: float, evident: bool) -> None:
    pairs = verify({"cam0": [BALL], "cam1": [BALL]})
    distance = np.array([np.linalg.norm(ROOM.cameras[n].center - BALL) for n in ("cam0", "cam1")])
    whole = np.pi * (150 * RADIUS / distance) ** 2
    for shares in ([share, 1.0], [1.0, share]):
        resized = seal(Pairs(**{**vars(pairs), "area": (whole * shares)[None]}))
        assert candidates_for(resized, None).evident.tolist() == [evident]


def test_a_pair_is_not_evident_if_another_colour_camera_shows_its_blob_to_be_light() -> None:
    spot, ball = (0.3, -0.2, 0.0), (0.3, -0.2, 0.0)
    ray = np.array(spot) - ROOM.cameras["cam0"].center
    behind = tuple(np.array(ball) - 0.3 * ray)  # on the same ray of cam0: the ball hides the spot there
    alone = verify({"cam0": [behind], "cam1": [behind]})
    lit = verify({"cam0": [behind], "cam1": [behind], "cam2": [spot]})
    assert alone.evident.tolist() == [True]
    assert lit.confirmed[(lit.view == [0, 1]).all(axis=1)].all()
    assert not lit.evident.any()


@pytest.mark.parametrize(("area", "kept"), [(2.0, 0), (28.0, 1), (120.0, 0)])
def test_a_lost_target_is_not_seen_in_blobs_of_the_wrong_size(area: float, kept: int) -> None:
    pairs = verify({"cam0": [BALL], "cam1": [BALL]})
    resized = seal(Pairs(**{**vars(pairs), "area": np.full((1, 2), area)}))
    assert len(candidates_for(resized, None).xyz) == kept


@pytest.mark.parametrize(
    ("shares", "kept"),
    [
        ((1.0, 0.45, 0.2), [[0, 1], [0, 2], [1, 2]]),
        ((1.0, 0.45, 0.05), [[0, 1], [0, 2], [1, 2]]),
        ((1.0, 0.3, 0.2), [[0, 1]]),
        ((1.0, 0.2, 0.2), []),
    ],
)
def test_a_third_view_may_show_little_of_a_lost_target_beside_an_evident_pair(
    shares: tuple[float, ...], kept: list[list[int]]
) -> None:
    # else a quarter of the outline; an evident pair shows a third to a colour and an infrared camera
    pairs = verify({name: [BALL] for name in ("cam0", "cam1", "cam2")})
    distance = np.array([np.linalg.norm(camera.center - BALL) for camera in ROOM.cameras.values()])
    area = np.pi * (150 * RADIUS / distance[:3]) ** 2 * shares
    resized = seal(Pairs(**{**vars(pairs), "area": area[pairs.view]}))
    assert candidates_for(resized, None).view.tolist() == kept


def test_three_blobs_confirm_each_other_only_if_each_makes_a_pair_with_both_others() -> None:
    pairs = verify({name: [BALL] for name in ("cam0", "cam1", "cam2")})
    first = (pairs.view == [0, 1]).all(axis=1)[:, None] & np.ones((1, 2), bool)
    all_three, two = np.ones_like(first), pairs.view[:, :1] == 0
    assert threefold(pairs, all_three, first).all()
    assert not threefold(pairs, two & all_three, first).any()
    assert not threefold(pairs, all_three, np.zeros_like(first)).any()
    other = first & [True, False]
    assert threefold(pairs, all_three, other).all(axis=0).tolist() == [True, False]
    blob = pairs.blob + (pairs.view == [1, 2]) * np.array([1, 0], np.int32)
    second = seal(Pairs(**{**vars(pairs), "blob": blob}))
    assert not threefold(second, all_three, first).any()  # another blob of the second camera


def test_numbers_that_no_blob_has_make_no_triangle() -> None:
    pairs = verify({name: [BALL] for name in ("cam0", "cam1")})
    none = {"view": np.zeros_like(pairs.view), "blob": pairs.blob + np.array([-1 << 31, -5], "i4")}
    strange = seal(Pairs(**{**vars(pairs), **none}))
    assert not threefold(strange, strange.targets, strange.targets).any()


@pytest.mark.parametrize(("distance", "kept"), [(0.0, 0), (0.08, 0), (0.4, 1)])
def test_infrared_light_of_a_tracked_target_is_no_evidence_of_a_lost_one(distance: float, kept: int) -> None:
    # 1.5 outlines of 7.6 cm belong to the tracked target
    other = (BALL[0], BALL[1] + distance, BALL[2])
    tracked = forecast_at([(9.0, 9.0, 1.0), other])
    forecast = Forecast(**{**vars(tracked), "state": np.array([LOST, TRACKED], np.uint8)})
    pairs = verify({"cam0": [BALL], "cam1": [BALL]})
    assert candidates_for(pairs, forecast).targets[:, 0].sum() == kept


@pytest.mark.parametrize(("height", "kept"), [(RADIUS, 1), (0.04, 1), (0.03, 0), (-0.2, 0)])
def test_a_ball_does_not_sink_into_the_floor(height: float, kept: int) -> None:
    # its centre stays one radius, 7.6 cm, above, less a tolerance of 4 cm
    place = (0.3, -0.2, height)
    pairs = verify({"cam0": [place], "cam1": [place]}, homography_tolerance=0.0)
    assert len(candidates_for(pairs, forecast_at([place, BALL])).xyz) == kept


@pytest.mark.parametrize("state", [LOST, MISSING])
@pytest.mark.parametrize(("height", "kept"), [(0.05, 1), (0.043, 0)])
def test_light_and_a_reflector_that_meet_in_the_floor_are_no_sought_ball(
    state: int, height: float, kept: int
) -> None:
    # what a tracked ball may sink by, 4 cm, is 3 cm for one that is not tracked
    place = (0.3, -0.2, height)
    known = forecast_at([place, BALL])
    pairs = verify({"cam0": [place], "cam1": [place]}, homography_tolerance=0.0)
    sought = Forecast(**{**vars(known), "state": np.array([state, TRACKED], np.uint8)})
    assert candidates_for(pairs, sought).targets[:, 0].sum() == kept
    assert candidates_for(pairs, known).targets[:, 0].sum() == 1


def test_a_plane_between_the_cameras_bounds_nothing() -> None:
    centers = np.array([c.center for c in ROOM.cameras.values()])
    room = Room("r", ROOM.cameras, {"floor": np.array([0, 0, -1.0, 0]), "door": np.array([1.0, 0, 0, 0])})
    assert facing_planes(room, centers).tolist() == [[0, 0, 1.0, 0]]
