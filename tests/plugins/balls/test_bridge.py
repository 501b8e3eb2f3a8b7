"""A target that a single view still sees: where it is taken to be, and what is not taken for it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.plugins.balls.scene import RADIUS, blobs_of, forecast_at, make_room, positions_at

from followspot.context import Context
from followspot.messages import Array
from followspot.tracking import Blobs, Forecast, Positions
from followspot_balls.bridge import Bridge
from followspot_balls.single_view.position import projections

ROOM = make_room()
PLACE = (0.1, 0.2, 1.0)
FAR = (1.5, -1.5, 1.0)
UNMATCHED = positions_at({}, 0.0)

Point = tuple[float, float, float]


def bridged(positions: Positions, blobs: tuple[Blobs, ...], forecast: Forecast | None) -> Positions:
    stage = Bridge(Context(room=ROOM))
    stage.setup()
    return stage.process(positions, blobs, forecast)


def seen_in(name: str, place: Point) -> tuple[Blobs, ...]:
    """An exact blob of a red ball in one camera; the others see nothing."""
    camera = ROOM.cameras[name]
    targets = [[True, camera.kind == "infrared"]]
    return tuple(
        blobs_of(c, [place] if n == name else [], targets[: n == name]) for n, c in ROOM.cameras.items()
    )


def off_ray(camera: str, place: Array, point: Point) -> float:
    """Distance of a place from the viewing ray through a point, m."""
    center = ROOM.cameras[camera].center
    along = np.array(point) - center
    along /= np.linalg.norm(along)
    return float(np.linalg.norm(np.cross(place - center, along)))


@pytest.mark.parametrize("camera", ["cam0", "cam1"])
def test_one_view_corrects_the_forecast_across_its_ray_and_leaves_the_depth_to_it(camera: str) -> None:
    expected = (PLACE[0] + 0.01, PLACE[1] - 0.01, PLACE[2] + 0.01)
    found = bridged(UNMATCHED, seen_in(camera, PLACE), forecast_at([expected, FAR]))
    assert found.target.tolist() == [0]
    assert found.predicted.tolist() == [True]
    assert off_ray(camera, found.xyz[0], PLACE) < 0.001
    assert np.linalg.norm(found.xyz[0] - expected) <= np.linalg.norm(np.subtract(PLACE, expected))
    spread = np.sqrt(np.linalg.eigvalsh(found.covariance[0]))
    assert spread[2] == pytest.approx(1.0, rel=0.01)  # along the ray nothing was measured
    assert spread[1] < 0.03  # 0.7 px at 3.5 m with f = 150 px


def test_a_ball_that_lies_on_the_floor_has_its_depth_from_there() -> None:
    place = (0.3, -0.2, RADIUS)
    expected = (place[0] + 0.05, place[1] - 0.03, RADIUS + 0.02)
    found = bridged(UNMATCHED, seen_in("cam1", place), forecast_at([expected, FAR], sigma=0.05))
    assert np.linalg.norm(found.xyz[0] - place) < 0.005
    assert np.sqrt(np.linalg.eigvalsh(found.covariance[0])[2]) < 0.05


@pytest.mark.parametrize(("rising", "sigma"), [(0.2, 0.02), (0.0, 0.07)])
def test_a_ball_that_rises_or_may_be_anywhere_does_not_have_its_depth_from_the_floor(
    rising: float, sigma: float
) -> None:
    place = (0.3, -0.2, RADIUS)
    forecast = forecast_at([(place[0], place[1], RADIUS + 0.02), FAR], sigma=sigma)
    forecast = replace(forecast, velocity=np.array([[0.0, 0.0, rising], [0.0, 0.0, 0.0]]))
    found = bridged(UNMATCHED, seen_in("cam1", place), forecast)
    assert np.sqrt(np.linalg.eigvalsh(found.covariance[0])[2]) == pytest.approx(1.0, rel=0.01)


def test_a_target_with_a_position_keeps_it() -> None:
    measured = positions_at({0: PLACE}, 0.0)
    assert bridged(measured, seen_in("cam1", PLACE), forecast_at([PLACE, FAR])) is measured


def test_a_position_that_no_pair_supports_gives_way_to_a_view_at_the_forecast() -> None:
    measured = positions_at({0: (0.3, 0.2, 1.2)}, 0.0, support=0, evident=False)
    found = bridged(measured, seen_in("cam1", PLACE), forecast_at([PLACE, FAR]))
    assert found.predicted.tolist() == [True]
    assert found.xyz[0] == pytest.approx(PLACE, abs=0.001)


@pytest.mark.parametrize(
    ("jump", "evident", "kept"), [(0.02, False, True), (0.2, False, False), (0.2, True, True)]
)
def test_a_single_pair_far_from_the_forecast_counts_only_if_it_is_evident(
    jump: float, evident: bool, kept: bool
) -> None:
    place = (PLACE[0], PLACE[1] + jump, PLACE[2])
    measured = positions_at({0: place}, 0.0, support=1, evident=evident)
    found = bridged(measured, seen_in("cam1", PLACE), forecast_at([PLACE, FAR]))
    assert found.predicted.tolist() == [not kept]


@pytest.mark.parametrize(("support", "evident"), [(0, True), (1, False)])
def test_position_of_a_poor_pair_near_the_forecast_is_kept(support: int, evident: bool) -> None:
    near = positions_at({0: (PLACE[0], PLACE[1] + 0.02, PLACE[2])}, 0.0, support=support, evident=evident)
    assert bridged(near, seen_in("cam1", PLACE), forecast_at([PLACE, FAR])) is near


@pytest.mark.parametrize(("support", "evident"), [(0, False), (0, True), (1, False)])
def test_position_of_a_poor_pair_far_from_the_forecast_is_left_out(support: int, evident: bool) -> None:
    far = positions_at({0: (PLACE[0], PLACE[1] + 0.2, PLACE[2])}, 0.0, support=support, evident=evident)
    nothing = seen_in("cam0", (PLACE[0], PLACE[1], PLACE[2] + 0.3))
    assert len(bridged(far, nothing, forecast_at([PLACE, FAR])).target) == 0


def test_no_blob_near_the_forecast_no_place() -> None:
    away = (PLACE[0], PLACE[1], PLACE[2] + 0.3)
    assert len(bridged(UNMATCHED, seen_in("cam0", away), forecast_at([PLACE, FAR])).target) == 0


def test_a_blob_that_is_nearer_to_another_target_is_that_one_s() -> None:
    beside = (PLACE[0] + 0.03, PLACE[1], PLACE[2])
    found = bridged(UNMATCHED, seen_in("cam1", PLACE), forecast_at([beside, PLACE], sigma=0.05))
    assert found.target.tolist() == [1]


def test_light_as_large_as_no_ball_is_none() -> None:
    large = tuple(Blobs(**{**vars(b), "area": b.area * 3}) for b in seen_in("cam0", PLACE))
    assert len(bridged(UNMATCHED, large, forecast_at([PLACE, FAR])).target) == 0


@pytest.mark.parametrize("forecast", [None, Forecast.empty()])
def test_without_forecast_nothing_is_bridged(forecast: Forecast | None) -> None:
    assert bridged(UNMATCHED, seen_in("cam0", PLACE), forecast) is UNMATCHED


@pytest.mark.parametrize("forecast", [None, Forecast.empty()])
def test_the_first_frame_may_find_a_target_by_one_poor_pair(forecast: Forecast | None) -> None:
    poor = positions_at({0: PLACE}, 0.0, support=1, evident=False)
    assert bridged(poor, seen_in("cam0", PLACE), forecast) is poor


def test_the_derivatives_of_images_are_those_of_differences() -> None:
    P = np.array([c.projection for c in ROOM.cameras.values()])
    place = np.tile([0.2, -0.3, 0.9], (len(P), 1, 1))
    _, jacobian = projections(P, place)
    for axis, step in enumerate(np.eye(3) * 1e-6):
        change = (projections(P, place + step)[0] - projections(P, place - step)[0]) / 2e-6
        assert jacobian[..., axis] == pytest.approx(change, rel=1e-5, abs=1e-4)
