"""The track of a person after each picture: height, girth, feet, and what is kept while hidden."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.plugins.persons.drawn import drawn, perspective, picture_of, standing
from tests.plugins.persons.particles import crowd, rng

from followspot.geometry import wrap
from followspot_persons.background.floor_contact import Contact
from followspot_persons.body.shape import read_shape
from followspot_persons.body.stature import PROPORTION_SIGMA
from followspot_persons.body.view import HEADING, HEIGHT
from followspot_persons.likelihood.fitness import Fitness, Weights
from followspot_persons.likelihood.occlusion import covered
from followspot_persons.particles.condensation import Search
from followspot_persons.particles.girth import USUAL, Girth, girths_of, observed
from followspot_persons.particles.track import MAXIMUM_SPEED, MINIMUM_SHOWN, Track, coasted, updated


@pytest.mark.parametrize("known", [1.65, 1.85])
def test_a_known_height_moves_the_pose_along_the_line_of_sight(scene, known):
    """The body drawn is 1.75 m high at 2.5 m: whoever is taller stands farther away."""
    track = Track.initiated(crowd(standing(2.5, 0.2, 1.75), 150))
    after = step(replace(track, stature=(known, 0.015)), scene)
    assert after.pose[HEIGHT] == known
    distance = 2.5 * (known - 1.2) / 0.55
    assert np.sign(after.pose[0] - 2.5) == np.sign(distance - 2.5)
    assert after.pose[0] == pytest.approx(distance, abs=0.25)


def test_the_sigma_of_a_pose_holds_what_the_height_leaves_open(scene):
    """sigma_r = r min(p, sigma_h / (h - z)) along the line of sight, with p of proportions: the size has told
    the height, and counts once.
    """
    track = Track.initiated(crowd(standing(2.5, 0.2, 1.75), 150))
    vague, sure = (step(replace(track, stature=(1.75, s)), scene).sigma for s in (0.06, 0.015))
    assert 0.3 > vague[0] > 2.5 * PROPORTION_SIGMA > sure[0]
    assert sure[0] > 2.5 * 0.015 / 0.55
    assert vague[1] < 0.3 * vague[0]
    assert vague[HEIGHT] > 0.06 > sure[HEIGHT]


@pytest.fixture(scope="module")
def scene():
    """The fitness of poses in a picture of a body at (2.5, 0.2), 1.75 m high, that faces the camera."""
    picture = picture_of(perspective(), drawn(perspective(), standing(2.5, 0.2, 1.75)))
    return Fitness(picture, read_shape(), Weights())


def step(track, scene, seconds=1 / 15):
    search = Search(150)
    return updated(track, seconds, scene, girths_of(read_shape()), search, rng())


def test_particles_find_the_body_that_is_drawn(scene):
    start = crowd(standing(2.7, 0.1, 1.7), 150) + rng().normal(0, [0.1, 0.1, 0.05, 0.3, 0.2, 0.1], (150, 6))
    track = Track.initiated(start)
    for _ in range(6):
        track = step(track, scene)
    assert track.pose[1] == pytest.approx(0.2, abs=0.04)
    assert track.pose[0] == pytest.approx(2.5, abs=0.25)
    assert track.pose[HEIGHT] == pytest.approx(1.75, abs=0.08)
    assert track.likelihood > 0.6


def test_a_girth_is_learnt_from_the_outline():
    girth = {}
    for true in (0.85, 1.08):
        pixels = drawn(perspective(), standing(2.5, 0.2, 1.75), girth=true)
        fitness = Fitness(picture_of(perspective(), pixels), read_shape(), Weights())
        known = Girth.unknown()
        for _ in range(20):
            known = observed(known, fitness, girths_of(read_shape()), standing(2.5, 0.2, 1.75))
        girth[true] = known.mean
    assert girth[0.85] < USUAL - 0.04
    assert girth[1.08] > USUAL + 0.04


def test_a_track_learns_the_girth_and_forgets_an_old_one():
    camera, shape, there = perspective(), read_shape(), standing(2.5, 0.2, 1.75)
    slim, stout = (
        Fitness(picture_of(camera, drawn(camera, there, girth=g)), shape, Weights()) for g in (0.85, 1.08)
    )
    track = replace(Track.initiated(crowd(there, 60)), stature=(1.75, 0.02))
    for _ in range(5):
        track = step(track, stout)
    assert track.girth.mean > USUAL
    known, bodies = Girth.unknown(), girths_of(shape)
    for fitness in [slim] * 120 + [stout] * 40:
        known = observed(known, fitness, bodies, there)
    assert known.mean > USUAL


def test_a_hidden_person_coasts_and_keeps_what_is_known(scene):
    known = step(Track.initiated(crowd(standing(2.5, 0.2, 1.75), 150)), scene)
    known = replace(known, velocity=np.array([0.0, 1.0]))
    hidden = replace(scene, picture=covered(scene.picture, read_shape(), standing(1.0, 0.08)))
    after = step(known, hidden, 0.1)
    assert after.shown < 0.4
    assert after.pose[1] == pytest.approx(known.pose[1] + 0.1)
    assert (after.stature, after.girth, after.typical) == (known.stature, known.girth, known.typical)


def test_typical_likelihoods_rise_faster_than_they_fall(scene):
    track = Track.initiated(crowd(standing(2.5, 0.2, 1.75), 150))
    low, high = (step(replace(track, typical=t, likelihood=t), scene) for t in (0.2, 0.99))
    rise = (low.typical - 0.2) / (low.likelihood - 0.2)
    fall = (high.typical - 0.99) / (high.likelihood - 0.99)
    assert 0 < fall < rise < 0.2


def test_a_forecast_slows_down_and_nobody_is_faster_than_people(scene):
    running = replace(Track.initiated(crowd(standing(2.5), 5)), velocity=np.array([1.0, 0.0]))
    later = coasted(running, 1.0)
    assert later.pose[0] == pytest.approx(3.5)
    assert later.velocity[0] < 0.5
    far = replace(Track.initiated(crowd(standing(2.5, -1.5), 150)), likelihood=0.6)
    near = replace(far, particles=crowd(standing(2.5, 0.2, 1.75), 150))
    assert np.hypot(*step(near, scene).velocity) <= MAXIMUM_SPEED + 1e-9


def test_a_turn_beyond_a_right_angle_is_taken_over_at_once(scene):
    known = replace(step(Track.initiated(crowd(standing(2.5, 0.2, 1.75), 150)), scene), likelihood=0.6)
    turned = known.pose.copy()
    turned[HEADING] += 2.5
    after = step(replace(known, pose=turned, particles=crowd(known.pose, 150)), scene)
    assert abs(wrap(after.pose[HEADING] - known.pose[HEADING])) < 0.4


def test_feet_weigh_distances_from_the_camera():
    camera = perspective()
    there = standing(3.0)
    fitness = Fitness(picture_of(camera, drawn(camera, there)), read_shape(), Weights())
    told = replace(fitness, contact=Contact(3.0, 0.2))
    poses = np.array([there, standing(3.4), standing(0.0, 3.0)])
    np.testing.assert_allclose(told(poses) - fitness(poses), [0.0, -2.0, 0.0], atol=1e-6)


@pytest.mark.parametrize(
    ("aside", "feet", "vague", "moves"),
    [
        (0.24, None, False, False),
        (0.24, Contact(2.9, 0.5), True, False),
        (0.24, Contact(3.6, 0.5), False, True),
        (2.0, None, False, True),
        (2.0, Contact(2.9, 0.5), True, True),
    ],
)
def test_who_is_partly_hidden_keeps_the_distance_if_a_contact_is_vague(aside, feet, vague, moves):
    """The picture shows a body a quarter farther away, at the height of the camera."""
    camera, shape = perspective(), read_shape()
    shown, there = standing(3.6, height=1.22), standing(2.9, height=1.22)
    picture = covered(picture_of(camera, drawn(camera, shown)), shape, standing(1.5, aside))
    fitness = Fitness(picture, shape, Weights(), contact=feet, contact_vague=vague)
    bodies = girths_of(shape)
    track = Track(crowd(there, 80), there, np.zeros(6), np.zeros(2), stature=(1.22, 0.02))
    rng = np.random.default_rng(2)
    for _ in range(5):
        track = updated(track, 0.1, fitness, bodies, Search(80), rng)
    assert track.shown >= MINIMUM_SHOWN
    assert (track.pose[0] > 3.2) == moves


@pytest.mark.parametrize("feet", [None, Contact(2.6, 0.5)])
def test_a_body_that_shrinks_in_one_picture_walks_away_no_faster_than_people_do(feet):
    """At once it looks as if it were 1.4 m farther; the last six pictures show it. Feet are not seen now."""
    camera, shape = perspective(), read_shape()
    there, away = standing(2.6, height=1.22), standing(4.0, height=1.22)
    first, then = (
        Fitness(
            picture_of(camera, drawn(camera, pose)), shape, Weights(), contact=feet, contact_vague=bool(feet)
        )
        for pose in (there, away)
    )
    track = Track(crowd(there, 150), there, np.zeros(6), np.zeros(2), stature=(1.22, 0.02))
    rng, bodies = np.random.default_rng(3), girths_of(shape)
    for fitness in [first] * 4 + [then] * 6:
        before, track = track, updated(track, 1 / 15, fitness, bodies, Search(150), rng)
    assert before.pose[0] < track.pose[0] < 3.1


def test_a_pose_with_feet_is_where_they_are_and_is_surely_there():
    """At the height of the camera, heads of all distances are in one row."""
    camera = perspective()
    there = standing(3.0, height=1.22)
    fitness = Fitness(picture_of(camera, drawn(camera, there)), read_shape(), Weights())
    poses = {}
    for contact in (None, Contact(3.6, 0.05)):
        track = Track(crowd(there, 60), there, np.zeros(6), np.zeros(2), stature=(1.22, 0.02))
        rng = np.random.default_rng(1)
        bodies = girths_of(fitness.shape)
        for _ in range(6):
            told = replace(fitness, contact=contact)
            track = updated(track, 0.1, told, bodies, Search(60), rng)
        poses[contact] = track
    free, held = poses.values()
    assert free.pose[0] < 3.3
    assert held.pose[0] == pytest.approx(3.6, abs=0.1)
    assert free.sigma[0] > 0.2 > 0.08 > held.sigma[0]
