"""How tall people would be whose upper bodies fill boxes, and the rows of a picture that may show them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from followspot import Camera
from followspot.geometry import project
from followspot_persons.body.standing import WAIST, knows_floor, standing
from followspot_persons.hog.search import levels, plausible
from followspot_persons.hog.window import TALL
from followspot_persons.likelihood.fitness import Detection
from followspot_persons.slow_instance.part_box import by_size

FACING = np.array([[0, -1, 0], [0, 0, -1], [1, 0, 0.0]])
"""Looks along the room's x axis, level."""


def camera(model="pinhole", high=1.2, down=0.0):
    """A camera above the origin that looks down by an angle, rad."""
    size = (1396, 260) if model == "cylinder" else (640, 480)
    f = size[0] / (2 * np.pi) if model == "cylinder" else 457.0
    matrix = np.array([[f, 0, (size[0] - 1) / 2], [0, f, (size[1] - 1) / 2], [0, 0, 1.0]])
    tilt = np.array([[1, 0, 0], [0, np.cos(down), -np.sin(down)], [0, np.sin(down), np.cos(down)]])
    rotation = tilt.T @ FACING
    lens = np.zeros(4 if model == "fisheye" else 5)
    return Camera("c", "color", size, matrix, lens, rotation, -rotation @ [0, 0, high], model)


def upper_body(view, x, y, height):
    """Box of a thin upright person."""
    top, waist = project(view, np.array([[x, y, height], [x, y, WAIST * height]]))
    return np.array([[top[0] - 10, top[1], top[0] + 10, waist[1]]])


@pytest.mark.parametrize("model", ["pinhole", "cylinder"])
@settings(deadline=None)
@given(x=st.floats(1, 8), side=st.floats(-0.3, 0.3), height=st.floats(1.0, 2.2), high=st.floats(0.5, 3))
def test_distance_and_height_follow_from_head_and_waist(model, x, side, height, high):
    view = camera(model, high)
    distance, tall = standing(view, upper_body(view, x, side * x, height))
    assert distance[0] == pytest.approx(np.hypot(x, side * x), rel=1e-6)
    assert tall[0] == pytest.approx(height, rel=1e-6)


def test_a_fisheye_that_looks_at_a_person_tells_the_same():
    view = camera("fisheye", 2.0)
    distance, tall = standing(view, upper_body(view, 3.0, 0.0, 1.7))
    assert (distance[0], tall[0]) == pytest.approx((3.0, 1.7), rel=1e-6)


def test_distance_and_height_hold_for_a_camera_that_looks_down():
    view = camera(high=2.6, down=0.35)
    distance, tall = standing(view, upper_body(view, 4.0, 0.0, 1.7))
    assert (distance[0], tall[0]) == pytest.approx((4.0, 1.7), rel=1e-6)


def test_people_behind_the_seam_stand_as_others_do():
    view = camera("cylinder")
    box = upper_body(view, -3.0, 0.01, 1.8)
    beyond = box + np.array([1396, 0, 1396, 0])
    assert standing(view, beyond)[1] == pytest.approx(standing(view, box)[1])


def test_boxes_of_giants_dwarfs_and_flying_people_are_not_plausible():
    view = camera()
    person = upper_body(view, 3.0, 0.0, 1.75)
    giant, dwarf = upper_body(view, 3.0, 0.0, 3.0), upper_body(view, 3.0, 0.0, 0.7)
    flying = person - [0, 100, 0, 100]
    assert plausible(view, np.concatenate([person, giant, dwarf, flying]), (1.2, 2.1)).tolist() == [
        True,
        False,
        False,
        False,
    ]


def test_a_camera_that_was_never_placed_searches_everywhere():
    unplaced = camera(high=0.0)
    assert not knows_floor(unplaced)
    assert plausible(unplaced, np.array([[0, 0, 10, 20.0]]), (1.2, 2.1)).all()
    found = levels(unplaced, (40, 300), 1.2, (1.2, 2.1))
    assert all(level.top <= 0 and level.bottom >= 470 for level in found)


@pytest.mark.parametrize("model", ["pinhole", "cylinder"])
@settings(max_examples=25, deadline=None)
@given(x=st.floats(1.2, 5), side=st.floats(-0.3, 0.3), height=st.floats(1.2, 2.1))
def test_every_person_has_a_level_that_holds_the_whole_window(model, x, side, height):
    view = camera(model)
    box = upper_body(view, x, side * x, height)[0]
    tall = box[3] - box[1]
    inside = box[1] > 0 and box[3] < view.size[1]
    if inside and 40 <= tall <= 300:
        sizes = levels(view, (40, 300), 1.1, (1.2, 2.1))
        ratio = [abs(np.log(level.scale * tall / TALL)) for level in sizes]
        nearest = sizes[int(np.argmin(ratio))]
        assert min(ratio) < np.log(1.1)
        reach = 8 / nearest.scale  # one step of the search
        assert nearest.top < box[1] + reach
        assert nearest.bottom > box[3] - reach


def test_a_known_floor_leaves_few_rows_for_small_people():
    """Distant heads are near the horizon, whatever their height: rows far from it need not be searched."""
    free, bound = camera(high=0.0), camera()
    rows = [
        sum(level.bottom - level.top for level in levels(view, (40, 120), 1.1, (1.2, 2.1)))
        for view in (free, bound)
    ]
    assert rows[1] < 0.7 * rows[0]


def test_the_size_of_a_box_tells_a_distance_as_surely_as_it_spans_the_body():
    view = camera()
    (box,) = upper_body(view, 3.0, 0.0, 1.7)
    sure, unsure = (by_size(view, Detection(box, *np.zeros((2, 0)), certainty)) for certainty in (1.0, 0.25))
    assert sure.distance == unsure.distance == pytest.approx(3.0)
    assert unsure.sigma == 4 * sure.sigma == pytest.approx(1.2)


@pytest.mark.parametrize(("high", "certainty"), [(1.2, 0.0), (0.0, 1.0)])
def test_a_box_of_unknown_size_and_a_camera_on_the_floor_tell_no_distance_by_size(high, certainty):
    view = camera(high=high)
    (box,) = upper_body(view, 3.0, 0.0, 1.7)
    assert by_size(view, Detection(box, *np.zeros((2, 0)), certainty)) is None
