"""The slow instance: who is confirmed, whose colours are learnt, who is remembered and known again."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from tests.plugins.persons.drawn import (
    SECOND,
    SHIRT,
    boxes_of,
    detection_of,
    drawn,
    frame_of,
    gradients_of,
    picture_of,
    standing,
)
from tests.plugins.persons.shown import SlowInstance, numbers
from tests.travelled import travelled

from followspot.control.checkpoint import state_to_data
from followspot.messages import stamped
from followspot_persons.body.shape import read_shape, with_girth
from followspot_persons.body.view import view
from followspot_persons.color.hsi import hsi
from followspot_persons.slow_instance.known_person import MISSED_COST
from followspot_persons.slow_instance.person_update import SHARP_VISIBILITY, TRUSTED

GREEN = (60, 150, 50)


def test_two_boxes_confirm_a_person_if_the_sum_of_their_scores_is_high_enough():
    show = SlowInstance()
    assert numbers(show.see(standing(2.5), score=9.0)) == []
    assert numbers(show.see(standing(2.5), score=9.0)) == [1]
    weak = SlowInstance()
    told = [numbers(weak.see(standing(2.5), score=1.0)) for _ in range(8)]
    assert told[:3] == [[]] * 3
    assert told[-1] == [1]


def test_unusual_heights_need_more_boxes():
    def boxes_needed(height):
        show = SlowInstance()
        return next(n for n in range(1, 12) if numbers(show.see(standing(2.5, height=height), score=2.0)))

    assert boxes_needed(1.35) > boxes_needed(1.7)


def test_the_height_by_an_unsure_box_counts_little():
    def known(score):
        show = SlowInstance()
        for _ in range(2):
            show.see(standing(2.5), score=score)
        return show.stage.people[0]

    unsure, sure = known(1.0), known(6.0)
    assert unsure.stature.weights[-1] < 0.2 < 0.8 < sure.stature.weights[-1]
    assert unsure.colors.evidence.max() == pytest.approx(sure.colors.evidence.max(), rel=0.2)


def test_weak_boxes_initiate_nobody():
    show = SlowInstance(minimum_score=1.5)
    for _ in range(6):
        assert numbers(show.see(standing(2.5), score=1.4)) == []


def test_however_often_a_person_was_seen_some_pictures_without_a_box_make_it_absent():
    show = SlowInstance(maximum_missed_time=99.0)
    for _ in range(4):
        show.see(standing(2.5), score=6.0)
    show.leave(round(TRUSTED / MISSED_COST) - 1)
    assert not show.stage.people[0].absent
    show.leave(1)
    assert show.stage.people[0].absent


def test_a_tentative_person_is_forgotten_without_boxes():
    show = SlowInstance()
    show.see(standing(2.5), score=1.0)
    assert len(show.stage.people) == 1
    show.leave(1)
    assert show.stage.people == []


def test_a_box_takes_particles_with_it_when_a_person_turns_round_between_two_pictures():
    """A metre a second to the left, then to the right: particles that go on to the left never come back."""
    show = SlowInstance()
    for across in (-0.6, -0.1, 0.4, 0.9):
        show.see(standing(2.5, across))
    told = show.see(standing(2.5, 0.2))
    assert numbers(told) == [1]
    assert told.pose[0, 1] == pytest.approx(0.2, abs=0.15)


def test_only_features_that_are_seen_well_are_learnt():
    show = SlowInstance()
    show.see(standing(2.5, heading=2.7), score=9.0)
    told = show.see(standing(2.5, heading=2.7), score=9.0)  # the first update, which makes the only evidence
    track = show.stage.people[0].track
    body = with_girth(read_shape(), track.girth.mean)
    seen = view(show.camera, body, track.pose[None]).visibility[0]
    assert ((seen > 0) & (seen < SHARP_VISIBILITY)).any()
    np.testing.assert_array_equal(told.evidence[0] > 0, seen >= SHARP_VISIBILITY)
    assert SHARP_VISIBILITY > 0.2


def test_the_colours_of_the_clothes_are_learnt():
    show = SlowInstance()
    for _ in range(4):
        told = show.see(standing(2.5))
    shape = read_shape()
    front = ~shape.surface.head & (shape.surface.outward[:, 0] > 0.8) & (shape.surface.position[:, 2] < 0.8)
    shirt = hsi(np.array([SHIRT], np.uint8))[0]
    assert np.median(told.mean[0, front, 0]) == pytest.approx(shirt[0], abs=0.03)
    assert np.median(told.mean[0, front, 2]) == pytest.approx(shirt[2], abs=0.05)


def test_unseen_sides_are_predicted_unless_that_is_switched_off():
    told = {}
    for predict in (True, False):
        show = SlowInstance(predict_colors=predict)
        for _ in range(3):
            told[predict] = show.see(standing(2.5))
    back = told[True].evidence[0] == 0
    assert back.sum() > 10
    assert (told[False].mean[0, back] == 0).all()
    assert (told[True].mean[0, back, 2] > 0.05).all()


def test_who_returns_in_the_same_clothes_has_the_same_number_and_height():
    show = SlowInstance()
    for _ in range(6):
        show.see(standing(2.5, height=1.85))
    known = show.stage.people[0].stature
    show.leave()
    assert [p.absent for p in show.stage.people] == [True]
    for _ in range(3):
        told = show.see(standing(3.0, 0.5, height=1.85))
    assert numbers(told) == [1]
    assert len(show.stage.people[0].stature.sizes) >= len(known.sizes) >= 5
    assert known.by_size > 1.75
    assert told.pose[0, 0] == pytest.approx(3.0, abs=0.4)


def test_who_comes_in_other_clothes_is_another_person():
    show = SlowInstance()
    for _ in range(6):
        show.see(standing(2.5))
    show.leave()
    for _ in range(4):
        told = show.see(standing(2.5), front=GREEN, back=GREEN)
    assert numbers(told) == [1, 2]


def test_people_are_remembered_for_a_time():
    show = SlowInstance(memory_time=3.0)
    for _ in range(6):
        show.see(standing(2.5))
    assert numbers(show.leave(4)) == [1]
    assert numbers(show.leave(5)) == []
    for _ in range(4):
        told = show.see(standing(2.5))
    assert numbers(told) == [2]


def test_who_surely_is_an_upper_body_is_no_arm_of_the_nearer_person_beside():
    behind, near = standing(4.0, 0.6), standing(1.8)
    unsure, sure = SlowInstance(), SlowInstance()
    for _ in range(4):
        unsure.see(behind, near, score=1.5)
        sure.see(behind, near, score=5.0)
    assert len(unsure.stage.people) == 1
    assert len(sure.stage.people) == 2


def test_who_is_near_does_not_get_the_box_of_who_is_far_and_who_seemed_far_can_be_near():
    """A board hides the legs."""
    show, still = SlowInstance(), np.zeros(1, bool)

    def given(known, box):
        for number in range(4):
            pixels = np.roll(drawn(show.camera, known), 2 * (number % 2), axis=1)
            pixels[150:] = 0
            show.see_pixels(pixels, boxed=[known], score=2.0)
        (person,) = show.stage.people
        picture, now = picture_of(show.camera, drawn(show.camera, box)), person.seen + SECOND // 2
        show.stage.people = []
        return show.stage.assignment.pairs(
            [person], [detection_of(show.camera, box)], still, still, picture, now
        )

    assert given(standing(2.0), standing(5.5, height=1.5)) == []
    assert given(standing(5.5, height=1.5), standing(2.0)) == [(0, 0)]


def test_who_walks_gets_the_box_ahead_and_not_that_of_whom_it_has_passed():
    """At 0.8 m/s; somebody in the same clothes then appears where the person was half a second before."""
    show = SlowInstance()
    for number in range(5):
        show.see(standing(2.5, 0.4 * number - 1.2))
    (walker,) = show.stage.people
    there = [standing(2.5, walker.track.pose[1] + away) for away in (0.0, 0.4)]
    told = show.see(*there)
    assert told.pose[numbers(told).index(walker.number), 1] == pytest.approx(there[1][1], abs=0.2)


@pytest.mark.parametrize(("height", "people"), [(1.7, [1]), (1.4, [1]), (1.1, []), (2.35, [])])
def test_boxes_that_are_of_no_adult_initiate_nobody(height, people):
    """Hips and legs of somebody look like the upper body of a small child."""
    show, body = SlowInstance(), standing(3.0)
    for _ in range(6):
        told = show.see(body, boxed=[standing(3.0, height=height)], score=4.0)
    assert numbers(told) == people


def test_a_second_box_on_a_body_initiates_nobody():
    show = SlowInstance()
    for _ in range(3):
        show.see(standing(2.5))
    for _ in range(4):
        told = show.see(standing(2.5), boxed=[standing(2.5), standing(2.5, 0.2, 1.5)])
    assert numbers(told) == [1]
    assert len(show.stage.people) == 1


def test_a_body_with_boxes_of_its_own_and_of_its_head_is_one_person_from_the_first_picture_on():
    """The box of the head looks like that of somebody twice as far away."""
    show = SlowInstance(particles=200)  # of 60, poses of one picture scatter by 0.2 m
    behind = standing(5.5, height=2.2)
    for _ in range(6):
        told = show.see(standing(2.5), boxed=[behind, standing(2.5)])
    assert numbers(told) == [1]
    assert told.pose[0, 0] == pytest.approx(2.5, abs=0.2)


def test_a_box_on_who_is_hidden_is_that_of_the_nearer_person():
    show = SlowInstance()
    for step in range(5):
        there = [standing(4.0, 1.2), standing(2.2, -0.3 + 0.1 * step)]
        show.see(*there)
    assert len(show.stage.people) == 2
    for _ in range(8):
        told = show.see(standing(2.2, 0.66), boxed=[standing(4.0, 1.2), standing(2.2, 0.66)])
    known = {p.number: p.absent for p in show.stage.people}
    assert numbers(told) == [1, 2]
    assert sorted(known.values()) == [False, True]


def see_part(show, pose, top, bottom):
    """What the stage says of a person of whom the detector finds a part of the upper body, by its height."""
    frame = frame_of(show.camera, drawn(show.camera, pose), show.number / 2, show.number)
    show.number += 1
    boxes = boxes_of(show.camera, frame, pose)
    x0, y0, x1, y1 = boxes.box[0]
    half, middle, tall = (bottom - top) * (x1 - x0) / 2, (x0 + x1) / 2, y1 - y0
    part = np.array([[middle - half, y0 + top * tall, middle + half, y0 + bottom * tall]])
    return show.stage.process(
        frame, gradients_of(show.camera, frame), stamped(replace(boxes, box=part), frame.header)
    )


@pytest.mark.parametrize(("top", "bottom"), [(0.1, 0.5), (1.1, 1.6)])
def test_boxes_of_a_head_or_a_hip_prolong_a_person_and_are_nobody_else(top, bottom):
    show = SlowInstance(maximum_missed_time=0.9)
    for _ in range(4):
        told = show.see(standing(3.0))
    place = told.pose[0, :2]
    show.stage.people = [replace(person, left=True) for person in show.stage.people]
    for _ in range(6):
        told = see_part(show, standing(3.0), top, bottom)
    assert told.left.tolist() == [0]
    (person,) = show.stage.people
    assert not person.absent
    assert told.pose[0, :2] == pytest.approx(place)


def test_without_feet_the_size_of_sure_boxes_tells_the_distance_rather_than_edges():
    show = SlowInstance()
    told = [show.see(standing(3.4), boxed=[standing(3.0)], score=5.0) for _ in range(6)]
    places = np.concatenate([one.pose[:, :2] for one in told[2:]])
    assert np.linalg.norm(places - show.camera.center[:2], axis=1).mean() < 3.03


def test_boxes_of_changing_size_hardly_move_who_stands_still():
    """Five pictures a second, with boxes of a person an eighth nearer and an eighth farther away in turn."""
    show, distance = SlowInstance(), []
    for number in range(14):
        pixels = np.roll(drawn(show.camera, standing(3.0)), 2 * (number % 2), axis=1)
        frame = frame_of(show.camera, pixels, number / 5, number)
        share = 1.125 if number % 2 else 0.875
        boxes = boxes_of(show.camera, frame, standing(3.0 * share, height=1.2 + 0.5 * share), score=5.0)
        told = show.stage.process(frame, gradients_of(show.camera, frame), boxes)
        distance += np.hypot(*told.pose[:, :2].T).tolist()
    assert np.abs(np.diff(distance[4:])).mean() < 0.06


def test_two_people_have_two_numbers_that_stay():
    show = SlowInstance()
    for step in range(6):
        told = show.see(standing(3.0, -0.9 + 0.1 * step), standing(3.0, 0.9 - 0.1 * step), score=2.0)
    assert numbers(told) == [1, 2]
    assert sorted(np.sign(told.pose[:, 1])) == [-1, 1]


def test_known_people_come_before_tentative_ones_whose_colours_nobody_knows():
    """In other light the known person looks strange, and the box lies nearer to the tentative one."""
    show = SlowInstance()
    for _ in range(6):
        show.see(standing(2.5))
    (known,) = show.stage.people
    frame = frame_of(show.camera, drawn(show.camera, standing(2.5)), show.number / 2)
    seen = show.stage.observed(frame, gradients_of(show.camera, frame), boxes_of(show.camera, frame))
    tentative = show.stage.update.initiated(
        detection_of(show.camera, standing(2.5, 0.2)), 1.0, np.empty((0, 4)), seen
    )
    dim = picture_of(show.camera, (drawn(show.camera, standing(2.5, 0.15)) * 0.3).astype(np.uint8))
    box = [detection_of(show.camera, standing(2.5, 0.15))]
    now, moving = known.seen + SECOND // 2, np.zeros(1, bool)
    assert show.stage.assignment.pairs([tentative, known], box, moving, moving, dim, now) == [(1, 0)]
    assert show.stage.assignment.pairs([tentative], box, moving, moving, dim, now) == [(0, 0)]
    assert (
        show.stage.assignment.pairs([replace(known, comparable=True)], box, ~moving, moving, dim, now) == []
    )


def test_boxes_of_the_background_and_of_people_seen_without_one_initiate_nobody():
    show = SlowInstance()
    frame = frame_of(show.camera, drawn(show.camera), 0.0)
    boxes = boxes_of(show.camera, frame, standing(2.5, -0.7), standing(2.5, 0.7), score=1.0)
    unclaimed, nobody = show.stage.assignment.unclaimed, np.empty((0, 4))
    assert unclaimed(boxes, [], nobody, np.array([0.8, 0.8])) == [0, 1]
    assert unclaimed(boxes, [], nobody, np.array([0.8, 2.3])) == [0]
    assert unclaimed(boxes, [], boxes.box[:1], np.array([0.8, 0.8])) == [1]
    assert unclaimed(boxes, [(0, 1)], nobody, np.array([0.8, 0.8])) == [0]


def test_a_successor_knows_the_people_and_gives_no_number_twice():
    before, after = SlowInstance(), SlowInstance()
    for _ in range(8):
        before.see(standing(2.5), score=6.0)
    after.stage.restore(travelled(before.stage.state()))
    after.number = before.number
    np.testing.assert_array_equal(after.stage.people[0].colors.mean, before.stage.people[0].colors.mean)
    assert after.stage.people[0].stature.estimate == before.stage.people[0].stature.estimate
    told, expected = (show.see(standing(2.5), score=6.0) for show in (after, before))
    assert numbers(told) == numbers(expected) == [1]
    np.testing.assert_allclose(told.pose[:, :3], expected.pose[:, :3], atol=0.2)
    for _ in range(3):
        told = after.see(standing(2.5), standing(3.0, 1.2), score=6.0)
    assert numbers(told) == [1, 2]


def test_the_state_of_many_people_is_small():
    show = SlowInstance()
    for _ in range(12):
        show.see(standing(2.5), standing(3.0, 1.2), standing(3.0, -1.2), score=6.0)
    assert len(json.dumps(state_to_data(show.stage.state()))) < 200_000
