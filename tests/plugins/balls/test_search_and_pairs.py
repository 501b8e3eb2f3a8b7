"""Search regions, pair verification and candidates (Jin & Qian 2008, sections 3.3 to 3.5)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.plugins.balls.scene import RADIUS, blobs_of, forecast_at, make_room

from followspot.context import Context
from followspot.geometry import project
from followspot.message_checks.sealing import seal
from followspot.messages import Array
from followspot.room import Camera, LensModel, Room
from followspot.tracking import LOST, MISSING, TRACKED, Blobs, Forecast, Pairs
from followspot_balls.detection.search_circles import search_circles, search_radius
from followspot_balls.detection.search_spheres import search_spheres
from followspot_balls.pairs.blob_pairs import homography_test
from followspot_balls.pairs.three_views import threefold
from followspot_balls.pairs.two_view_geometry import fundamental_stack
from followspot_balls.scene.bounding_planes import facing_planes
from followspot_balls.search_gate import SearchGate
from followspot_balls.triangulate import Triangulate
from followspot_balls.verify_pairs import VerifyPairs

ROOM = make_room()
BALL = (0.1, 0.2, 1.0)


def verify(blobs: dict[str, list[tuple[float, float, float]]], **params: float) -> Pairs:
    """Pairs of exact blobs of red points in the named cameras, an infrared one serving both targets."""
    stage = VerifyPairs(Context(room=ROOM), **params)
    stage.setup()
    return stage.process(tuple(named(ROOM, n, p) for n, p in blobs.items()))


def named(room: Room, name: str, places: list[tuple[float, float, float]]) -> Blobs:
    camera = room.cameras[name]
    return blobs_of(camera, places, [[True, camera.kind == "infrared"]] * len(places))


def views(pairs: Pairs) -> list[list[int]]:
    return pairs.view.tolist()


def test_search_radius_is_10_px_or_one_and_a_half_times_the_travel() -> None:
    travel = np.array([0.0, 10.0, 10.1, 20.0, np.nan])
    assert search_radius(travel, 10.0, 1.5) == pytest.approx([10.0, 10.0, 15.15, 30.0, 10.0])


@pytest.mark.parametrize(("across", "radius"), [(160, 10.0), (320, 10.0), (1280, 40.0)])
def test_the_smallest_search_circle_grows_with_pictures_above_320_px(across: int, radius: float) -> None:
    """Else a target that begins fast is found in one frame and lost in the next one, again and again."""
    camera = replace(ROOM.cameras["cam0"], size=(across, across // 2))
    room = replace(ROOM, cameras={"cam0": camera})
    found = search_circles(room, "cam0", forecast_at([BALL, BALL]), 10.0, 1.5)
    assert found.radius == pytest.approx([radius, radius])


LENSES: dict[str, tuple[LensModel, list[float]]] = {
    "straight": ("pinhole", [0.0] * 5),
    "barrel": ("pinhole", [-0.26, 0.08, 0.0, 0.0, -0.01]),
    "fisheye": ("fisheye", [0.02, -0.01, 0.003, -0.001]),
    "panorama": ("cylinder", []),
}


@pytest.mark.parametrize("angle", [0.0, 25.0, 50.0])
@pytest.mark.parametrize("lens", LENSES)
def test_the_ball_in_a_search_circle_is_as_large_as_its_outline_aside_of_the_axis(
    lens: str, angle: float
) -> None:
    """Its mean semi-axis, that of a circle as long as the outline, whichever way the lens stretches it."""
    model, distortion = LENSES[lens]
    camera = replace(ROOM.cameras["cam0"], model=model, distortion=np.array(distortion), size=(1000, 1000))
    room = replace(ROOM, cameras={"cam0": camera})
    aside, ahead = np.array([np.sin(np.radians(angle)), np.cos(np.radians(angle))])
    for way in (0.0, 0.8, np.pi / 2):
        place = (
            camera.center
            + 2.0 * np.array([aside * np.cos(way), aside * np.sin(way), ahead]) @ camera.rotation
        )
        found = search_circles(room, "cam0", forecast_at([tuple(place), BALL]), 10.0, 1.5)
        assert found.ball[0] == pytest.approx(mean_semi_axis(camera, place), rel=0.02)


def test_a_lost_ball_that_a_wide_straight_lens_stretches_makes_a_candidate() -> None:
    """Two cameras look straight down, and a ball is 55 degrees off their axes: five times as large."""
    down = np.diag([1.0, -1.0, -1.0])
    K = np.array([[150.0, 0.0, 400.0], [0.0, 150.0, 400.0], [0.0, 0.0, 1.0]])
    cameras = {
        name: replace(
            ROOM.cameras[name],
            **{"size": (800, 800), "matrix": K, "distortion": np.zeros(5), "rotation": down},
            translation=-down @ np.array([0.0, y, 3.0]),
        )
        for name, y in (("cam0", 0.5), ("cam2", -0.5))
    }
    room, place = replace(ROOM, cameras=cameras, planes={}), (2.85, 0.0, 1.0)
    verify, triangulate = VerifyPairs(Context(room=room)), Triangulate(Context(room=room))
    verify.setup()
    triangulate.setup()
    blobs = [named(room, name, [place]) for name in cameras]
    for stretch, count in ((1 / np.cos(np.radians(55.0)) ** 3, 1), (12.0, 0)):
        distance2 = 2.0**2 + 2.85**2 + 0.5**2
        area = np.full(1, stretch * np.pi * (150.0 * RADIUS) ** 2 / distance2)
        pairs = verify.process(tuple(seal(replace(b, area=area)) for b in blobs))
        assert len(triangulate.process(seal(pairs)).xyz) == count


def mean_semi_axis(camera: Camera, place: Array) -> float:
    """Half the mean of the longest and the shortest width of a ball's outline there, px."""
    ray = (place - camera.center) / np.linalg.norm(place - camera.center)
    square = np.linalg.svd(ray[None])[2][1:]
    turn = np.linspace(0, 2 * np.pi, 180, endpoint=False)
    rim = project(camera, place + RADIUS * np.stack([np.cos(turn), np.sin(turn)], axis=1) @ square)
    width = np.linalg.norm(rim[:90] - rim[90:], axis=1)
    return float(width.max() + width.min()) / 4


def test_search_circle_lies_on_the_reprojected_forecast() -> None:
    camera = ROOM.cameras["cam0"]
    forecast = forecast_at([BALL, (0.0, 0.0, 0.5)])
    circles = search_circles(ROOM, "cam0", forecast, 10.0, 1.5)
    assert circles.center == pytest.approx(project(camera, forecast.xyz))
    assert not circles.lost.any()
    # 150 px * 7.62 cm / about 3.5 m
    assert circles.ball == pytest.approx([3.3, 3.0], abs=0.4)


@pytest.mark.parametrize(("gap", "beside"), [(0.5, True), (2.0, True), (2.4, True), (2.6, False)])
def test_targets_are_beside_each_other_if_one_may_cover_a_part_of_the_other(gap: float, beside: bool) -> None:
    camera = ROOM.cameras["cam0"]
    places = np.array(BALL) + camera.rotation[0] * RADIUS * np.array([[0.0], [gap]])
    circles = search_circles(ROOM, "cam0", forecast_at(list(map(tuple, places))), 10.0, 1.5)
    assert circles.beside.tolist() == [beside, beside]


@pytest.mark.parametrize("forecast", [None, Forecast.empty()])
def test_without_a_forecast_every_target_is_sought_everywhere(forecast: Forecast | None) -> None:
    circles = search_circles(ROOM, "cam0", forecast, 10.0, 1.5)
    assert circles.lost.all()
    assert not circles.beside.any()


def test_search_spheres_have_22_cm_or_twice_the_last_displacement() -> None:
    still = forecast_at([BALL, BALL])
    before = still.before.copy()
    before[1, 0] -= 0.2
    moved = Forecast(**{**vars(still), "before": before})
    assert search_spheres(moved, 0.225, 2.0) == pytest.approx([0.225, 0.4])


def test_gate_keeps_a_blob_for_each_target_in_whose_circle_it_lies() -> None:
    gate = SearchGate(Context(room=ROOM))
    gate.setup()
    blobs = named(ROOM, "cam1", [BALL, (1.2, 0.0, 0.0)])
    near = forecast_at([BALL, (0.1, 0.3, 1.0)])
    apart = forecast_at([BALL, (-1.0, 0.0, 1.0)])
    assert gate.process(blobs, near).targets.tolist() == [[True, True]]
    assert gate.process(blobs, apart).targets.tolist() == [[True, False]]
    assert len(gate.process(blobs, None).xy) == 2


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
