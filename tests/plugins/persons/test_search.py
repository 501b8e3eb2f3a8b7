"""The search of a pose: motion and its limits, ascent, particles, priors, and the smoothed track."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.plugins.persons.drawn import drawn, perspective, picture_of, standing

from followspot.geometry import project, wrap
from followspot_persons.background.floor_contact import Contact
from followspot_persons.body.shape import read_shape
from followspot_persons.body.stature import PROPORTION_SIGMA, SPREAD
from followspot_persons.body.stature import USUAL as USUAL_HEIGHT
from followspot_persons.body.view import HEADING, HEIGHT, PAN, TILT
from followspot_persons.likelihood.fitness import Fitness, PosePrior, Weights, log_prior
from followspot_persons.likelihood.occlusion import covered
from followspot_persons.particles.ascent import ACROSS, DISTANCE, STATURE, STEPS, ascend, moved
from followspot_persons.particles.condensation import MODE, Search, condense, estimated, scattered, systematic
from followspot_persons.particles.girth import USUAL, Girth, girths_of, observed
from followspot_persons.particles.motion import HIGHEST, LOWEST, MAX_PAN, MAX_TILT, limited, predicted
from followspot_persons.particles.track import MAXIMUM_SPEED, MINIMUM_SHOWN, Track, coasted, updated

EYE = np.array([0, 0, 1.2])
SIDE = np.pi / 2


def crowd(pose, count):
    return np.tile(pose, (count, 1))


def test_necks_and_heights_have_limits():
    extreme = np.array([[0, 0, 9, 0, 3, 3], [0, 0, -9, 0, -3, -3.0]])
    assert limited(extreme.copy())[:, [HEIGHT, PAN, TILT]].tolist() == [
        [HIGHEST, MAX_PAN, MAX_TILT],
        [LOWEST, -MAX_PAN, -MAX_TILT],
    ]


def test_motion_keeps_the_limits():
    after = predicted(crowd([2, 0, HIGHEST, 0, MAX_PAN, MAX_TILT], 500), np.zeros(2), 0.5, EYE, rng())
    assert after[:, HEIGHT].max() <= HIGHEST
    assert after[:, PAN].max() <= MAX_PAN
    assert after[:, TILT].max() <= MAX_TILT


def test_particles_move_on_and_spread_more_along_the_line_of_sight_than_across():
    after = predicted(crowd(standing(3.0), 4000), np.array([0.5, -1.0]), 0.2, EYE, rng())
    assert after[:, :2].mean(axis=0) == pytest.approx([3.1, -0.2], abs=0.02)
    along, across = after[:, :2].std(axis=0)
    assert along == pytest.approx(1.5 * across, rel=0.1)


def test_some_particles_turn_much_faster_than_most():
    turned = np.abs(predicted(crowd(standing(3.0), 4000), np.zeros(2), 0.1, EYE, rng())[:, HEADING] - np.pi)
    assert 0.02 < (turned > 0.5).mean() < 0.1
    assert np.median(turned) < 0.12


def rng():
    return np.random.default_rng(8)


@pytest.mark.parametrize("step", [-0.3, 0.3])
@pytest.mark.parametrize("height", [1.5, 1.9])
def test_ascent_along_the_distance_keeps_the_top_of_the_head_in_its_place_of_the_picture(step, height):
    camera = perspective()
    pose = standing(3.0, 0.4, height)[None]
    farther = moved(pose, camera.center, DISTANCE, step)
    top = project(camera, np.concatenate([pose, farther])[:, :3])
    np.testing.assert_allclose(top[1], top[0], atol=1e-9)
    apart = np.hypot(*farther[0, :2]) - np.hypot(*pose[0, :2])
    assert apart == pytest.approx(step)
    assert (farther[0, HEIGHT] - height) * (height - 1.2) * step > 0


def test_ascent_across_the_line_of_sight_keeps_distance_and_height():
    pose = np.array([[3.0, 4.0, 1.7, 1, 0, 0]])
    moved_left = moved(pose, EYE, ACROSS, 0.1)
    assert moved_left[0, :2] == pytest.approx([3 - 0.08, 4 + 0.06])
    assert moved_left[0, HEIGHT] == 1.7


def test_ascent_of_the_height_and_of_angles_changes_nothing_else():
    pose = standing(3.0)[None]
    for coordinate in (HEADING, PAN, TILT):
        changed = np.flatnonzero(moved(pose, EYE, coordinate, 0.1) - pose)
        assert changed.tolist() == [coordinate]
    assert STATURE == HEIGHT
    assert np.flatnonzero(moved(pose, EYE, STATURE, 0.1) - pose).tolist() == [HEIGHT]


def test_ascent_keeps_the_limits():
    pose = np.array([[2, 0, 1.7, 0, MAX_PAN, MAX_TILT]])
    for coordinate in STEPS:
        np.testing.assert_array_equal(
            moved(pose, EYE, coordinate, 1.0), limited(moved(pose, EYE, coordinate, 1.0))
        )


def test_each_coordinate_climbs_and_none_ever_descends():
    top = np.array([3.0, 0.0, 1.7, 1.0, 0.2, 0.1])

    def hill(pose):
        return -(((pose - top) / [1, 1, 1, 4, 4, 4]) ** 2).sum(axis=1)

    start = top + rng().normal(0, 0.2, (30, 6))
    before = hill(start)
    after, value = ascend(start, before, hill, EYE, 3)
    np.testing.assert_allclose(value, hill(after))
    assert (value >= before).all()
    assert np.median(value / before) < 0.5


def test_a_share_of_the_best_particles_climbs():
    asked = []

    def level(pose):
        asked.append(len(pose))
        return pose[:, 0].copy()

    condense(crowd(standing(3.0), 100), np.zeros(2), 0.1, level, EYE, Search(100, 0.1, 0.2), rng())
    assert asked == [100] + [2 * 20] * len(STEPS)


def test_a_share_of_the_particles_gets_another_heading():
    def level(pose):
        return np.zeros(len(pose))

    away = {}
    for share in (0.0, 0.3):
        after, _ = condense(
            crowd(standing(3.0, heading=0.0), 300), np.zeros(2), 0.0, level, EYE, Search(300, share, 0), rng()
        )
        away[share] = (np.cos(after[:, HEADING]) < 0).mean()
    assert away[0.0] == 0
    assert away[0.3] == pytest.approx(0.3 * (1 / 3 + 2 / 3 / 2), abs=0.04)


def test_a_third_of_the_scattered_is_turned_by_half_a_turn():
    scattering = scattered(crowd(standing(3.0, heading=0.3), 300), rng())
    np.testing.assert_allclose(scattering[:100, HEADING], 0.3 + np.pi)
    assert np.ptp(scattering[100:, HEADING]) > 6
    assert np.ptp(scattering[:200, :2], axis=0).tolist() == [0, 0]
    assert (scattering[200:, :2].std(axis=0) > 0.1).all()


def test_particles_are_drawn_as_often_as_they_weigh():
    weight = np.array([0.1, 0.0, 0.55, 0.35])
    drawn_rows = np.bincount(systematic(weight, 1000, rng()), minlength=4)
    assert np.abs(drawn_rows - 1000 * weight).max() <= 1


def test_an_estimate_lies_in_one_of_two_headings_and_not_between():
    cloud = crowd(standing(3.0), 100)
    cloud[:60, HEADING], cloud[60:, HEADING] = 0.2, 0.2 + np.pi
    pose = estimated(cloud, np.full(100, 0.01)).pose
    assert pose[HEADING] == pytest.approx(0.2)
    assert np.pi / 6 < MODE < np.pi / 2


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
