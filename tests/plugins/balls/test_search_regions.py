"""Search circles and search spheres around the forecast (Jin & Qian 2008, section 3.3)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.plugins.balls.scene import RADIUS, forecast_at
from tests.plugins.balls.verified_pairs import BALL, ROOM, named

from followspot.context import Context
from followspot.geometry import project
from followspot.message_checks.sealing import seal
from followspot.messages import Array
from followspot.room import Camera, LensModel
from followspot.tracking import Forecast
from followspot_balls.detection.search_circles import search_circles, search_radius
from followspot_balls.detection.search_spheres import search_spheres
from followspot_balls.search_gate import SearchGate
from followspot_balls.triangulate import Triangulate
from followspot_balls.verify_pairs import VerifyPairs


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
