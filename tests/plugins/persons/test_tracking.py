"""What keeps people apart and remembered: occlusion, histories of poses, memory of bodies, likeness."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from followspot import Camera
from followspot.context import Context
from followspot.messages import Header, stamped
from followspot.people import Appearances, Boxes, Gradients
from followspot.tracking import PREDICTED, TRACKED, Frame
from followspot_persons.background.floor_contact import STRIDE_SIGMA, WALK, Contact
from followspot_persons.body.shape import read_shape, with_girth
from followspot_persons.body.standing import standing as told
from followspot_persons.body.stature import PROPORTION_SIGMA
from followspot_persons.body.view import HEADING, view
from followspot_persons.color.difference import read_relations
from followspot_persons.color.hsi import from_plane
from followspot_persons.color.model import ColorModel
from followspot_persons.fast_instance.pose_history import (
    PoseHistory,
    propagated_contact,
    propagated_detection,
    propagated_pose,
)
from followspot_persons.fast_instance.slow_pose import SlowPose
from followspot_persons.fast_instance.tracked_person import poses_of
from followspot_persons.frame_sampler import FrameSampler
from followspot_persons.hog.likelihood import heading_log_likelihood
from followspot_persons.likelihood.fitness import Detection, Fitness, Picture, Weights
from followspot_persons.likelihood.occlusion import Shades, covered
from followspot_persons.particles.girth import girths_of
from followspot_persons.particles.spawning import farthest, spawned
from followspot_persons.particles.track import Track
from followspot_persons.pose_fusion.pose_table import fused_pose, pose_table
from followspot_persons.pose_tracker import PoseTracker
from followspot_persons.slow_instance.floor_distance import FloorDistance
from followspot_persons.slow_instance.identity import same_person
from followspot_persons.slow_instance.known_person import KnownPerson

FACING = np.array([[0, -1, 0], [0, 0, -1], [1, 0, 0.0]])
SECOND = 1_000_000_000


def perspective(x=0.0):
    matrix = np.array([[457.0, 0, 319.5], [0, 457.0, 239.5], [0, 0, 1]])
    return Camera("c", "color", (640, 480), matrix, np.zeros(5), FACING, -FACING @ [x, 0, 1.2])


def panorama():
    f = 1396 / (2 * np.pi)
    matrix = np.array([[f, 0, 697.5], [0, f, 129.5], [0, 0, 1]])
    return Camera("c", "color", (1396, 260), matrix, np.zeros(5), FACING, -FACING @ [0, 0, 1.2], "cylinder")


def standing(x, y=0.0, height=1.7, heading=np.pi):
    return np.array([x, y, height, heading, 0.0, 0.0])


def empty(camera):
    pixels = camera.size[0] * camera.size[1]
    edges = np.zeros(pixels, np.uint8)
    return Picture(camera, edges, edges, np.zeros((pixels, 3), np.uint8))


@pytest.mark.parametrize("camera", [perspective(), panorama()])
def test_a_person_right_behind_another_one_is_hidden_and_one_beside_is_not(camera):
    shape = read_shape()
    picture = covered(empty(camera), shape, standing(1.5))
    fitness = Fitness(picture, shape, Weights())
    assert fitness.shown(standing(3.0)) < 0.1
    assert fitness.shown(standing(3.0, 1.5)) == 1.0


def test_a_person_on_the_seam_of_a_panorama_hides_on_both_sides_of_it():
    shape, camera = read_shape(), panorama()
    picture = covered(empty(camera), shape, standing(-1.5, 0.0))
    mask = picture.hidden.reshape(260, 1396)
    assert mask[:, 0].any()
    assert mask[:, -1].any()
    assert not mask[:, 300:1100].any()


def test_who_is_hidden_is_neither_likely_nor_unlikely():
    shape, camera = read_shape(), perspective()
    colors = (np.full((45, 3), 0.5, np.float32), np.full((45, 3), 0.01, np.float32))
    alone = Fitness(empty(camera), shape, Weights(), colors=colors)
    behind = replace(alone, picture=covered(alone.picture, shape, standing(1.5)))
    pose = standing(3.0)[None]
    assert alone.likelihood(pose)[0] < 0.1
    assert 0.3 < behind.likelihood(pose)[0] < 0.5


def test_tentative_people_hide_nobody_with_a_number():
    camera = perspective()
    shape = read_shape()
    before = empty(camera)
    shades = Shades(before, before).behind(0, shape, standing(2.0))
    assert shades.of(1).hidden is None
    assert shades.of(0).hidden.any()
    assert shades.behind(2, shape, standing(2.0)).of(1).hidden.any()


def test_girths_compared_at_once_are_those_of_single_models():
    shape, camera = read_shape(), perspective()
    pose = np.stack([standing(2.0, 0.1, heading=a) for a in np.linspace(-3, 3, 70)])
    together = view(camera, girths_of(shape), pose)
    single = view(camera, with_girth(shape, 0.78), pose[:7])
    np.testing.assert_allclose(together.edge[:7], single.edge, atol=1e-4)
    np.testing.assert_allclose(together.surface[:7], single.surface, atol=1e-4)


def test_a_late_detection_is_moved_and_turned_as_the_person_has_since():
    camera, shape = perspective(), read_shape()
    then, now = standing(3.0, 0.5, heading=np.pi), standing(3.0, -0.5, heading=np.pi + 0.5)
    seen = view(camera, shape, np.stack([then, now]))
    directions = np.arange(16) * (2 * np.pi / 16)
    table = 4 * np.cos(directions - seen.bearing.torso[0])
    carried = propagated_detection(Detection(seen.box[0], table, table), camera, shape, then, now)
    np.testing.assert_allclose(carried.box, seen.box[1])
    tried = np.linspace(-np.pi, np.pi, 721)
    best = tried[heading_log_likelihood(carried.torso, tried).argmax()]
    assert abs(np.angle(np.exp(1j * (best - seen.bearing.torso[1])))) < np.pi / 16


def test_a_late_pose_is_carried_along_the_trail():
    history = PoseHistory()
    for second in range(4):
        history = history.extended(second * SECOND, standing(1.0 + second))
    assert history.at(SECOND + 1)[0] == 2.0
    assert history.at(-1) is None
    carried = propagated_pose(standing(2.1, heading=3.0), history.at(SECOND), standing(4.0, heading=-3.0))
    assert carried[0] == pytest.approx(4.1)
    assert carried[HEADING] == pytest.approx(3.0 + (-3.0 - np.pi + 2 * np.pi) % (2 * np.pi), abs=1e-9)


def test_a_distance_by_the_feet_becomes_vague_with_its_age():
    told = np.array([3.0, 25.0])
    assert propagated_contact(told, 0.0) == Contact(3.0, 0.2)
    assert propagated_contact(told, 2.0).sigma == pytest.approx(np.hypot(0.2, 2 * WALK))
    assert propagated_contact(np.array([3.0, 0.0]), 0.0) is None


def test_a_distance_by_feet_is_sure_until_the_next_picture():
    told = propagated_contact(np.array([3.0, STRIDE_SIGMA**-2]), 0.0)
    assert told.sure
    assert not told.later(0.05).sure
    assert not told.later(0.2).with_size(Contact(3.0, 0.3)).sure


def test_feet_where_nobody_walks_to_in_this_time_are_somebody_elses():
    person = KnownPerson.tentative(
        standing(3.0)[None], 45, 1.0, 0, comparable=True, contact=Contact(4.4, STRIDE_SIGMA)
    )
    near = Contact(4.0, STRIDE_SIGMA)
    distance = person.distance
    assert distance.later(near, None, 0.2).contact == near
    assert distance.later(Contact(3.3, STRIDE_SIGMA), None, 0.2).contact == person.contact.later(0.2)
    assert distance.later(Contact(3.3, STRIDE_SIGMA), None, 1.0).contact.distance == 3.3
    assert distance.later(None, None, 0.2).contact == person.contact.later(0.2)


def test_feet_where_neither_the_last_distance_nor_sizes_are_are_somebody_elses():
    """Feet at 4.8 m were last seen 0.6 s ago; one can walk to 3.9 m, but all boxes say 4.8 m."""
    person = KnownPerson.tentative(
        standing(4.8)[None], 45, 1.0, 0, comparable=True, contact=Contact(4.8, STRIDE_SIGMA)
    )
    feet, size = Contact(3.9, STRIDE_SIGMA), Contact(4.8, 0.4)
    assert person.distance.later(feet, None, 0.6).contact == feet
    distance = replace(person.distance, sized=Contact(4.8, 0.3))
    assert distance.later(feet, size, 0.6).contact == person.contact.later(0.6).with_size(size)
    assert distance.later(Contact(4.4, STRIDE_SIGMA), size, 0.6).contact.distance == 4.4
    assert replace(FloorDistance.of(None), sized=distance.sized).later(feet, size, 0.6).contact == feet


def test_feet_that_the_size_of_the_body_contradicts_refuse_no_others_for_long():
    """Legs parted in a step passed for feet at 5.5 m; the boxes and the feet of the next pictures, five a
    second, say 3.9 m.
    """
    person = KnownPerson.tentative(
        standing(3.9)[None], 45, 1.0, 0, comparable=True, contact=Contact(5.5, STRIDE_SIGMA)
    )
    size, feet = Contact(3.9, 0.4), Contact(3.9, STRIDE_SIGMA)
    for _ in range(3):
        person = replace(person, distance=person.distance.later(feet, size, 0.2))
    assert person.contact == feet


def test_sizes_of_many_boxes_tell_a_distance_no_better_than_proportions_do():
    contact, size = Contact(4.0, STRIDE_SIGMA), Contact(4.4, 0.4)
    assert contact.with_size(size).sigma == STRIDE_SIGMA
    for _ in range(50):
        contact = contact.later(0.2).with_size(size)
    assert contact.distance == pytest.approx(4.4, abs=0.01)
    assert contact.sigma == pytest.approx(PROPORTION_SIGMA * 4.4, rel=0.01)


def test_sizes_of_boxes_in_a_row_tell_the_distance_together():
    person = KnownPerson.tentative(standing(3.0)[None], 45, 1.0, 0, comparable=True, contact=None)
    assert person.distance.sized_after(None, 0.2) is None
    told = []
    for number in range(20):
        size = Contact(3.3 if number % 2 else 2.7, 0.3)
        person = replace(person, distance=person.distance.later(None, size, 0.2))
        told.append(person.distance.sized.distance)
    assert np.abs(np.array(told[10:]) - 3.0).max() < 0.2
    assert person.distance.sized_after(None, 1.0) == person.distance.sized.later(1.0)


def test_two_hearings_tell_where_a_walker_is_by_now():
    first, second = SlowPose(0, standing(1.0)), SlowPose(SECOND // 2, standing(1.4))
    assert second.forecast(first, 0.5)[0] == pytest.approx(1.8)
    assert second.forecast(None, 0.5)[0] == 1.4
    assert SlowPose(10 * SECOND, standing(1.4)).forecast(first, 0.5)[0] == 1.4


def test_who_comes_back_has_the_body_that_was_learnt():
    track = replace(Track.initiated(standing(2.0)[None]), stature=(1.85, 0.03), typical=0.6)
    back = track.resumed(standing(3.0, height=1.7)[None])
    assert (back.stature, back.typical) == ((1.85, 0.03), 0.6)
    assert back.pose[0] == 3.0


@pytest.mark.parametrize("camera", [perspective(), panorama()])
def test_the_box_of_a_body_tells_its_distance_and_height(camera):
    box = view(camera, read_shape(), standing(3.0, 0.4)[None]).box
    distance, height = told(camera, box)
    assert distance[0] == pytest.approx(np.hypot(3.0, 0.4), rel=0.02)
    assert height[0] == pytest.approx(1.7, rel=0.01)


def test_a_long_lens_sees_people_farther_away():
    short = perspective()
    long = replace(short, matrix=short.matrix * np.array([[3.0, 1, 1], [1, 3, 1], [1, 1, 1]]))
    shape, none = read_shape(), np.zeros(0)
    for camera, away in ((short, 20.0), (long, 60.0)):
        box = view(camera, shape, standing(away)[None]).box[0]
        rng = np.random.default_rng(1)
        places = spawned(camera, Detection(box, none, none), 200, rng)
        assert np.median(places[:, 0]) == pytest.approx(away, rel=0.1)
        assert places[:, 0].max() <= farthest(camera) * 1.01


def looks(points, evidence=3.0):
    return ColorModel(from_plane(points), np.full((len(points), 3), 0.01), np.full(len(points), evidence))


def test_a_few_misplaced_features_do_not_make_another_person():
    relations = read_relations()
    clothes = relations.mean.copy()
    clothes[21:, 0] += 0.3
    strayed = clothes.copy()
    strayed[[22, 30, 38]] = [-0.3, -0.2, 0.9]
    heights = (1.75, 1.76)
    assert same_person(looks(clothes), looks(strayed), heights, relations) > 0
    others = relations.mean.copy()
    others[21:, 0] -= 0.3
    others[5:13, 2] += 0.4
    assert same_person(looks(clothes), looks(others), heights, relations) < -1


def test_cameras_that_know_the_place_know_the_height():
    """Each camera takes the person for taller and farther, along its line of sight to the head."""
    place, height = np.array([2.0, 0.0]), 1.8
    cameras = {"a": replace(perspective(), name="a"), "b": replace(perspective(5.0), name="b")}
    told = []
    for name, far in (("a", 1.15), ("b", 1.15)):
        eye = cameras[name].center
        xy = eye[:2] + far * (place - eye[:2])
        told.append(poses(name, xy, eye[2] + far * (height - eye[2])))
    seen = pose_table(told, cameras, 0.012, 0.07)
    pose, _, _ = fused_pose(seen, [0, 1], None)
    true = cameras["a"].center[2] + (height - 1.2) * np.mean([1.15, 1.15])
    assert pose[2] < true - 0.05
    assert pose[2] == pytest.approx(height, abs=0.05)


def poses(name, xy, height):
    nobody = poses_of(replace(perspective(), name=name), {})
    one = np.ones(1)
    return replace(
        nobody,
        person=np.ones(1, np.int32),
        state=np.full(1, TRACKED, np.uint8),
        xy=xy[None],
        height=height * one,
        heading=0 * one,
        pan=0 * one,
        tilt=0 * one,
        sigma=np.full((1, 6), 0.1),
        confidence=0.5 * one,
    )


def ready(stage, camera, **params):
    made = stage(Context.serving(camera), **params)
    made.setup()
    return made


def test_a_look_passes_the_picture_on_as_it_is():
    frame = Frame(camera="c", pixels=np.zeros((4, 4, 3), np.uint8))
    assert ready(FrameSampler, perspective()).process(frame) is frame


def watched(tracker, number, pose):
    """Poses in a picture without an edge, every 0.1 s; pose: what the slow instance tells, (6,)."""
    header = Header("c", number, number * SECOND // 10)
    plain, none = np.zeros((480, 640), np.uint8), np.zeros((0, 16))
    told = Appearances(
        camera="c",
        person=np.ones(1, np.int32),
        mean=np.full((1, 45, 3), 0.5),
        variance=np.full((1, 45, 3), 0.01),
        evidence=np.ones((1, 45)),
        pose=pose[None],
        stature=np.array([[1.7, 0.03]]),
        contact=np.zeros((1, 2)),
        seen=np.zeros(1, np.int64),
        left=np.zeros(1, np.uint8),
    )
    return tracker.process(
        stamped(Frame(camera="c", pixels=np.zeros((480, 640, 3), np.uint8)), header),
        stamped(Gradients(camera="c", magnitude=plain, orientation=plain), header),
        stamped(told, header),
        stamped(Boxes(camera="c", box=np.zeros((0, 4)), score=np.zeros(0), torso=none, head=none), header),
    )


def test_who_does_not_appear_is_predicted_and_then_gone():
    """The person whom the slow instance told of is followed for `gone` seconds."""
    tracker = ready(PoseTracker, perspective(), particles=40)
    states = [watched(tracker, number, standing(2.5)).state.tolist() for number in range(12)]
    assert states[0] == [PREDICTED]
    assert states[-1] == []


def test_nobody_is_followed_from_before_a_gap():
    tracker = ready(PoseTracker, perspective(), particles=40)
    assert watched(tracker, 0, standing(2.5)).state.tolist() == [PREDICTED]
    assert watched(tracker, 36_000, standing(2.5)).state.tolist() == []


def test_a_person_at_an_unknown_place_is_followed_when_the_place_is_known():
    tracker = ready(PoseTracker, perspective(), particles=40)
    assert watched(tracker, 0, standing(np.nan)).state.tolist() == []
    found = watched(tracker, 1, standing(2.5))
    assert found.state.tolist() == [PREDICTED]
    assert np.isfinite(found.xy).all()
