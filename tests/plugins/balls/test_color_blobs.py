"""Balls in colour pictures (Jin & Qian 2008, section 3.3), and what no detector finds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.plugins.balls.detected import BALLS, FORECAST, HERE, THERE, detector
from tests.plugins.balls.scene import forecast_at, make_room, picture, whole_strip
from tests.plugins.balls.two_balls import ROOM, painted

from followspot.context import Context
from followspot.geometry import project
from followspot.message_checks.sealing import seal
from followspot.stage import Stage
from followspot.tracking import Blobs, Forecast, Frame
from followspot_balls.color_blobs import ColorBlobs
from followspot_balls.detection.components import MOST, above_local_peak, components, of_size
from followspot_balls.ir_blobs import IrBlobs


@pytest.mark.parametrize("forecast", [None, Forecast.empty(), FORECAST])
@pytest.mark.parametrize("camera", ["cam0", "cam2"])
def test_color_blobs_finds_each_ball_for_its_own_target(camera: str, forecast: Forecast | None) -> None:
    blobs = detector(ColorBlobs, camera).process(picture(ROOM.cameras[camera], BALLS), forecast)
    places = project(ROOM.cameras[camera], np.array([HERE, THERE]))
    assert sorted(blobs.targets.tolist()) == [[False, True], [True, False]]
    assert blobs.pixel == pytest.approx(places[blobs.targets.argmax(axis=1)], abs=0.2)
    assert (blobs.similarity > 0.99).all()


@pytest.mark.parametrize("forecast", [None, FORECAST])
def test_a_saturated_white_core_does_not_break_a_blob(forecast: Forecast | None) -> None:
    frame = picture(ROOM.cameras["cam0"], BALLS, white_core=True)
    blobs = detector(ColorBlobs, "cam0").process(frame, forecast)
    places = project(ROOM.cameras["cam0"], np.array([HERE, THERE]))
    assert len(blobs.pixel) == 2
    assert blobs.pixel == pytest.approx(places[blobs.targets.argmax(axis=1)], abs=0.2)


@pytest.mark.parametrize("forecast", [None, FORECAST])
@pytest.mark.parametrize("owner", [0, 1])
def test_a_blob_of_two_similar_colours_belongs_to_the_one_that_it_fits_best(
    owner: int, forecast: Forecast | None
) -> None:
    """Red of 352 to 8 degrees and orange of 20: each template accepts blobs of the other."""
    room = make_room()
    for target, shares in zip(room.targets.values(), ({0: 0.7, 15: 0.3}, {0: 1.0}), strict=True):
        target.hue_histogram["cam0"][:] = 0  # type: ignore[index]
        target.hue_histogram["cam0"][list(shares)] = list(shares.values())  # type: ignore[index]
    stage = ColorBlobs(Context.serving(room.cameras["cam0"], room))
    stage.setup()
    x, y = project(room.cameras["cam0"], np.array([HERE]))[0]
    pixels = painted("cam0", [(x, y, 3.3, (0, 85, 255))]).pixels.copy()
    if owner == 0:
        ball = pixels.any(axis=2)
        rows = np.arange(len(pixels))[:, None]
        pixels[ball] = (0, 20, 255)
        pixels[ball & (rows > y + 1)] = (40, 0, 255)
    near = None if forecast is None else forecast_at([HERE, HERE])
    blobs = stage.process(seal(Frame(camera="cam0", pixels=pixels)), near)
    assert blobs.targets.tolist() == [[owner == 0, owner == 1]]


def test_similarity_must_exceed_the_threshold() -> None:
    # half of the ball shows a hue of the neighbouring target: similarity sqrt(1/2) with either template
    mixed = make_room()
    for target in mixed.targets.values():
        target.hue_histogram["cam0"][[0, 5]] = [0.5, 0.5]  # type: ignore[index]
    stage = ColorBlobs(Context.serving(mixed.cameras["cam0"], mixed))
    stage.setup()
    frame = painted("cam0", [(80.0, 60.0, 3.3, (0, 0, 255))])
    assert len(stage.process(frame, None).xy) == 0
    loose = ColorBlobs(Context.serving(mixed.cameras["cam0"], mixed), similarity=0.7)
    loose.setup()
    assert loose.process(frame, None).similarity == pytest.approx(np.full(2, np.sqrt(0.5)))
    equal = ColorBlobs(Context.serving(mixed.cameras["cam0"], mixed), similarity=float(np.sqrt(0.5)))
    equal.setup()
    assert len(equal.process(frame, None).xy) == 0


@pytest.mark.parametrize(("radius", "found"), [(0.7, 0), (3.3, 1), (8.0, 0)])
def test_size_control_removes_blobs_out_of_the_range(radius: float, found: int) -> None:
    # template 15 to 60 px, tolerance 0.3 and 1.5: from 4.5 to 90 px
    frame = painted("cam0", [(80.0, 60.0, radius, (0, 0, 255))])
    assert len(detector(ColorBlobs, "cam0").process(frame, None).xy) == found
    frame = painted("cam1", [(80.0, 60.0, radius, (200, 200, 200))])
    assert len(detector(IrBlobs, "cam1").process(frame, None).xy) == found


def test_a_ball_submerged_by_a_larger_projection_counts_as_hidden() -> None:
    x, y = project(ROOM.cameras["cam0"], np.array([HERE]))[0]
    frame = painted("cam0", [(x, y, 12.0, (0, 0, 250)), (x, y, 3.3, (0, 0, 255))])
    blobs = detector(ColorBlobs, "cam0").process(frame, FORECAST)
    assert len(blobs.xy) == 0


@pytest.mark.parametrize(("largest", "found"), [(1.3, 0), (3.0, 1)])
def test_a_ball_that_merges_with_an_equally_bright_projection_counts_as_hidden(
    largest: float, found: int
) -> None:
    # two discs of 3.3 px, 4 px apart: 1.7 times the outline, within the template's range of sizes
    x, y = project(ROOM.cameras["cam0"], np.array([HERE]))[0]
    frame = painted("cam0", [(x, y, 3.3, (0, 0, 255)), (x + 4, y, 3.3, (0, 0, 255))])
    blobs = detector(ColorBlobs, "cam0", maximum_expected_area=largest).process(frame, FORECAST)
    assert len(blobs.xy) == found


def test_a_ball_is_cut_from_the_dimmer_projection_that_it_touches() -> None:
    x, y = project(ROOM.cameras["cam0"], np.array([HERE]))[0]
    frame = painted("cam0", [(x + 5, y, 4.0, (0, 0, 120)), (x, y, 3.3, (0, 0, 255))])
    blobs = detector(ColorBlobs, "cam0").process(frame, FORECAST)
    assert np.hypot(*(blobs.pixel - [x, y]).T).min() < 0.4


@pytest.mark.parametrize(("camera", "kind"), [("cam0", ColorBlobs), ("cam1", IrBlobs)])
def test_a_half_hidden_ball_is_found_where_it_is_and_not_at_its_centroid(
    camera: str, kind: type[Stage]
) -> None:
    view = ROOM.cameras[camera]
    frame = picture(view, {"red": np.array(HERE)})
    x, y = project(view, np.array([HERE]))[0]
    pixels = frame.pixels.copy()
    pixels[:, : round(x)] = 0  # hidden by something vertical
    blobs = detector(kind, camera, radius_offset=0.0).process(
        seal(Frame(camera=camera, pixels=pixels)), FORECAST
    )
    assert np.hypot(*(blobs.pixel[0] - [x, y])) < 0.6
    blind = detector(kind, camera).process(seal(Frame(camera=camera, pixels=pixels)), None)
    assert np.hypot(*(blind.pixel[0] - [x, y])) > 0.9


@pytest.mark.parametrize(
    ("apart", "size", "seen"), [(11.5, 5.5, True), (3.0, 9.0, False)], ids=["touching", "submerged"]
)
def test_a_ball_that_touches_much_light_of_its_colour_is_found_by_its_rim(
    apart: float, size: float, seen: bool
) -> None:
    large = replace(ROOM.targets["red"], radius=0.15, area={"cam0": (100.0, 140.0)})
    room = replace(ROOM, targets={"red": large})
    stage = ColorBlobs(Context.serving(room.cameras["cam0"], room), maximum_expected_area=1.5)
    stage.setup()
    x, y = project(room.cameras["cam0"], np.array([HERE]))[0]
    radius = 150.0 * 0.15 / float(np.linalg.norm(HERE - room.cameras["cam0"].center))
    frame = painted("cam0", [(x, y, radius, (0, 0, 255)), (x + apart, y, size, (0, 0, 255))])
    found = stage.process(frame, forecast_at([HERE]))
    assert len(found.pixel) == seen
    if seen:
        assert found.pixel[0] == pytest.approx((x, y), abs=0.6)
        assert found.area[0] == pytest.approx(np.pi * radius**2, rel=0.01)


def test_noise_is_bounded() -> None:
    level = np.zeros((200, 200), np.uint8)
    level[::3, ::3] = 200
    found = components(above_local_peak(level, 0.5), level, whole_strip(200))
    assert len(found.area) > 3 * MOST
    view = np.arange(len(found.area)) % 2
    kept = of_size(found.area, np.ones(len(view)), np.full(len(view), 9.0), view)
    assert np.bincount(view, kept).tolist() == [MOST, MOST]


def test_detectors_of_a_room_without_targets_find_nothing() -> None:
    empty = make_room(targets=())
    for name, kind in (("cam0", ColorBlobs), ("cam1", IrBlobs)):
        stage = kind(Context.serving(empty.cameras[name], empty))
        stage.setup()
        blobs: Blobs = stage.process(picture(ROOM.cameras[name], BALLS), None)
        assert blobs.targets.shape == (0, 0)


def test_a_camera_that_sees_no_search_region_finds_nothing() -> None:
    behind = forecast_at([(30.0, 0.0, 1.0), (0.0, 30.0, 1.0)])
    for name, kind in (("cam0", ColorBlobs), ("cam1", IrBlobs)):
        blobs = detector(kind, name).process(picture(ROOM.cameras[name], BALLS), behind)
        assert blobs.targets.shape == (0, 2)
