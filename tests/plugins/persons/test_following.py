"""The fast instance: who is followed, predicted, missed and deleted, and which cues it uses."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.plugins.persons.drawn import (
    SECOND,
    SHIRT,
    WALL,
    boxes_of,
    drawn,
    frame_of,
    standing,
)
from tests.plugins.persons.shown import PERIOD, FastInstance
from tests.travelled import travelled

from followspot.messages import Header, identical, stamped
from followspot.tracking import PREDICTED, TRACKED
from followspot_persons.background.floor_contact import STRIDE_SIGMA
from followspot_persons.fast_instance.slow_pose import is_other_body, particles_about


def test_a_person_is_followed_while_it_walks():
    room = FastInstance()
    room.tell(standing(2.5, -0.3))
    for step in range(8):
        place = standing(2.5, -0.3 + 0.06 * step)
        seen = room.see(place, boxed=[place])
    assert seen.state.tolist() == [TRACKED]
    assert seen.xy[0, 1] == pytest.approx(place[1], abs=0.06)
    assert room.stage.people[1].track.velocity[1] == pytest.approx(0.6, abs=0.3)


def test_a_successor_follows_the_same_people():
    before, after = FastInstance(), FastInstance()
    before.tell(standing(2.5, -0.3))
    for _ in range(4):
        before.see(standing(2.5, -0.3), boxed=[standing(2.5, -0.3)])
    after.stage.restore(travelled(before.stage.state()))
    after.stage.rng.bit_generator.state = before.stage.rng.bit_generator.state
    after.number, after.told = before.number, before.told
    for _ in range(3):
        told, expected = (room.see(standing(2.5, -0.25)) for room in (after, before))
        assert expected.person.tolist() == [1]
        assert identical(told, expected)


@pytest.mark.parametrize(("precision", "distance"), [(400.0, 3.0), (0.0, 2.5)])
def test_who_stands_elsewhere_by_the_feet_is_followed_there(precision, distance):
    """The body's size and height say 2.5 m."""
    room = FastInstance()
    for _ in range(8):
        room.tell(standing(2.5), stands=(3.0, precision))
        found = room.see(standing(2.5), boxed=[])
    assert found.xy[0, 0] == pytest.approx(distance, abs=0.2)


def test_without_a_slow_instance_nobody_is_followed():
    assert len(FastInstance().see(standing(2.5)).person) == 0


def followed_for(room, pictures, *poses, **more):
    """States in pictures with the same bodies."""
    return [room.see(*poses, **more).state.tolist() for _ in range(pictures)]


def test_without_boxes_a_person_must_look_ever_more_as_usual_and_a_long_timeout_waits():
    """At a share of 0.5 half of the usual likelihood would do; without boxes for 0.6 s, 1 is asked for."""
    ends = {}
    for timeout in (0.6, 60.0):
        room = FastInstance(box_timeout=timeout, maximum_missed_time=9.0, maximum_unseen_time=99.0)
        room.tell(standing(2.5))
        followed_for(room, 3, standing(2.5), boxed=[standing(2.5)])
        typical = room.stage.people[1].track.typical
        room.stage.people[1] = lifted(room.stage.people[1], 1.3 * typical)
        ends[timeout] = followed_for(room, 8, standing(2.5))[-1]
    assert ends == {0.6: [PREDICTED], 60.0: [TRACKED]}


@pytest.mark.parametrize(("again", "state"), [(False, PREDICTED), (True, TRACKED)])
def test_whom_the_slow_instance_still_sees_needs_no_box(again, state):
    room = FastInstance(maximum_missed_time=9.0, maximum_unseen_time=99.0)
    room.tell(standing(2.5))
    followed_for(room, 3, standing(2.5), boxed=[standing(2.5)])
    room.stage.people[1] = lifted(room.stage.people[1], 1.2 * room.stage.people[1].track.typical)
    for _ in range(8):
        if again:
            room.tell(standing(2.5))
        last = followed_for(room, 1, standing(2.5))
    assert last == [[state]]


def lifted(person, typical):
    return replace(person, track=replace(person.track, typical=typical))


def test_a_box_keeps_a_person_that_looks_less_as_usual():
    room = FastInstance(maximum_missed_time=9.0)
    room.tell(standing(2.5))
    followed_for(room, 3, standing(2.5), boxed=[standing(2.5)])
    room.stage.people[1] = lifted(room.stage.people[1], 1.3 * room.stage.people[1].track.typical)
    assert followed_for(room, 8, standing(2.5), boxed=[standing(2.5)])[-1] == [TRACKED]


@pytest.mark.parametrize(("share", "state"), [(0.3, TRACKED), (0.95, PREDICTED)])
def test_a_person_below_a_share_of_the_usual_likelihood_is_missed(share, state):
    room = FastInstance(minimum_likelihood_share=share, box_timeout=99.0)
    room.tell(standing(2.5))
    followed_for(room, 3, standing(2.5), boxed=[standing(2.5)])
    room.stage.people[1] = lifted(room.stage.people[1], 2 * room.stage.people[1].track.likelihood)
    assert followed_for(room, 1, standing(2.5), boxed=[standing(2.5)]) == [[state]]


def test_who_is_missed_coasts_and_is_deleted_in_time():
    room = FastInstance(maximum_missed_time=0.35)
    room.tell(standing(2.5))
    followed_for(room, 3, standing(2.5), boxed=[standing(2.5)])
    assert followed_for(room, 6) == [[PREDICTED]] * 3 + [[]] * 3


def test_whom_the_slow_instance_sees_no_more_is_deleted_however_well_it_fits():
    room = FastInstance(maximum_unseen_time=0.45, box_timeout=99.0)
    room.tell(standing(2.5))
    states = []
    for _ in range(8):
        states += followed_for(room, 1, standing(2.5), boxed=[standing(2.5)])
        room.told = stamped(room.told, Header("c", room.number, int(room.number * PERIOD * SECOND)))
    assert states == [[TRACKED]] * 5 + [[]] * 3


def test_before_whose_place_the_slow_instance_sees_the_background_is_deleted_at_once():
    room = FastInstance()
    room.tell(standing(2.5, -0.5), standing(2.5, 0.5))
    room.see(standing(2.5, -0.5), standing(2.5, 0.5))
    room.tell(standing(2.5, -0.5), standing(2.5, 0.5), left=[2])
    assert room.see(standing(2.5, -0.5), standing(2.5, 0.5)).person.tolist() == [1]


def test_a_box_belongs_to_whom_the_slow_instance_gave_it():
    """The fast instance has strayed from a person by a metre, at whom the slow one sees a box."""
    room = FastInstance()
    room.tell(standing(2.5, -0.7))
    room.see(standing(2.5, -0.7))
    room.tell(standing(2.5, 0.7))
    frame = frame_of(room.camera, drawn(room.camera), room.number * PERIOD, room.number)
    room.stage.correct_by_slow_poses(room.told, frame.header.time)
    boxes = boxes_of(room.camera, frame, standing(2.5, 0.7))
    assert list(room.stage.detections(boxes, frame.header.time, 0.1)) == [1]


def test_poses_of_the_slow_instance_move_a_lost_person():
    away = {}
    for again in (False, True):
        room = FastInstance(maximum_missed_time=9.0)
        room.tell(standing(2.5, -0.6))
        followed_for(room, 2, standing(2.5, 0.6))
        if again:
            room.tell(standing(2.5, 0.6))
        followed_for(room, 6, standing(2.5, 0.6))
        away[again] = abs(room.stage.people[1].track.pose[1] - 0.6)
    assert away[False] > 0.3
    assert away[True] < 0.15


def test_a_late_pose_of_the_slow_instance_joins_the_particles_where_the_person_is_by_now():
    room = FastInstance(particles=200)
    room.tell(standing(2.5, -0.3))
    for step in range(6):
        room.see(standing(2.5, -0.3 + 0.06 * step))
    person = room.stage.people[1]
    then, now = person.history.at(round(0.11 * SECOND)), person.track.pose
    room.number = 1
    room.tell(standing(2.5, 0.1))
    room.stage.correct_by_slow_poses(room.told, round(0.6 * SECOND))
    joined = room.stage.people[1].track.particles[-20:]
    assert now[1] - then[1] > 0.15
    assert np.median(joined[:, 1]) == pytest.approx(0.1 + now[1] - then[1], abs=0.05)


FEET, VAGUE = (2.5, STRIDE_SIGMA**-2), (2.5, 4.0)


@pytest.mark.parametrize(
    ("stands", "shown", "moved"),
    [
        ((0.0, 0.0), 1.0, True),
        (FEET, 1.0, False),
        (VAGUE, 1.0, False),
        (FEET, 0.7, False),
        (VAGUE, 0.7, True),
    ],
)
def test_a_track_goes_half_way_to_the_distance_that_the_slow_instance_tells_unless_feet_do(
    stands, shown, moved
):
    """A distance that feet told earlier does not count while the person is partly hidden."""
    room = FastInstance(particles=200)
    room.tell(standing(2.5))
    followed_for(room, 3, standing(2.5))
    known = room.stage.people[1]
    room.stage.people[1] = replace(known, track=replace(known.track, shown=shown))
    own = known.track.pose
    room.number -= 1
    room.tell(standing(3.1), stands=stands)
    room.stage.correct_by_slow_poses(room.told, round(0.2 * SECOND))
    pose = room.stage.people[1].track.pose
    assert pose[0] == pytest.approx((own[0] + 3.1) / 2 if moved else own[0], abs=0.05)
    np.testing.assert_array_equal(pose[2:], own[2:])


def test_who_was_followed_elsewhere_than_the_slow_instance_says_is_followed_there_at_once():
    room = FastInstance(particles=200)
    room.tell(standing(2.5, -0.6))
    followed_for(room, 4, standing(2.5, -0.6))
    girth = room.stage.people[1].track.girth
    room.tell(standing(2.5, 0.3))
    poses = room.see(standing(2.5, -0.6), standing(2.5, 0.3))
    assert poses.xy[0, 1] == pytest.approx(0.3, abs=0.1)
    assert room.stage.people[1].track.girth.mean == pytest.approx(girth.mean, abs=0.05)


@pytest.mark.parametrize(("pose", "expected"), [((2.5, 0.5), True), ((3.0, 0.0), False)])
def test_slow_poses_are_vague_along_the_line_of_sight_and_not_across(pose, expected):
    room = FastInstance()
    assert is_other_body(standing(2.5), standing(*pose), room.stage.camera.center) is expected


def test_a_fifth_of_the_particles_about_a_slow_pose_may_look_the_other_way():
    particles = particles_about(standing(2.5, heading=0.0), 200, np.random.default_rng(1))
    assert 0.08 < (np.cos(particles[:, 3]) < 0).mean() < 0.2
    assert (np.cos(particles[40:, 3]) > 0).all()


def test_colours_tell_front_from_back_and_can_be_switched_off():
    """The outline of a body is nearly the same from behind; the slow instance says the wrong side."""
    room = FastInstance(particles=200)
    room.tell(standing(2.5, heading=0.0))
    followed_for(room, 8, standing(2.5, heading=np.pi))
    assert np.cos(room.stage.people[1].track.pose[3]) < -0.7
    likelihoods = []
    for shirt in (SHIRT, WALL):
        blind = FastInstance(use_colors=False)
        blind.tell(standing(2.5), front=shirt, back=shirt)
        followed_for(blind, 1, standing(2.5))
        likelihoods.append(blind.stage.people[1].track.likelihood)
    assert likelihoods[0] == likelihoods[1]


def test_headings_of_the_detector_turn_a_person():
    room = FastInstance(use_colors=False, particles=200)
    room.tell(standing(2.5, heading=0.0))
    followed_for(room, 8, standing(2.5), boxed=[standing(2.5)])
    assert np.cos(room.stage.people[1].track.pose[3]) < -0.7


def test_nearer_people_come_first_because_they_hide_others():
    room = FastInstance()
    room.tell(standing(3.5, 0.05), standing(1.8, 0.0))
    order = []
    follow = room.stage.update

    def noted(number, *rest):
        order.append(number)
        return follow(number, *rest)

    room.stage.update = noted
    room.see(standing(3.5, 0.05), standing(1.8))
    room.see(standing(3.5, 0.05), standing(1.8), boxed=[standing(1.8)])
    assert order == [2, 1, 2, 1]
    assert room.stage.people[1].track.shown < 0.4
    assert room.stage.people[2].track.shown == 1.0


def test_boxes_are_used_once_and_given_to_the_nearest_person():
    room = FastInstance()
    room.tell(standing(2.5, -0.7), standing(2.5, 0.7))
    room.see(standing(2.5, -0.7), standing(2.5, 0.7))
    frame = frame_of(room.camera, drawn(room.camera), room.number * PERIOD, room.number)
    boxes = boxes_of(room.camera, frame, standing(2.5, 0.7))
    assert list(room.stage.detections(boxes, frame.header.time, 0.1)) == [2]
    assert room.stage.detections(boxes, frame.header.time, 0.1) == {}


@pytest.mark.parametrize("features", [1, 7])
def test_colours_of_another_shape_do_not_count_and_are_told_of_once(features):
    show, warnings = FastInstance(difference_weight=1.0), []
    show.stage.context = replace(show.stage.context, warn=warnings.append)
    show.tell(standing(2.5))
    told = {name: getattr(show.told, name)[:, :features] for name in ("mean", "variance", "evidence")}
    show.told = stamped(replace(show.told, **told), show.told.header)
    for _ in range(3):
        poses = show.see(standing(2.5), boxed=[standing(2.5)])
    assert poses.person.tolist() == [1]
    assert warnings == [f"colours of {features} features do not count, 45 are in this stage's shape"]
