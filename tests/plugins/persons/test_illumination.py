"""Lamps that are dimmed: colours stay those of the people, in the slow and in the fast instance."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.plugins.persons.drawn import SECOND, drawn, frame_of, gradients_of, standing
from tests.plugins.persons.shown import PERIOD, FastInstance, SlowInstance

from followspot.tracking import TRACKED
from followspot_persons.background.existence import Stirring
from followspot_persons.background.illumination import COARSE, Illumination, in_usual_light

ROOM = np.random.default_rng(5).integers(30, 220, (240, 320, 3), np.uint8)


def dimmed(pixels, share, noise=2.0):
    """The same picture in less light, with the noise of the sensor."""
    light = share * pixels + np.random.default_rng(6).normal(0, noise, pixels.shape)
    return np.clip(np.rint(light), 0, 255).astype(np.uint8)


def lights(*pictures):
    """The light of each of these pictures, one a second."""
    known, told = Illumination(), []
    for second, pixels in enumerate(pictures):
        known = known.after(pixels, second * SECOND)
        told.append(known.light)
    return told


def test_lamps_that_are_dimmed_and_lit_again_are_told():
    told = lights(ROOM, dimmed(ROOM, 0.3), dimmed(ROOM, 0.3), ROOM, dimmed(ROOM, 0.6), dimmed(ROOM, 0.3))
    np.testing.assert_allclose(told, [1, 0.3, 0.3, 1, 0.6, 0.3], rtol=0.06)


def test_people_before_two_fifths_of_the_picture_do_not_change_the_light():
    crowd = ROOM.copy()
    crowd[:, :128] = 20
    assert lights(ROOM, crowd) == [1.0, 1.0]


def test_a_camera_that_turns_and_a_black_picture_do_not_change_the_light():
    turned = np.roll(dimmed(ROOM, 0.5), 8 * COARSE + 3, axis=1)
    assert lights(ROOM, turned, np.zeros_like(ROOM), ROOM[:100]) == [1.0] * 4


def test_the_light_of_an_earlier_picture_is_remembered():
    known = Illumination().after(ROOM, 0).after(dimmed(ROOM, 0.3), 2 * SECOND)
    assert [known.at(t) for t in (-5, 0, SECOND)] == [1.0] * 3
    assert known.at(3 * SECOND) == known.light < 0.4


def test_pixels_in_the_usual_light_are_those_of_the_first_picture():
    back = in_usual_light(dimmed(ROOM, 0.5, noise=0.0), 0.5).astype(int)
    assert np.abs(back - ROOM).max() <= 1


@pytest.mark.parametrize("light", [0.0, -1.0, np.nan])
def test_light_that_none_can_be_changes_nothing(light: float):
    np.testing.assert_array_equal(in_usual_light(ROOM, light), ROOM)


def test_the_slow_instance_learns_the_same_colours_in_the_dark():
    show, pose = SlowInstance(particles=200), standing(2.5)
    pixels = drawn(show.camera, pose)
    swaying = [np.roll(pixels, 2 * (number % 2), axis=1) for number in range(8)]
    usual = [show.see_pixels(picture, boxed=[pose], score=6.0) for picture in swaying][-1]
    (person,) = show.stage.people  # as if it had stirred: what never does is furniture
    show.stage.people = [replace(person, stirring=Stirring(most=1.0))]
    dark = [show.see_pixels(dimmed(pixels, 0.3), boxed=[pose], score=6.0) for _ in range(12)][-1]
    assert usual.light == 1.0
    assert dark.light == pytest.approx(0.3, rel=0.06)
    seen = (usual.evidence[0] > 0) & (dark.evidence[0] > usual.evidence[0])
    assert np.abs(dark.mean[0, seen, 2] - usual.mean[0, seen, 2]).max() < 0.1


@pytest.mark.parametrize("told_in_the_dark", [False, True])
def test_the_fast_instance_knows_people_in_the_dark(told_in_the_dark):
    """Also if it began in the dark, and the slow instance knows the colours from before."""
    room, pose = FastInstance(), standing(2.5)
    room.tell(pose)
    pictures = [drawn(room.camera, pose)] * (0 if told_in_the_dark else 3)
    pictures += [dimmed(drawn(room.camera, pose), 0.3)] * 3
    if told_in_the_dark:
        object.__setattr__(room.told, "light", 0.3)
    for number, pixels in enumerate(pictures):
        frame = frame_of(room.camera, pixels, number * PERIOD, number)
        seen = room.stage.process(frame, gradients_of(room.camera, frame), room.told, None)
    assert seen.state.tolist() == [TRACKED]
    known = room.stage.people[1].track.likelihood
    assert known > 0.6
