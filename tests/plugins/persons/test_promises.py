"""What the documents promise of people over cameras and of their identities, each by a small case."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.plugins.persons.crowded import corner_room, crowded, followed
from tests.plugins.persons.drawn import (
    BLUE,
    RED,
    SECOND,
    clothes,
    drawn,
    frame_of,
    gradients_of,
    in_red_and_blue,
    perspective,
    picture_of,
    standing,
)
from tests.plugins.persons.fused_cameras import RATE, Cameras
from tests.plugins.persons.joint_tracks import bodies

from followspot.people import Boxes
from followspot.points import Points2D
from followspot_persons.associate.detections import boxes_of
from followspot_persons.associate.joints import tracks as joint_tracks
from followspot_persons.associate.joints.skeleton_pose import poses_of
from followspot_persons.associate.multi_view.views import Noise, views_of
from followspot_persons.background.floor_contact import STRIDE_SIGMA, Contact
from followspot_persons.body.shape import read_shape
from followspot_persons.body.stature import Stature
from followspot_persons.body.view import view
from followspot_persons.color.difference import read_relations
from followspot_persons.color.hsi import hsi
from followspot_persons.color.model import ColorModel
from followspot_persons.fast_instance.pose_history import propagated_detection
from followspot_persons.likelihood.fitness import Detection, pictured
from followspot_persons.particles.track import Track
from followspot_persons.slow_instance.box_assignment import BoxAssignment
from followspot_persons.slow_instance.floor_distance import FloorDistance
from followspot_persons.slow_instance.identity import same_person
from followspot_persons.slow_instance.known_person import KnownPerson
from followspot_persons.slow_instance.recognition import LIKENESS_MARGIN, MAXIMUM_WAIT, Recognition
from followspot_persons.slow_instance.validation_gate import ValidationGate
from followspot_sim.actor.landmarks import NAMES


def doubled(points: Points2D, words: tuple[str, ...], shift: float) -> Points2D:
    """The points, and those whose names have one of the words once more, as other people's."""
    named = np.array([any(word in name for word in words) for name in points.labels])[points.label]
    again = points.where(named)
    parts = {
        column: np.concatenate([getattr(points, column), getattr(again, column)])
        for column in ("label", "score")
    }
    instance = np.concatenate([points.instance, again.instance + 100])
    places = {
        column: np.concatenate([getattr(points, column), getattr(again, column) + shift])
        for column in ("pixel", "xy")
    }
    found = replace(points, instance=instance.astype(np.int32), **parts, **places)
    found.__dict__["header"] = points.header
    return found


@pytest.mark.parametrize(
    ("words", "since"), [(("",), 0), (("ankle", "knee"), 6)], ids=["the whole body twice", "legs alone"]
)
def test_a_person_whom_a_network_finds_twice_is_one(words: tuple[str, ...], since: int) -> None:
    room, sets, _ = crowded(people=2, frames=14, fps=10, seed=3)
    twice = [
        tuple((doubled(p, words, 3.0) if frame >= since else p, b) for p, b in each)
        for frame, each in enumerate(sets)
    ]
    out = followed(room, twice, "points")
    assert max(len(each.poses.person) for each in out) == 2
    assert set(np.concatenate([each.poses.person for each in out]).tolist()) == {1, 2}


def test_a_point_far_off_moves_a_joint_less_than_one_that_is_a_little_off() -> None:
    view = views_of(tuple(corner_room().cameras.values())).each[0]
    known, noise = bodies(0.03), Noise(2.0, 0.03, 0.01)
    points = joint_tracks.expected(known, view, noise)
    row = NAMES.index("left_wrist")

    def moved(pixels: float) -> float:
        found = points.there.copy()
        found[0, row, 0] += pixels
        after = joint_tracks.updated(known, points, found, np.ones(1))
        return float(np.linalg.norm(after.xyz[0, row] - known.xyz[0, row]))

    assert moved(400.0) < moved(60.0)
    assert moved(10.0) == pytest.approx(moved(5.0) * 2, rel=0.01)


def test_of_two_boxes_on_one_person_the_surer_stays() -> None:
    camera = next(iter(corner_room().cameras.values()))
    box = np.array([[300.0, 200, 400, 500], [305, 205, 405, 505], [600, 200, 700, 500]])
    none = np.zeros((3, 0))
    boxes = Boxes(camera.name, box, np.array([0.5, 0.9, 0.4]), none, none)
    found = boxes_of(boxes, camera, 0.6, 0.1).measured
    np.testing.assert_allclose(found, box[[1, 2]], atol=1e-6)
    assert len(boxes_of(boxes, camera, 0.95, 0.1).measured) == 3


def test_a_level_face_has_no_tilt_and_a_raised_one_has() -> None:
    names = ("left_ear", "right_ear", "nose", "left_shoulder", "right_shoulder")
    head = np.array([[0.0, 0.08, 1.65], [0.0, -0.08, 1.65], [0.13, 0.0, 1.615]])
    shoulders = np.array([[0.0, 0.2, 1.4], [0.0, -0.2, 1.4]])
    turn = np.array([[np.cos(0.4), 0, -np.sin(0.4)], [0, 1, 0], [np.sin(0.4), 0, np.cos(0.4)]])
    xyz = np.stack([np.vstack([head, shoulders]), np.vstack([head @ turn.T, shoulders])])
    level, raised = poses_of(names, xyz, np.full(xyz.shape[:2], 0.01)).pose[:, 5]
    assert abs(level) < 0.03
    assert raised == pytest.approx(0.4, abs=0.03)


def known_person(number: int, initiated: int, seen: int) -> KnownPerson:
    """Somebody in usual clothes."""
    relations = read_relations()
    features = len(relations.mean)
    model = ColorModel(relations.mean, np.full((features, 3), 0.01), np.full(features, 20.0))
    track = Track.initiated(np.tile(standing(2.0), (10, 1)))
    known = KnownPerson(number, track, model, initiated, seen, 9, 99.0, absent=number > 0)
    stature = Stature()
    for _ in range(20):
        stature = stature.sized(1.75, 1.2)
    return replace(known, stature=stature)


@pytest.mark.parametrize(("left", "number"), [(10, 1), (30, 2)])
def test_who_was_seen_beside_a_newcomer_is_somebody_else(left: int, number: int) -> None:
    known, newcomer = known_person(1, 0, left), known_person(0, 20, 40)
    people, numbers = Recognition(2.0, 0.0, read_relations()).applied([known, newcomer], 1)
    assert max(p.number for p in people) == numbers == number


@pytest.mark.parametrize(
    ("missing", "waited", "number"),
    [
        (0.0, 0.1, 1),
        (0.5 * LIKENESS_MARGIN, 0.1, 0),
        (0.5 * LIKENESS_MARGIN, MAXIMUM_WAIT, 2),
        (1.5 * LIKENESS_MARGIN, 0.1, 2),
    ],
    ids=["known", "waits", "has waited", "somebody else"],
)
def test_who_may_be_a_lost_person_waits_for_a_number(missing: float, waited: float, number: int) -> None:
    known, newcomer = known_person(1, 0, 10), known_person(0, 20, 20 + round(waited * SECOND))
    likeness = Recognition(2.0, 0.0, read_relations()).likeness(newcomer, known)
    recognition = Recognition(2.0, likeness + missing, read_relations())
    people, _ = recognition.applied([known, newcomer], 1)
    (same,) = (p for p in people if p.initiated == newcomer.initiated)
    assert same.number == number


def test_equal_clothes_on_bodies_of_other_heights_are_two_people() -> None:
    model = known_person(1, 0, 0).colors
    alike = same_person(model, model, (1.75, 1.75), read_relations())
    other = same_person(model, model, (1.60, 1.85), read_relations())
    assert alike > 0
    assert other < alike - 5


def test_a_head_that_turned_since_a_detection_turns_its_directions() -> None:
    camera, shape = perspective(), read_shape()
    table = np.zeros(8)
    table[0] = 4.0
    then = standing(2.0)
    now = then.copy()
    now[4] += np.pi / 2  # pan
    found = propagated_detection(Detection(np.zeros(4), table, table), camera, shape, then, now)
    assert found.torso.argmax() == 0
    assert found.head.argmax() == 2


def test_a_camera_keeps_its_person_beside_a_stranger_who_is_a_little_nearer() -> None:
    cameras = Cameras()
    for _ in range(RATE):
        cameras.tell(("a", 1, 2.0, 0.0))
    for _ in range(3):
        told = cameras.tell(("a", 1, 2.0, 0.12), ("a", 2, 2.0, -0.08))
    assert told.xy[0, 1] > 0


def test_people_who_cross_get_the_boxes_of_their_colours() -> None:
    camera, shape = perspective(), read_shape()
    left, right = standing(2.5, 0.3), standing(2.5, -0.3)
    pixels = in_red_and_blue(camera, red=right, blue=left)
    frame = frame_of(camera, pixels, SECOND, 1)
    picture = pictured(camera, frame, gradients_of(camera, frame))
    boxes = view(camera, shape, np.stack([left, right])).box
    detections = [Detection(box, np.zeros(0), np.zeros(0)) for box in boxes]
    people = []
    for color, across in ((RED, 0.02), (BLUE, -0.02)):  # each a little nearer to the other's box
        mean = hsi(clothes(shape, color, color).astype(np.uint8)).astype(float)
        model = ColorModel(mean, np.full(mean.shape, 0.01), np.full(len(mean), 20.0))
        known = known_person(len(people) + 1, 0, SECOND // 2)
        track = Track.initiated(np.tile(standing(2.5, across), (10, 1)))
        people.append(replace(known, absent=False, colors=model, track=track))
    assignment = BoxAssignment(camera, shape, read_relations())
    pairs = assignment.pairs(people, detections, *np.zeros((2, 2), bool), picture, SECOND)
    assert sorted(pairs) == [(0, 1), (1, 0)]


def test_nobody_takes_the_box_of_somebody_much_nearer() -> None:
    camera, shape, told = perspective(), read_shape(), standing(3.6, 0.0)
    picture = picture_of(camera, drawn(camera, standing(1.2, 0.0)))
    track = Track.initiated(np.tile(told, (10, 1)))
    person = replace(known_person(1, 0, SECOND - SECOND // 5), absent=False, track=track)
    assignment = BoxAssignment(camera, shape, read_relations())
    for away, pairs in ((1.2, []), (2.4, [(0, 0)])):
        box = view(camera, shape, standing(away, 0.0)[None]).box[0]
        detections = [Detection(box, np.zeros(0), np.zeros(0))]
        assert assignment.pairs([person], detections, *np.zeros((2, 1), bool), picture, SECOND) == pairs


def test_nobody_whose_feet_were_seen_takes_the_box_of_somebody_of_another_height() -> None:
    """A body of 1.7 m at 2.6 m walks on by 0.2 m; somebody of 1.5 m has its head 0.2 m lower."""
    camera, shape = perspective(), read_shape()
    picture = picture_of(camera, drawn(camera, standing(2.6, 0.0)))
    track = Track.initiated(np.tile(standing(2.6, 0.0), (10, 1)))
    known = replace(known_person(1, 0, SECOND - SECOND // 5), absent=False, track=track)
    height = Stature(np.full(9, 1.7), np.ones(9), 0.03)
    person = replace(known, distance=FloorDistance.of(Contact(2.6, STRIDE_SIGMA)), stature=height)
    assignment = BoxAssignment(camera, shape, read_relations())
    for away, tall, given in ((2.4, 1.7, True), (2.6, 1.75, True), (2.6, 1.5, False), (2.6, 2.1, False)):
        pose = standing(away, 0.0)
        pose[2] = tall
        detections = [Detection(view(camera, shape, pose[None]).box[0], np.zeros(0), np.zeros(0))]
        pairs = assignment.pairs([person], detections, *np.zeros((2, 1), bool), picture, SECOND)
        assert pairs == ([(0, 0)] if given else []), (away, tall)


def test_nobody_whose_feet_were_seen_takes_the_box_of_somebody_nearer() -> None:
    """At 3.6 m by feet, it can be at 3.3 m 0.2 s later; by sizes of boxes alone at 2.4 m, too."""
    camera, shape, told = perspective(), read_shape(), standing(3.6, 0.0)
    picture = picture_of(camera, drawn(camera, standing(2.4, 0.0)))
    track = Track.initiated(np.tile(told, (10, 1)))
    by_size = replace(known_person(1, 0, SECOND - SECOND // 5), absent=False, track=track)
    by_feet = replace(by_size, distance=FloorDistance.of(Contact(3.6, STRIDE_SIGMA)))
    assignment = BoxAssignment(camera, shape, read_relations())
    for away, by_feet_too in ((2.4, False), (3.3, True)):
        box = view(camera, shape, standing(away, 0.0)[None]).box[0]
        detections = [Detection(box, np.zeros(0), np.zeros(0))]
        for person, given in ((by_size, True), (by_feet, by_feet_too)):
            pairs = assignment.pairs([person], detections, *np.zeros((2, 1), bool), picture, SECOND)
            assert pairs == ([(0, 0)] if given else [])


def test_who_was_hidden_for_a_picture_takes_no_box_of_who_stands_before_it() -> None:
    """Feet at 3.9 m, hidden since 0.4 s, beside feet at 2.9 m whose box is one picture old; the new box, of
    2.9 m, lies nearer to where the farther person is expected.
    """
    camera, shape = perspective(), read_shape()
    picture = picture_of(camera, drawn(camera, standing(2.9, 0.1)))
    people = []
    for number, (away, aside, age) in enumerate(((2.9, -0.05, 0.2), (3.9, 0.13, 0.4)), 1):
        track = Track.initiated(np.tile(standing(away, aside), (10, 1)))
        known = replace(known_person(number, 0, int(SECOND * (1 - age))), absent=False, track=track)
        people.append(replace(known, distance=FloorDistance.of(Contact(away, STRIDE_SIGMA))))
    box = view(camera, shape, standing(2.9, 0.1)[None]).box[0]
    detections = [Detection(box, np.zeros(0), np.zeros(0))]
    assignment = BoxAssignment(camera, shape, read_relations())
    assert assignment.pairs(people, detections, *np.zeros((2, 1), bool), picture, SECOND) == [(0, 0)]
    assert assignment.pairs(people[1:], detections, *np.zeros((2, 1), bool), picture, SECOND) == [(0, 0)]


def test_a_small_box_of_a_part_is_still_that_of_the_person() -> None:
    """A box three sigmas too far away is unlikely of an upper body; an unsure one may be of a head."""
    boxes = [view(perspective(), read_shape(), standing(away, 0.0)[None]).box[0] for away in (3.0, 6.0)]
    person = replace(known_person(1, 0, SECOND), distance=FloorDistance.of(Contact(3.0, STRIDE_SIGMA)))
    for certainty, most in ((1.0, np.inf), (0.2, 1.0)):
        detections = [Detection(box, np.zeros(0), np.zeros(0), certainty) for box in boxes]
        whole, small = ValidationGate.of(perspective(), detections).sigmas(person, 0.2)
        assert whole < 0.5
        assert small < most
        assert (small > 3.0) == (certainty == 1.0)


def test_a_box_far_aside_must_have_the_colours_of_the_person() -> None:
    camera, shape, aside = perspective(), read_shape(), standing(2.5, 0.8)
    frame = frame_of(camera, drawn(camera, aside, front=BLUE, back=BLUE), SECOND, 1)
    picture = pictured(camera, frame, gradients_of(camera, frame))
    detections = [Detection(view(camera, shape, aside[None]).box[0], np.zeros(0), np.zeros(0))]
    assignment, taken = BoxAssignment(camera, shape, read_relations()), {}
    for name, color in (("red", RED), ("blue", BLUE)):
        mean = hsi(clothes(shape, color, color).astype(np.uint8)).astype(float)
        model = ColorModel(mean, np.full(mean.shape, 0.001), np.full(len(mean), 20.0))
        known = known_person(1, 0, SECOND - SECOND // 5)
        track = Track.initiated(np.tile(standing(2.5, 0.0), (10, 1)))
        person = replace(known, absent=False, colors=model, track=track)
        taken[name] = assignment.pairs([person], detections, *np.zeros((2, 1), bool), picture, SECOND)
    assert taken == {"red": [], "blue": [(0, 0)]}
