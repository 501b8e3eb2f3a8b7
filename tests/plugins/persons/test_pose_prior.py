"""What is known of poses before a picture is seen: courses, necks and heights."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.plugins.persons.drawn import standing
from tests.plugins.persons.particles import crowd

from followspot_persons.body.stature import SPREAD
from followspot_persons.body.stature import USUAL as USUAL_HEIGHT
from followspot_persons.likelihood.fitness import PosePrior, log_prior
from followspot_persons.particles.track import Track

SIDE = np.pi / 2


def test_walking_people_mostly_face_ahead():
    prior = PosePrior(course=1.0, concentration=8.0)
    ahead, aside, behind = log_prior(
        np.stack([standing(3.0, heading=h) for h in (1.0, 1.0 + SIDE, 1.0 - np.pi)]), prior
    )
    assert ahead > aside + 1
    assert ahead > behind + 1
    still = log_prior(
        np.stack([standing(3.0, heading=h) for h in (1.0, -2.0)]), replace(prior, concentration=0)
    )
    assert still[0] == still[1]


def test_courses_count_from_a_slow_walk_on():
    track = Track.initiated(crowd(standing(3.0), 5))
    still, slow, fast = (replace(track, velocity=np.array([0.0, -v])).prior for v in (0.1, 0.4, 1.0))
    assert still.concentration == 0 < slow.concentration < fast.concentration
    assert fast.course == pytest.approx(-SIDE)


def test_the_prior_knows_the_person_and_the_neck():
    prior = PosePrior(1.8, 0.02)
    usual, short, turned, nodding = (
        log_prior(pose[None], prior)[0]
        for pose in (
            standing(3, height=1.8),
            standing(3, height=1.76),
            np.array([3, 0, 1.8, np.pi, 0.6, 0]),
            np.array([3, 0, 1.8, np.pi, 0, 0.2]),
        )
    )
    assert usual - short == pytest.approx(2.0)
    assert usual - turned == pytest.approx(0.5)
    assert usual - nodding == pytest.approx(0.5)


def test_the_prior_is_what_is_known_of_the_height():
    new = Track.initiated(crowd(standing(3.0), 5))
    assert (new.prior.height, new.prior.height_sigma) == (USUAL_HEIGHT, SPREAD)
    known = replace(new, stature=(1.9, 0.02)).prior
    assert (known.height, known.height_sigma) == (1.9, 0.02)
