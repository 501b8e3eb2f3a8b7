"""Known people that the detector misses: found again in what differs from the background."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.plugins.persons.before_wall import background_and_body
from tests.plugins.persons.drawn import SHIRT, perspective, standing
from tests.plugins.persons.shown import SlowInstance

from followspot_persons.background.background import FEWEST
from followspot_persons.background.floor_contact import STRIDE_SIGMA, Contact
from followspot_persons.body.shape import read_shape
from followspot_persons.body.upper_body_box import RATIO
from followspot_persons.body.view import view
from followspot_persons.fast_instance.slow_pose import particles_about
from followspot_persons.particles.track import Track
from followspot_persons.slow_instance.floor_distance import FloorDistance
from followspot_persons.slow_instance.foreground_box import STEP, foreground_box, shares, without_others

CAMERA = perspective()


def body(pose):
    """The upper body of a pose, (4,) px."""
    return view(CAMERA, read_shape(), pose[None]).box[0]


def mask_of(*boxes):
    """Foreground of bodies from these boxes on downwards: heads and torsos, as wide as the model's."""
    mask = np.zeros((CAMERA.size[1] // STEP, CAMERA.size[0] // STEP), bool)
    for x0, y0, x1, y1 in boxes:
        middle, tall = (x0 + x1) / 2, y1 - y0
        for half, down in ((0.15, 0.0), (0.25, 0.3)):
            columns = slice(int((middle - half * tall) / STEP), int((middle + half * tall) / STEP))
            mask[max(0, int((y0 + down * tall) / STEP)) :, columns] = True
    return mask


@pytest.mark.parametrize("pose", [standing(3.0, 0.25), standing(2.6, -0.1), standing(3.4)])
def test_the_foreground_gives_the_box_of_a_known_height(pose):
    true, expected = body(pose), body(standing(3.0))
    found = foreground_box(CAMERA, mask_of(true), expected, 1.7, 40.0)
    assert (found[0] + found[2]) / 2 == pytest.approx((true[0] + true[2]) / 2, abs=2 * STEP)
    assert found[1] == pytest.approx(true[1], abs=1.5 * STEP)
    size, right = found[3] - found[1], true[3] - true[1]
    before = expected[3] - expected[1]
    assert abs(size - right) <= max(0.06 * right, 0.75 * abs(before - right))
    assert found[2] - found[0] == pytest.approx(RATIO * size)


def test_a_head_beyond_the_picture_keeps_its_place_and_the_body_tells_the_side():
    near = standing(0.75)
    expected = body(near)
    assert expected[1] < -10
    found = foreground_box(CAMERA, mask_of(body(standing(0.75, 0.08))), expected, 1.7, 60.0)
    assert found[1] == expected[1]
    assert (found[0] + found[2]) / 2 < (expected[0] + expected[2]) / 2 - 10


def test_an_empty_place_a_far_body_and_somebody_elses_body_are_none():
    expected = body(standing(3.0))
    assert foreground_box(CAMERA, mask_of(), expected, 1.7, 40.0) is None
    assert foreground_box(CAMERA, mask_of(body(standing(3.0, 1.3))), expected, 1.7, 20.0) is None
    other = body(standing(3.0, 0.1))
    left = without_others(mask_of(other), other[None], CAMERA)
    assert foreground_box(CAMERA, left, expected, 1.7, 40.0) is None


def lost_after(show, *boxes, pictures=8):
    """Whether a person is known no more in pictures that show it walking, with these boxes alone."""
    for step in range(pictures):
        show.see(standing(2.6, 0.05 * step), boxed=list(boxes))
    return show.stage.people[0].absent


@pytest.mark.parametrize(("time", "lost"), [(8.0, False), (0.4, True)])
def test_who_is_known_stays_without_boxes_for_a_time_in_the_foreground(time, lost):
    show = SlowInstance(maximum_unboxed_time=time, foreground_boxes=False)
    for _ in range(FEWEST + 1):
        show.see()
    for _ in range(5):
        show.see(standing(2.6))
    colors = show.stage.people[0].colors
    assert lost_after(show) == lost
    person = show.stage.people[0]
    np.testing.assert_array_equal(person.colors.mean, colors.mean)
    if not lost:
        assert person.track.pose[1] == pytest.approx(0.35, abs=0.12)


def test_who_was_taken_for_somebody_far_away_is_where_the_feet_are_at_once():
    show = SlowInstance(foreground_boxes=False)
    show.leave(FEWEST)
    for _ in range(3):
        show.see(standing(3.0))
    (person,) = show.stage.people
    far = Track.initiated(particles_about(standing(6.5), 60, np.random.default_rng(1)))
    show.stage.people = [replace(person, track=far, distance=FloorDistance())]
    told = show.see_pixels(background_and_body(standing(3.0)).pixels, boxed=[], score=1.0)
    assert told.pose[0, 0] == pytest.approx(3.0, abs=0.5)


def test_the_foreground_alone_measures_no_size_and_so_no_distance():
    """Its box is as large as the person is expected to be: a distance of hidden feet grows vague."""
    show = SlowInstance(foreground_boxes=False)
    show.leave(FEWEST)
    for _ in range(4):
        show.see(standing(2.6))
    (person,) = show.stage.people
    show.stage.people = [replace(person, distance=FloorDistance.of(Contact(2.6)))]
    for _ in range(4):
        told = show.see(standing(2.6), boxed=[])
    assert told.person.tolist() == [1]
    assert told.contact[0, 1] ** -0.5 == pytest.approx(np.hypot(STRIDE_SIGMA, 1.0), abs=0.1)


def test_boxes_on_furniture_are_nobodys_who_came_later():
    """The detector sees the person where it was, on the wall, but the person walks on."""
    show = SlowInstance()
    for _ in range(FEWEST + 1):
        show.see()
    for _ in range(5):
        show.see(standing(2.6, -0.3))
    for step in range(6):
        show.see(standing(2.6, -0.3 + 0.15 * step), boxed=[standing(2.6, -0.7)])
    assert show.stage.people[0].track.pose[1] == pytest.approx(0.45, abs=0.15)


def test_the_foreground_of_a_nearer_person_without_a_box_is_nobody_elses():
    """The detector misses both, and the farther one is behind the nearer one."""
    show, near = SlowInstance(foreground_boxes=False), standing(2.4)
    for _ in range(FEWEST + 1):
        show.see()
    for _ in range(5):
        show.see(near)
    (person,) = show.stage.people
    behind = Track.initiated(particles_about(standing(3.4, 0.2), 60, np.random.default_rng(1)))
    show.stage.people = [replace(person, number=2, track=behind, distance=FloorDistance()), person]
    show.see(near, boxed=[])
    assert {p.number: p.seen > person.seen for p in show.stage.people} == {1: True, 2: False}


def test_shares_are_of_the_torso_in_each_box():
    here, there = body(standing(3.0, 0.4)), body(standing(3.0, -0.4))
    told = shares(CAMERA, mask_of(here), np.array([here, there]))
    assert told[0] > 0.8
    assert told[1] == 0.0


def test_who_leaves_the_picture_is_not_prolonged():
    show = SlowInstance()
    for _ in range(FEWEST + 1):
        show.see()
    for _ in range(5):
        show.see(standing(2.6))
    show.leave(5)
    assert show.stage.people[0].absent


def test_a_part_of_the_background_is_not_prolonged():
    show = SlowInstance(sway=0)
    for step in range(10):
        show.see(standing(2.6, 0.0 if step else 0.1))
    for step in range(5):
        show.see(standing(2.6, 0.05 * step), boxed=[])
    assert show.stage.people[0].absent


@pytest.mark.parametrize("there", [False, True])
def test_who_is_missed_has_left_if_the_background_is_seen_there(there):
    show = SlowInstance()
    for _ in range(FEWEST + 1):
        show.see()
    for _ in range(4):
        show.see(standing(2.6))
    assert show.stage.people[0].left is False
    told = show.see(*([standing(2.6)] if there else []), boxed=[])
    assert told.left.tolist() == [not there]


@pytest.mark.parametrize(("front", "known"), [(SHIRT, True), ((30, 30, 30), False)])
def test_specific_colours_must_beat_generic_ones_where_the_detector_is_silent(front, known):
    """Another person, in other clothes, stands where the detector misses a known one."""
    show = SlowInstance(particles=200)
    for _ in range(FEWEST + 1):
        show.see()
    for _ in range(5):
        show.see(standing(2.6))
    seen = show.stage.people[0].seen
    show.see(standing(2.6), boxed=[], front=front, back=front)
    assert (show.stage.people[0].seen > seen) is known
