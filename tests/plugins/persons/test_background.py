"""What the room without people tells of them: where they stand, and whether they exist."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.plugins.persons.before_wall import background_and_body
from tests.plugins.persons.drawn import (
    BACK,
    SECOND,
    SHIRT,
    WALL,
    boxes_of,
    drawn,
    frame_of,
    gradients_of,
    perspective,
    standing,
)
from tests.plugins.persons.shown import SlowInstance

from followspot.geometry import project
from followspot.messages import stamped
from followspot_persons.background.background import FEWEST, INTERVAL, LONGEST, MOST, Background, foreground
from followspot_persons.background.existence import EVIDENCE, RIGID, Stirring, evidence_of
from followspot_persons.background.floor_contact import (
    STRIDE_SIGMA,
    WALK,
    Contact,
    Presence,
    lowest,
    presence,
)
from followspot_persons.body.shape import read_shape
from followspot_persons.body.view import view
from followspot_persons.likelihood.fitness import Detection
from followspot_persons.slow_instance.floor_distance import FloorDistance
from followspot_persons.slow_instance.known_person import KnownPerson
from followspot_persons.slow_instance.part_box import stood

NOBODY, NONE = np.empty((0, 4)), np.empty(0)
PIXELS = ("pixels", "background")
PLAIN = np.full((24, 32, 3), (90, 120, 150), np.uint8)


def watched(pictures, seconds=INTERVAL, people=NOBODY):
    """The background of these pictures, one every so many seconds."""
    background = Background()
    for number, pixels in enumerate(pictures):
        background = background.after(pixels, round(number * seconds * SECOND), people)
    return background


def walking_by(pictures):
    """Something white that passes through the picture."""
    for number in range(pictures):
        pixels = PLAIN.copy()
        pixels[:, (3 * number) % 32 : (3 * number) % 32 + 4] = 255
        yield pixels


def test_the_background_is_what_most_pictures_show():
    np.testing.assert_array_equal(watched(walking_by(12)).median, PLAIN)
    assert watched(walking_by(FEWEST - 1)).median is None


def test_pictures_are_kept_at_growing_intervals_until_they_span_a_minute():
    known = watched(PLAIN for _ in range(400))
    assert known.interval == LONGEST
    assert len(known.kept) <= MOST
    assert LONGEST * len(known.kept) > 30


@pytest.mark.parametrize("turn", [0, 32])
def test_at_the_other_side_of_a_picture_is_a_person_on_the_seam_of_a_panorama_only(turn):
    shown = PLAIN.copy()
    shown[:, 30:] = 0
    known = replace(watched(PLAIN for _ in range(FEWEST)), turn=turn)
    kept = known.without(shown, np.array([[-4.0, 0, 4, 8]]))
    assert (kept == shown).all() == (turn == 0)


def test_where_people_are_known_the_background_stays_as_it_is():
    shown = PLAIN.copy()
    shown[:, 10:20] = 0
    there = np.array([[12.0, 2.0, 18.0, 12.0]])
    background = watched(PLAIN for _ in range(FEWEST))
    for number in range(FEWEST, 4 * FEWEST):
        background = background.after(shown, number * SECOND * 5, there)
    np.testing.assert_array_equal(background.median, PLAIN)


@pytest.mark.parametrize(("now", "differs"), [(0.8, False), (1.0, False), (0.4, True), (1.4, True)])
def test_a_shadow_is_no_foreground(now, differs):
    pixels = np.rint(PLAIN * now).astype(np.uint8)
    assert foreground(pixels, PLAIN, 1.0).all() == differs
    assert foreground(pixels, PLAIN, 1.0).any() == differs


def test_another_colour_as_bright_is_foreground():
    assert foreground(PLAIN[..., ::-1], PLAIN, 1.0).all()


@pytest.mark.parametrize("dim", [0.3, 0.6])
def test_light_that_changes_everywhere_makes_no_foreground(dim):
    room = np.random.default_rng(2).integers(40, 220, (24, 32, 3), np.uint8)
    background = watched(room for _ in range(FEWEST))
    pixels = np.rint(room * dim).astype(np.uint8)
    light = background.light(pixels)
    assert light == pytest.approx(dim, rel=0.05)
    assert foreground(pixels, room, light).mean() < 0.1


def test_a_camera_that_moved_has_no_background():
    room = np.random.default_rng(2).integers(0, 255, (48, 64, 3), np.uint8)
    background = watched(room for _ in range(FEWEST))
    assert background.light(np.roll(room, 5, axis=1)) is None
    assert background.light(room[:20]) is None


def of_body(pose, true, others=NOBODY):
    """What the background says of a pose, where a body of a true pose stands."""
    return presence(background_and_body(true), pose, others)


def at_distance(pose, distance):
    """A pose whose head's top is in the same place of the picture, (6,)."""
    share = distance / np.hypot(*pose[:2])
    return np.concatenate([pose[:2] * share, [1.2 + share * (pose[2] - 1.2)], pose[3:]])


@pytest.mark.parametrize("height", [1.55, 1.7, 1.9])
def test_feet_on_the_floor_give_the_height(height):
    """The pose has the head's top in place, at a wrong distance and height."""
    true = standing(4.0, 0.3, height)
    told = of_body(at_distance(true, 1.1 * np.hypot(*true[:2])), true)
    assert told.foreground > 0.6
    assert told.height == pytest.approx(height, abs=0.015)
    assert told.contact.distance == pytest.approx(np.hypot(*true[:2]), abs=0.05)


def test_a_head_alone_far_away_is_a_whole_body_where_its_feet_are():
    told = of_body(at_distance(standing(3.0), 6.5), standing(3.0))
    assert told.height == pytest.approx(1.7, abs=0.015)
    assert told.contact.distance == pytest.approx(3.0, abs=0.05)


def test_whom_a_nearer_person_hides_has_no_feet():
    """Their columns end beside those of the other; with half of them left, feet are seen."""
    true = standing(4.0)
    width = 70.0
    for shift, seen in ((0.0, False), (120.0, True)):
        other = np.array([[159.5 + shift - width / 2, 60.0, 159.5 + shift + width / 2, 60.0 + 1.5 * width]])
        told = of_body(true, true, other)
        assert (told.contact is not None) == seen
        assert told.foreground > 0.6


@pytest.mark.parametrize("ghost", [False, True])
def test_legs_that_the_background_has_and_the_picture_not_are_nobodys_feet(ghost):
    """Below a body are other legs: in the picture its own, in the background those of somebody else."""
    scene, near = background_and_body(standing(4.5)), background_and_body(standing(3.6))
    legs = near.changed(np.arange(240)[:, None], np.arange(320)[None])
    legs &= ~scene.changed(np.arange(240)[:, None], np.arange(320)[None])
    legs[:150] = False
    changed = replace(
        scene, **{name: pixels.copy() for name, pixels in vars(scene).items() if name in PIXELS}
    )
    (changed.background if ghost else changed.pixels)[legs] = BACK
    told = presence(changed, standing(3.9), NOBODY)
    assert told.foreground > 0.6
    assert told.contact is None if ghost else told.contact.distance == pytest.approx(3.6, abs=0.1)


@pytest.mark.parametrize("aside", [-0.3, 0.2])
def test_the_feet_of_a_ghost_beside_the_legs_of_a_person_are_nobodys(aside):
    """Somebody stood nearer at first, a little aside, and the background still shows it."""
    scene, near = background_and_body(standing(4.5)), background_and_body(standing(3.6, aside))
    background = scene.background.copy()
    background[near.changed(np.arange(240)[:, None], np.arange(320)[None])] = BACK
    told = presence(replace(scene, background=background), standing(3.9), NOBODY)
    assert told.foreground > 0.6
    assert told.contact is None


@pytest.mark.parametrize("to_the_floor", [True, False])
def test_legs_that_part_in_a_step_are_no_feet_where_they_leave_the_middle(to_the_floor):
    """Both shanks go on aside, so that the lowest row below the trunk is of the knees, 0.3 m farther away."""
    true = standing(3.0)
    scene = background_and_body(true)
    knee, foot = project(scene.camera, np.array([[2.82, 0, 0.15], [2.82, 0, 0.0]]))[:, 1].astype(int)
    pixels = scene.pixels.copy()
    pixels[knee:] = WALL
    if to_the_floor:
        for row in range(knee - 10, foot):
            for side in (-1, 1):
                pixels[row, 159 + side * (row - knee + 15) + np.arange(-5, 6)] = SHIRT
    told = presence(replace(scene, pixels=pixels), true, NOBODY)
    assert told.foreground > 0.6
    assert (told.contact is None) == to_the_floor


def test_a_box_of_a_head_becomes_that_of_the_upper_body_and_another_one_stays():
    true = standing(3.0)
    scene = background_and_body(true)
    whole = view(scene.camera, read_shape(), true[None]).box[0]
    head = whole.copy()
    head[3] = whole[1] + 0.35 * (whole[3] - whole[1])
    of_head = stood(
        scene.camera, scene.pixels, scene, Detection(head, NONE, NONE), standing(6.5), 1.7, NOBODY
    )
    assert of_head.part
    np.testing.assert_allclose(
        of_head.detection.box[[1, 3]], whole[[1, 3]], atol=0.06 * (whole[3] - whole[1])
    )
    of_body = stood(scene.camera, scene.pixels, scene, Detection(whole, NONE, NONE), true, 1.7, NOBODY)
    assert not of_body.part
    assert of_body.contact.distance == pytest.approx(3.0, abs=0.05)
    np.testing.assert_array_equal(of_body.detection.box, whole)


def test_boxes_of_head_and_chest_initiate_a_whole_body_and_say_nothing_of_its_height():
    """By their size they would be of upper bodies 5 m away."""
    show, true = SlowInstance(), standing(3.0)
    show.leave(FEWEST)
    for number in range(3):
        frame = frame_of(show.camera, background_and_body(true).pixels, show.number / 2, show.number)
        whole = boxes_of(show.camera, frame, true)
        box = whole.box.copy()
        box[:, 3] = box[:, 1] + 0.6 * (box[:, 3] - box[:, 1])
        heads = stamped(replace(whole, box=box), frame.header)
        show.stage.process(frame, gradients_of(show.camera, frame), heads)
        show.number += 1
        (person,) = show.stage.people
        if number == 0:
            assert person.track.particles[:, 0].mean() == pytest.approx(3.0, abs=0.3)
    assert not len(person.stature.sizes)


def test_without_a_background_a_detection_says_what_it_says():
    detection = Detection(np.array([10.0, 10, 30, 40]), NONE, NONE)
    camera = perspective()
    told = stood(camera, drawn(camera), None, detection, standing(3.0), 1.7, NOBODY)
    assert (told.detection, told.part, told.contact) == (detection, False, None)


def test_feet_below_the_picture_or_far_from_the_pose_tell_nothing():
    assert of_body(standing(1.5), standing(1.5)).height is None
    assert of_body(standing(3.5), standing(5.5)).height is None


def test_an_empty_place_has_no_foreground():
    told = of_body(standing(3.0, -0.8), standing(3.0, 0.9))
    assert told.foreground < 0.1
    assert told.height is None


def test_the_lowest_row_is_before_the_first_long_gap():
    filled = np.array([1, 1, 0, 1, 1, 0, 0, 0, 1], bool)
    assert lowest(filled, 2) == 4
    assert lowest(filled, 4) == 8


def test_furniture_is_evidence_against_a_person_unless_it_may_be_the_background():
    assert evidence_of(0.9, comparable=True) == EVIDENCE
    assert evidence_of(0.0, comparable=True) == -EVIDENCE
    assert evidence_of(0.0, comparable=False) == 0.0
    assert evidence_of(None, comparable=True) == 0.0


def test_boxes_on_furniture_confirm_nobody_and_a_person_there_is_confirmed():
    """The detector sees a person on the plain wall, more and more often than it would a real one."""
    numbers = {}
    for real in (False, True):
        show = SlowInstance()
        for _ in range(FEWEST + 1):
            show.see()
        for _ in range(8):
            told = show.see(*([standing(2.5)] if real else []), boxed=[standing(2.5)], score=1.0)
            assert len(show.stage.people) == int(real)
        numbers[real] = told.person.tolist()
    assert numbers == {False: [], True: [1]}


@pytest.mark.parametrize("sway", [0.01, 0.0])
def test_who_stood_there_from_the_start_stays_and_what_never_stirs_was_nobody(sway):
    """A person sways by a centimetre to either side; furniture that was pushed there does not."""
    show = SlowInstance(sway=0)
    for number in range(20):
        told = show.see(standing(2.5, sway * np.sin(number) if number else 0.05), score=2.0)
    assert told.person.tolist() == [1]
    assert told.left.tolist() == [int(sway == 0)]


@pytest.mark.parametrize(("sway", "numbers"), [(2, [1]), (0, [])])
def test_furniture_is_confirmed_by_no_boxes_before_there_is_a_background(sway, numbers):
    """The detector is as sure of it as of a person, but nothing about it changes from its first box on."""
    show = SlowInstance(sway=sway)
    told = [show.see(standing(2.5), score=6.0).person.tolist() for _ in range(FEWEST)]
    assert show.stage.background.median is not None
    assert told[1:] == [numbers] * (FEWEST - 1)


def test_nothing_that_stirred_once_is_furniture():
    shown = Presence(0.0, 0.0)
    still = Stirring().after(shown, 1).after(shown, 2 * SECOND)
    assert still.furniture(2 * SECOND)
    assert not Stirring().after(shown, 1).furniture(SECOND // 2)
    assert (
        not still.after(Presence(0.0, 2 * RIGID), 3 * SECOND).after(shown, 9 * SECOND).furniture(9 * SECOND)
    )
    assert not Stirring().after(None, 1).furniture(9 * SECOND)


def test_hidden_feet_leave_the_distance_of_before_ever_more_vague():
    new = KnownPerson.tentative(np.tile(standing(3.0), (4, 1)), 45, 1.0, 0, comparable=True, contact=None)
    assert new.distance.later(None, Contact(2.0), 1.0).contact is None
    stands = FloorDistance.of(Contact(3.0, 0.1))
    assert stands.later(None, None, 1.0).contact == Contact(3.0, float(np.hypot(0.1, WALK)))
    assert stands.later(Contact(2.0), None, 1.0).contact == Contact(2.0)


def test_noise_in_dim_light_makes_no_foreground():
    """A fifth of the light, and noise of two grey levels: boxes on furniture still confirm nobody."""
    noise = np.random.default_rng(4)
    show = SlowInstance()
    wall = np.full((240, 320, 3), WALL, np.uint8)
    for _ in range(FEWEST + 1):
        show.see()
    for _ in range(8):
        dim = np.clip(0.2 * wall + noise.normal(0, 2, wall.shape), 0, 255).astype(np.uint8)
        told = show.see_pixels(dim, boxed=[standing(2.5)], score=1.0)
    assert told.person.tolist() == []
    assert show.stage.illumination.light == pytest.approx(0.2, rel=0.1)


def test_the_slow_instance_tells_where_feet_are_and_that_none_were_seen_before():
    """Two pictures a second; the first ones are plain and make the background."""
    show, true = SlowInstance(), standing(3.0)
    show.leave(FEWEST)
    told = [show.see_pixels(background_and_body(true).pixels, boxed=[true], score=3.0) for _ in range(3)][-1]
    assert told.contact[0, 0] == pytest.approx(3.0, abs=0.05)
    assert told.contact[0, 1] == pytest.approx(STRIDE_SIGMA**-2)
    new = SlowInstance()
    told = [new.see(true) for _ in range(3)][-1]
    assert told.contact.tolist() == [[0.0, 0.0]]


def test_who_was_not_seen_for_some_time_may_have_walked_on_since():
    """Feet 2 m nearer after 1.5 s are the same person's; after half a second they are not."""
    show, before, after = SlowInstance(), standing(4.6), standing(2.6)
    show.leave(FEWEST)
    for _ in range(4):
        show.see_pixels(background_and_body(before).pixels, boxed=[before], score=3.0)
    show.leave(2)
    told = show.see_pixels(background_and_body(after).pixels, boxed=[after], score=3.0)
    assert told.person.tolist() == [1]
    assert told.contact[0, 0] == pytest.approx(2.6, abs=0.1)
