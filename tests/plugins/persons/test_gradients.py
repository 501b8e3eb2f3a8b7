"""Edges (Weinrich et al. 2010, section 3.2): the cross, suppression, spreading, the seam of a panorama."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from followspot import Camera
from followspot.context import Context
from followspot.people import Gradients
from followspot.tracking import Frame
from followspot_persons.gradient_picture import GradientPicture
from followspot_persons.gradients import FindGradients, emphasis, packed_edges, padded, spread


def camera(width=64, height=48, model="pinhole"):
    """Looks along the room's x axis; a cylinder shows the whole horizon."""
    f = width / (2 * np.pi) if model == "cylinder" else 50.0
    matrix = np.array([[f, 0, (width - 1) / 2], [0, f, (height - 1) / 2], [0, 0, 1.0]])
    facing = np.array([[0, -1, 0], [0, 0, -1], [1, 0, 0.0]])
    return Camera("c", "color", (width, height), matrix, np.zeros(5), facing, np.zeros(3), model)


def gradients(pixels, model="pinhole", **params):
    stage = FindGradients(Context.serving(camera(pixels.shape[1], pixels.shape[0], model)), **params)
    stage.setup()
    return stage.process(Frame(camera="c", pixels=pixels))


def ramp(angle, slope=4.0):
    """Brightness that rises in a direction, rad from the axis x."""
    v, u = np.mgrid[:48, :64]
    rising = slope * ((u - 32) * np.cos(angle) + (v - 24) * np.sin(angle))
    return np.clip(128 + rising, 0, 255).astype(np.uint8)[:, :, None]


@pytest.mark.parametrize("degrees", [0, 30, 45, 90, 120, 135, 170])
def test_orientation_is_the_direction_in_which_brightness_rises(degrees):
    found = gradients(ramp(np.deg2rad(degrees)), spread_radius=1)
    middle = found.orientation[20:28, 28:36] * np.pi / 256
    apart = np.abs((middle - np.deg2rad(degrees) + np.pi / 2) % np.pi - np.pi / 2)
    assert np.median(apart) < np.deg2rad(10)  # whole grey levels on a slope of 4 a pixel


def test_orientation_does_not_tell_light_from_dark():
    bright = np.zeros((48, 64, 1), np.uint8)
    bright[10:30, 20:40] = 200
    a, b = gradients(bright, spread_radius=1), gradients(200 - bright, spread_radius=1)
    assert np.array_equal(a.magnitude, b.magnitude)
    assert np.array_equal(a.orientation, b.orientation)


@settings(deadline=None)
@given(arrays(np.uint8, (3, 3, 3)))
def test_edges_are_the_roberts_cross_of_the_strongest_channel(pixels):
    picture = pixels.astype(float)
    first = picture[:-1, :-1] - picture[1:, 1:]  # eq. 1
    second = picture[:-1, 1:] - picture[1:, :-1]  # eq. 2
    magnitude = np.hypot(first, second).max(axis=2)  # eq. 4
    packed = packed_edges(pixels, emphasis(10.0))
    expected = 255 * magnitude**2 / (magnitude**2 + 100)
    slope = 255 * 2 * 0.5 / 10  # steepest change of the filter over half a grey level of rounding
    assert np.abs((packed >> 8) - expected).max() <= slope


def test_half_of_the_full_magnitude_stands_at_the_parameter():
    table = emphasis(20.0) >> 8
    assert table[0] == 0
    assert table[20] == 128
    assert table[5] < 255 / 16
    assert (np.diff(table.astype(int)) >= 0).all()


@settings(deadline=None)
@given(arrays(np.uint16, (9, 11)), st.integers(1, 20))
def test_spreading_takes_the_strongest_faded_gradient_in_reach(packed, reach):
    result = spread(packed.copy(), reach)
    v, u = np.indices(packed.shape)
    for row, column in [(0, 0), (4, 5), (8, 10), (2, 9)]:
        distance = np.abs(v - row) + np.abs(u - column)
        faded = (packed >> 8) - 255.0 * distance / reach
        # each step of the way is rounded to whole units of the magnitude
        assert abs(int(result[row, column] >> 8) - faded.max()) <= 8


def test_a_place_near_an_edge_has_the_orientation_of_the_edge():
    pixels = np.zeros((48, 64, 1), np.uint8)
    pixels[:, 32:] = 255
    found = gradients(pixels, spread_radius=8)
    assert found.magnitude[20, 31] > 250
    assert 100 < found.magnitude[20, 27] < found.magnitude[20, 29]
    assert (found.orientation[20, 24:38] == 0).all()
    assert found.magnitude[20, 31 - 9] == 0


def test_edges_of_a_panorama_spread_across_its_seam():
    pixels = np.zeros((48, 64, 3), np.uint8)
    pixels[10:30, 61:] = 255
    for model, seam_counts in [("cylinder", True), ("pinhole", False)]:
        found = gradients(pixels, model, spread_radius=8)
        assert (found.magnitude[20, 0] > 200) == seam_counts
        turned = gradients(np.roll(pixels, 20, axis=1), model, spread_radius=8)
        assert np.array_equal(np.roll(found.magnitude, 20, axis=1), turned.magnitude) == seam_counts


def test_a_picture_without_edges_has_no_gradients():
    found = gradients(np.full((48, 64, 3), 90, np.uint8))
    assert not found.magnitude.any()


def test_borders_of_a_picture_are_no_edges():
    assert padded(np.full((4, 5, 3), 9, np.uint8), 0).tolist() == np.full((5, 6, 3), 9).tolist()


def test_a_picture_of_gradients_has_orientation_as_hue_and_magnitude_as_brightness():
    """Figure 2: red along x, cyan across; a weak edge is darker, and no edge is black."""
    stage = GradientPicture(Context.serving(camera(4, 1)))
    told = Gradients("c", np.array([[255, 255, 100, 0]], np.uint8), np.array([[0, 128, 128, 7]], np.uint8))
    blue_green_red = stage.process(told).pixels[0]
    assert blue_green_red.tolist() == [[0, 0, 255], [255, 255, 0], [100, 100, 0], [0, 0, 0]]
