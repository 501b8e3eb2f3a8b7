"""People in boxes of rooms with much clutter and with steep floors, and the numbers of long runs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.plugins.persons.crowded import corner_room
from tests.plugins.persons.false_boxes import person, sent

from followspot import Context, FollowspotError
from followspot.messages import stamped
from followspot.people import Boxes
from followspot_persons.associate.colors.torso_colors import BINS
from followspot_persons.associate.detections import Detections
from followspot_persons.associate.stage import Associate
from followspot_persons.associate.tracks.camera_association import Association

ROOM = corner_room()
PERIOD = 0.25
SECOND = 10**9
SIZE = np.array([1280, 960])


def started() -> Associate:
    stage = Associate(Context("associate", ROOM))
    stage.setup()
    return stage


@pytest.mark.parametrize("seed", [1, 2])
def test_pictures_full_of_false_boxes_make_few_people(seed: int) -> None:
    """60 boxes a picture anywhere, in 24 sets: fewer than two false people in a set at the mean."""
    stage, rng = started(), np.random.default_rng(seed)
    found = [len(stage.process(boxes=sent([], 60, k * PERIOD, rng)).poses.person) for k in range(24)]
    assert np.mean(found) < 2


def test_a_person_among_false_boxes_is_followed() -> None:
    stage, rng = started(), np.random.default_rng(3)
    for k in range(24):
        place = np.array([0.5 - 0.04 * k, 0.3])
        poses = stage.process(boxes=sent([person(place)], 20, k * PERIOD, rng)).poses
        if k > 4:
            assert np.linalg.norm(poses.xy - place, axis=1).min() < 0.2, k


def test_false_detections_weaken_evidence_down_to_that_of_a_missed_one() -> None:
    def gain(boxes: int, ratio: float) -> float:
        unknown = np.full((boxes, BINS), np.nan)
        one = Association.none(Detections(0, 0, np.zeros((boxes, 4)), unknown), 1)
        used = np.arange(boxes) == 0
        one = replace(
            one,
            found=np.ones(1, bool),
            ratio=np.array([ratio]),
            probability=np.ones(1),
            used=used,
            visible=np.ones(1),
        )
        return float(one.gain(0.9, 2.0)[0])

    assert gain(1, 1.5) == gain(2, 1.5) == 1.5
    assert gain(1, 8.0) == gain(61, 8.0) == 2.0
    assert gain(11, 3.0) == pytest.approx(3.0 - np.log(10))
    assert gain(61, 0.5) == pytest.approx(np.log(0.1))


@pytest.mark.parametrize(("slope", "fits"), [(10.0, True), (45.0, True), (90.0, False), (180.0, True)])
def test_boxes_need_a_floor_to_stand_on(slope: float, fits: bool) -> None:
    normal = [np.sin(np.radians(slope)), 0.0, np.cos(np.radians(slope)), 0.0]
    room = replace(ROOM, planes={"floor": np.array(normal)})
    stage = Associate(Context("associate", room, receives=(Boxes,)))
    if fits:
        stage.setup()
    else:
        with pytest.raises(FollowspotError, match="steeper than 60 degrees"):
            stage.setup()


@pytest.mark.filterwarnings("error")
def test_estimates_stay_covariances_and_probabilities_over_many_sets() -> None:
    """Also between sets at one time, late sets, pictures without boxes, and boxes that are none."""
    stage, rng = started(), np.random.default_rng(7)
    for k in range(400):
        turn = 0.05 * k
        people = [person([np.cos(turn), 0.6]), person([-0.4, -np.sin(turn)])][: 1 + (k % 80 > 20)]
        boxes = sent(people if k % 60 < 50 else [], 2, PERIOD * max(k - k % 7, 1), rng)
        odd = np.array([[np.nan, 0, 9, 9], [-9e4, -9e4, 9e4, 9e4], [5, 5, 5, 9], [np.inf, 0, 1, 1]])
        none, ones = np.zeros((len(odd), 0)), np.ones(len(odd))
        extra = stamped(Boxes(boxes[0].camera, odd, ones, none, none), boxes[0].header)
        stage.process(boxes=(extra if k % 11 == 0 else boxes[0], *boxes[1:]))
        bodies = stage.by_boxes.bodies
        assert np.isfinite(bodies.state).all()
        assert np.isfinite(bodies.covariance).all()
        assert np.allclose(bodies.covariance, np.swapaxes(bodies.covariance, -1, -2), atol=1e-12)
        assert (np.linalg.eigvalsh(bodies.covariance) > -1e-12).all()
        assert (bodies.shape > 0).all()
        assert np.allclose(bodies.shape.sum(axis=1), 1)
    assert stage.by_boxes.numbers >= 2
