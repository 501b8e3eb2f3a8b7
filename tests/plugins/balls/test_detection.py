"""Colour and infrared detection, and the templates learnt for it (sections 2 and 3.2, 3.3)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.plugins.balls.scene import SIZE, forecast_at, make_room, picture, whole_strip
from tests.plugins.balls.two_balls import ROOM, discs, painted

from followspot.context import Context
from followspot.geometry import project
from followspot.message_checks.sealing import seal
from followspot.stage import Stage
from followspot.tracking import Blobs, Forecast, Frame
from followspot_balls.color_blobs import ColorBlobs
from followspot_balls.detection.components import MOST, above_local_peak, components, of_size
from followspot_balls.detection.hough import SEPARATE, agreement, disc_centers, own_area
from followspot_balls.detection.hue import BIT, bhattacharyya, hue_bits, normalised
from followspot_balls.ir_blobs import IrBlobs

HERE, THERE = (0.1, 0.0, 1.0), (-0.4, 0.3, 0.8)
BALLS = {"red": np.array(HERE), "green": np.array(THERE)}
FORECAST = forecast_at([HERE, THERE])


def detector(kind: type[Stage], camera: str, **params: float) -> Stage:
    stage = kind(Context.serving(ROOM.cameras[camera], ROOM), **params)
    stage.setup()
    return stage


def test_bhattacharyya_by_hand() -> None:
    a, b = np.zeros(16), np.zeros(16)
    a[[0, 1]], b[[1, 2]] = 0.5, [0.5, 0.5]
    assert bhattacharyya(a, b) == pytest.approx(0.5)
    assert bhattacharyya(a, a) == pytest.approx(1.0)
    assert bhattacharyya(a, np.eye(16)[0]) == pytest.approx(np.sqrt(0.5))


def test_histograms_are_normalised_and_an_empty_one_stays_zero() -> None:
    counts = np.zeros((2, 16))
    counts[0, [2, 5]] = [1, 3]
    assert normalised(counts)[0, [2, 5]] == pytest.approx([0.25, 0.75])
    assert not normalised(counts)[1].any()


def test_a_hue_has_the_bit_of_its_bin() -> None:
    histograms = np.random.default_rng(0).dirichlet(np.ones(16), 5)
    bits = hue_bits(histograms, 0.05)
    assert ((BIT[:16] & bits[:, None] > 0) == (histograms >= 0.05)).all()


def test_an_overexposed_core_may_be_of_any_hue() -> None:
    assert (BIT[16] & hue_bits(np.eye(16), 0.05)).all()


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


@pytest.mark.parametrize("forecast", [None, FORECAST])
def test_ir_blobs_finds_both_balls_and_labels_neither(forecast: Forecast | None) -> None:
    blobs = detector(IrBlobs, "cam1", radius_offset=0.0).process(
        picture(ROOM.cameras["cam1"], BALLS), forecast
    )
    expected = project(ROOM.cameras["cam1"], np.array([HERE, THERE]))
    order = np.argsort(blobs.pixel[:, 1])
    assert blobs.pixel[order] == pytest.approx(expected[np.argsort(expected[:, 1])], abs=0.2)
    assert (blobs.similarity == 1).all()
    if forecast is None:
        assert blobs.targets.all()
    else:
        assert blobs.targets[order].sum(axis=1).tolist() == [1, 1]


def test_an_infrared_blob_in_two_windows_is_one_blob_of_two_targets() -> None:
    near = (HERE[0] + 0.1, HERE[1], HERE[2])
    frame = picture(ROOM.cameras["cam1"], {"red": np.array(HERE)})
    blobs = detector(IrBlobs, "cam1").process(frame, forecast_at([HERE, near]))
    assert blobs.targets.tolist() == [[True, True]]


@pytest.mark.parametrize("camera", ["cam1", "cam3"])
def test_infrared_balls_that_touch_in_a_picture_are_two_blobs(camera: str) -> None:
    beside = (HERE[0] + 0.14, HERE[1], HERE[2])
    places = np.array([HERE, beside])
    frame = picture(ROOM.cameras[camera], dict(zip(("red", "green"), places, strict=True)))
    assert len(detector(IrBlobs, camera).process(frame, None).pixel) == 1
    found = detector(IrBlobs, camera).process(frame, forecast_at([HERE, beside]))
    off = np.linalg.norm(found.pixel[:, None] - project(ROOM.cameras[camera], places), axis=2)
    assert off.min(axis=0) == pytest.approx(np.zeros(2), abs=0.6)


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


def test_hot_pixels_are_not_balls() -> None:
    frame = painted("cam1", [])
    pixels = frame.pixels.copy()
    pixels[::9, ::9] = 255
    assert len(detector(IrBlobs, "cam1").process(seal(Frame(camera="cam1", pixels=pixels)), None).xy) == 0


@pytest.mark.parametrize("forecast", [None, FORECAST])
@pytest.mark.parametrize(("gray", "seen"), [(99, False), (100, True), (200, True), (201, False)])
def test_grey_levels_out_of_the_range_are_not_seen(gray: int, seen: bool, forecast: Forecast | None) -> None:
    room = make_room()
    for target in room.targets.values():
        target.gray["cam1"] = (100.0, 200.0)  # type: ignore[index]
    stage = IrBlobs(Context.serving(room.cameras["cam1"], room))
    stage.setup()
    column, row = np.rint(project(room.cameras["cam1"], np.array([HERE]))[0]).astype(int)
    pixels = np.zeros((SIZE[1], SIZE[0], 1), np.uint8)
    pixels[row - 2 : row + 4, column - 2 : column + 4] = gray
    assert len(stage.process(seal(Frame(camera="cam1", pixels=pixels)), forecast).xy) == seen


def test_pixels_that_touch_at_a_corner_are_one_component() -> None:
    level = np.zeros((20, 20), np.uint8)
    level[5:9, 5:9] = level[9:13, 9:13] = 200
    assert components(level > 0, level, whole_strip(20)).area.tolist() == [32]


def test_noise_is_bounded() -> None:
    level = np.zeros((200, 200), np.uint8)
    level[::3, ::3] = 200
    found = components(above_local_peak(level, 0.5), level, whole_strip(200))
    assert len(found.area) > 3 * MOST
    view = np.arange(len(found.area)) % 2
    kept = of_size(found.area, np.ones(len(view)), np.full(len(view), 9.0), view)
    assert np.bincount(view, kept).tolist() == [MOST, MOST]


def test_without_a_radius_the_centre_is_the_centroid() -> None:
    level, strip = np.zeros((20, 20), np.uint8), whole_strip(20)
    level[5:9, 5:9] = 200
    found = components(above_local_peak(level, 0.5), level, strip)
    center, _ = disc_centers(level, strip, found, np.array([np.nan]), 0.5)
    assert center == pytest.approx(np.array([[6.5, 6.5]]))


def test_without_a_vote_the_centre_is_the_centroid() -> None:
    start = np.array([[6.5, 7.0], [30.0, 2.0]])
    nobody = np.empty(0, int)
    point, heard = agreement(np.empty((2, 0)), np.empty(0), nobody, start)
    assert point == pytest.approx(start)
    assert (heard < 1e-6).all()


@pytest.mark.parametrize("expected", [(19.0, 28.5), (34.0, 32.0)])
def test_of_two_discs_in_one_blob_the_one_at_the_forecast_is_found(expected: tuple[float, float]) -> None:
    both = (20.0, 30.0), (33.0, 31.0)
    level, strip = discs(*both), whole_strip(60)
    blobs = components(above_local_peak(level, 0.5), level, strip)
    assert len(blobs.area) == 1
    center, _ = disc_centers(level, strip, blobs, np.array([8.0]), 0.5, np.array([expected]))
    nearest = min(both, key=lambda disc: np.hypot(*np.subtract(disc, expected)))
    assert center == pytest.approx(np.array([nearest]), abs=0.3)


@pytest.mark.parametrize(
    ("hidden", "told"), [(0, True), (8, False)], ids=["most of its rim shows", "half of it is covered"]
)
def test_a_rim_tells_a_ball_from_the_light_that_it_is_merged_with(hidden: int, told: bool) -> None:
    level, strip = discs((20.0, 30.0)), whole_strip(60)
    level[22:39, : 12 + hidden] = 0
    level[24:36, 27:58] = 200
    blobs = components(above_local_peak(level, 0.5), level, strip)
    radius = np.array([8.0])
    center, rim = disc_centers(level, strip, blobs, radius, 0.5, np.array([[20.0, 30.0]]))
    area = own_area(blobs.area, np.array([250.0]), radius, rim)
    whole = own_area(blobs.area, blobs.area, radius, rim)
    assert whole == pytest.approx(blobs.area)
    assert (rim[0] >= SEPARATE) == told
    assert area == pytest.approx(np.pi * 64 if told else blobs.area)
    if told:
        assert center == pytest.approx(np.array([[20.0, 30.0]]), abs=0.5)


def test_a_forecast_beside_a_merged_blob_leads_to_a_disc_all_the_same() -> None:
    level, strip = discs((20.0, 30.0), (26.0, 30.0)), whole_strip(60)
    blobs = components(above_local_peak(level, 0.5), level, strip)
    center, _ = disc_centers(level, strip, blobs, np.array([8.0]), 0.5, np.array([[45.0, 12.0]]))
    assert center == pytest.approx(np.array([[26.0, 30.0]]), abs=0.3)


def test_a_fragment_does_not_ask_the_forecast_which_its_edge_would_confirm() -> None:
    level, strip = np.zeros((60, 60), np.uint8), whole_strip(60)
    level[25:35, 20:24] = 200
    blobs = components(above_local_peak(level, 0.5), level, strip)
    alone, _ = disc_centers(level, strip, blobs, np.array([8.0]), 0.5)
    center, _ = disc_centers(level, strip, blobs, np.array([8.0]), 0.5, np.array([[15.5, 29.5]]))
    assert np.array_equal(center, alone)


@pytest.mark.parametrize("expected", [(20.0, 30.0), (22.0, 31.0), (18.0, 28.5), (20.0, 33.0)])
def test_the_forecast_of_a_ball_beside_another_tells_its_rim_from_the_two_edges_that_cover_it(
    expected: tuple[float, float],
) -> None:
    level, strip = discs((20.0, 30.0)), whole_strip(60)
    level[30:] = level[:, 20:] = 0
    blobs = components(above_local_peak(level, 0.5), level, strip)
    given = level, strip, blobs, np.array([8.0]), 0.5, np.array([expected])
    center, _ = disc_centers(*given, np.array([True]))
    assert center == pytest.approx(np.array([[20.0, 30.0]]), abs=0.1)
    other, _ = disc_centers(*given, np.array([False]))
    assert np.linalg.norm(other - center) > 8


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
