"""The identity as a dimension of the state, and specific colour models against the generic one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.plugins.persons.drawn import (
    BLACK,
    BLUE,
    RED,
    clothes,
    frame_of,
    gradients_of,
    in_red_and_blue,
    standing,
)
from tests.plugins.persons.shown import PERIOD, FastInstance, SlowInstance, numbers

from followspot.messages import stamped
from followspot_persons.body.shape import read_shape
from followspot_persons.color.hsi import hsi
from followspot_persons.particles.identity_change import changed

LEFT, RIGHT = standing(2.5, 0.6), standing(2.5, -0.6)


def followed(share):
    """Places across of a red and a blue person whom the slow instance reported the wrong way round."""
    room = FastInstance(identity_change_share=share)
    room.tell(LEFT, RIGHT)
    mean = np.array([hsi(clothes(read_shape(), c, c).astype(np.uint8)).astype(float) for c in (RED, BLUE)])
    told = stamped(replace(room.told, mean=mean), room.told.header)
    pixels = in_red_and_blue(room.camera, red=RIGHT, blue=LEFT)
    for number in range(4):
        frame = frame_of(room.camera, pixels, number * PERIOD, number)
        poses = room.stage.process(frame, gradients_of(room.camera, frame), told, None)
    assert poses.person.tolist() == [1, 2]
    return poses.xy[:, 1]


@pytest.mark.parametrize(("share", "across"), [(0.0, [0.6, -0.6]), (0.1, [-0.6, 0.6])])
def test_people_who_were_swapped_change_back_if_identities_may_change(share, across):
    np.testing.assert_allclose(followed(share), across, atol=0.06)


def test_a_change_of_identity_takes_a_share_of_the_others_places():
    rng = np.random.default_rng(0)
    own, other, third = np.zeros((100, 6)), np.ones((40, 6)), np.full((40, 6), 2.0)
    mixed = changed([own, other, third], 0.25, rng)
    assert [len(m) for m in mixed] == [100, 40, 40]
    assert [(m == i).all(axis=1).sum() for i, m in enumerate(mixed)] == [75, 30, 30]
    assert set(np.unique(mixed[0])) == {0.0, 1.0, 2.0}


def test_nobody_changes_without_others_or_without_a_share():
    rng = np.random.default_rng(0)
    own, other = np.zeros((100, 6)), np.ones((40, 6))
    assert changed([own], 0.25, rng)[0] is own
    assert changed([own, other], 0.0, rng)[0] is own
    assert changed([], 0.25, rng) == []


@pytest.mark.parametrize(("specific", "number"), [(False, 1), (True, 2)])
def test_generic_colours_that_beat_the_specific_ones_make_a_new_person(specific, number):
    """Somebody in other clothes takes the place of a known person between two pictures."""
    show = SlowInstance(specific_beats_generic=specific)
    for _ in range(4):
        assert 2 not in numbers(show.see(standing(2.6)))
    for _ in range(3):
        told = show.see(standing(2.6), front=BLACK, back=BLACK)
    assert told.person[told.seen.argmax()] == number


def test_the_same_person_stays_the_same_where_specific_colours_must_beat_generic_ones():
    show = SlowInstance(specific_beats_generic=True)
    for _ in range(5):
        told = show.see(standing(2.6))
    assert numbers(told) == [1]
