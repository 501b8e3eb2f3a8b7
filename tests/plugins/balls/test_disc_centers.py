"""Components of bright pixels, and the centres of discs by votes of their rims."""

from __future__ import annotations

import numpy as np
import pytest
from tests.plugins.balls.scene import whole_strip
from tests.plugins.balls.two_balls import discs

from followspot_balls.detection.components import above_local_peak, components
from followspot_balls.detection.hough import SEPARATE, agreement, disc_centers, own_area


def test_pixels_that_touch_at_a_corner_are_one_component() -> None:
    level = np.zeros((20, 20), np.uint8)
    level[5:9, 5:9] = level[9:13, 9:13] = 200
    assert components(level > 0, level, whole_strip(20)).area.tolist() == [32]


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
