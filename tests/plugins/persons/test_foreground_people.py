"""People whom the detector misses: what stands before the background as people do."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.plugins.persons.drawn import SHIRT, WALL, perspective, standing
from tests.plugins.persons.shown import SlowInstance

from followspot import Camera
from followspot.geometry import project
from followspot.people import Boxes
from followspot_persons.background.background import FEWEST
from followspot_persons.background.scene import Scene
from followspot_persons.body.shape import read_shape
from followspot_persons.body.standing import WAIST
from followspot_persons.body.view import view
from followspot_persons.slow_instance.foreground_box import STEP
from followspot_persons.slow_instance.foreground_people import SCORE, completed, foreground_people

CAMERA = perspective()
PLAIN = np.full((240, 320, 3), WALL, np.uint8)


def figure(
    x: float, y: float = 0.0, height: float = 1.7, width: float = 0.4, lift: float = 0.0
) -> np.ndarray:
    """A picture of something upright on the floor before a wall, (H, W, 3) u1; lift: above the floor, m."""
    pixels = PLAIN.copy()
    top, low = project(CAMERA, np.array([[x, y, height + lift], [x - 0.18, y, lift]]))
    half = 0.5 * width / height * (low[1] - top[1])
    rows = slice(max(0, round(top[1])), max(0, round(low[1])))
    pixels[rows, max(0, round(top[0] - half)) : round(top[0] + half)] = SHIRT
    return pixels


def seen(
    pixels: np.ndarray,
    background: np.ndarray = PLAIN,
    camera: Camera = CAMERA,
    before: np.ndarray | None = None,
) -> np.ndarray:
    """The upper bodies in a picture; before: the last one, in which they were some pixels aside."""
    scene = Scene(camera, pixels, background, 1.0)
    return foreground_people(
        scene, scene.mask(STEP), np.roll(pixels, 6, axis=1) if before is None else before
    )


@pytest.mark.parametrize(("x", "y", "height"), [(3.5, 0.0, 1.7), (4.0, 0.6, 1.85), (4.5, -0.5, 1.55)])
def test_what_stands_on_the_floor_like_a_person_is_one_of_the_height_that_its_feet_tell(x, y, height):
    (box,) = seen(figure(x, y, height))
    true = view(CAMERA, read_shape(), standing(x, y, height)[None]).box[0]
    tall = true[3] - true[1]
    np.testing.assert_allclose(box[[1, 3]], true[[1, 3]], atol=0.08 * tall)
    assert (box[0] + box[2]) / 2 == pytest.approx((true[0] + true[2]) / 2, abs=0.1 * tall)


def test_feet_are_before_the_axis_of_a_body():
    """Rows of the mask are two pixels apart, so that one box alone tells the distance to within 5 %."""
    ratios = []
    for x in np.arange(3.0, 4.6, 0.1):
        (box,) = seen(figure(x))
        head, waist = project(CAMERA, np.array([[x, 0, 1.7], [x, 0, 1.7 * WAIST]]))
        ratios.append((box[3] - box[1]) / (waist[1] - head[1]))
    assert np.mean(ratios) == pytest.approx(1.0, abs=0.03)


@pytest.mark.parametrize("y", [0.0, 0.3])
def test_feet_below_the_picture_leave_the_height_of_people_at_large(y):
    (box,) = seen(figure(1.8, y, 1.72))
    true = view(CAMERA, read_shape(), standing(1.8, y, 1.72)[None]).box[0]
    np.testing.assert_allclose(box[[1, 3]], true[[1, 3]], atol=0.1 * (true[3] - true[1]))


@pytest.mark.parametrize(
    "pixels",
    [
        figure(3.5, height=0.9),  # a child, a chair
        figure(3.5, height=2.6),
        figure(3.5, width=0.1),  # a stand
        figure(3.5, width=1.4),  # a table
        figure(3.5, lift=0.8),  # a picture on the wall: higher and farther than people
        figure(1.0, height=2.0),  # the head is above the picture
        figure(20.0),  # too small to tell
    ],
)
def test_other_things_are_no_people(pixels):
    assert len(seen(pixels)) == 0


def test_a_place_that_somebody_left_is_nobody():
    """The background shows a person who stood there from the start."""
    assert len(seen(PLAIN, figure(3.5))) == 0
    assert len(seen(figure(3.5, 0.9), figure(3.5, -0.6))) == 1


def test_what_does_not_move_is_no_person():
    """A door that was opened, a coat on its stand."""
    assert len(seen(figure(3.5), before=figure(3.5))) == 0
    assert len(seen(figure(3.5), before=figure(3.5, 0.02))) == 1
    assert len(seen(figure(3.5), before=PLAIN[:100])) == 0


def test_a_camera_that_was_never_placed_sees_nobody_on_the_floor():
    nowhere = replace(CAMERA, translation=np.zeros(3))
    assert len(seen(figure(1.8, width=0.1), camera=nowhere)) == 0


def test_whom_the_detector_finds_is_not_found_twice():
    pixels = figure(3.5)
    scene, found = Scene(CAMERA, pixels, PLAIN, 1.0), seen(pixels)
    none = np.zeros((1, 16))
    detected = Boxes("c", found, np.array([3.0]), none, none)
    assert completed(detected, scene, scene.mask(STEP), PLAIN).score.tolist() == [3.0]
    elsewhere = replace(detected, box=found + np.array([100.0, 0, 100, 0]))
    assert completed(elsewhere, scene, scene.mask(STEP), PLAIN).score.tolist() == [3.0, SCORE]


@pytest.mark.parametrize(("on", "numbers"), [(True, [1]), (False, [])])
def test_who_comes_is_known_without_any_box_of_the_detector(on, numbers):
    """The room is empty for 3 s."""
    show = SlowInstance(foreground_boxes=on)
    show.leave(FEWEST)
    for step in range(4):
        told = show.see_pixels(figure(3.2, 0.1 * step), boxed=[], score=1.0)
    assert told.person.tolist() == numbers
    if on:
        assert told.pose[0, 0] == pytest.approx(3.2, abs=0.3)


def test_the_foreground_of_a_known_person_says_nothing_of_its_height():
    """Feet are below the picture: the size of such a box follows from the height of people at large."""
    show = SlowInstance()
    show.leave(FEWEST)
    for step in range(4):
        show.see(standing(1.7, 0.02 * step, height=1.55), score=6.0)
    sizes = len(show.stage.people[0].stature.sizes)
    for step in range(4):
        show.see(standing(1.7, 0.08 - 0.1 * step, height=1.55), boxed=[])
    (person,) = show.stage.people
    assert person.hits > 4
    assert len(person.stature.sizes) == sizes


@pytest.mark.parametrize(("front", "known"), [(SHIRT, True), ((30, 30, 30), False)])
def test_the_foreground_is_a_known_persons_only_in_its_clothes(front, known):
    """Somebody stands where the detector misses a known person."""
    show = SlowInstance()
    show.leave(FEWEST)
    for _ in range(6):
        show.see(standing(2.6))
    before = show.stage.people[0].seen
    show.see(standing(2.6), boxed=[], front=front, back=front)
    assert (show.stage.people[0].seen > before) is known
