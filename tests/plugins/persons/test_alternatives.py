"""What the paper names beside the defaults: colour differences in eq. 7, convergence, a swarm."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.plugins.persons.drawn import (
    boxes_of,
    clothes,
    detection_of,
    drawn,
    frame_of,
    perspective,
    picture_of,
    ready,
    standing,
)

from followspot_persons.body.shape import read_shape
from followspot_persons.body.view import HEADING, view
from followspot_persons.color.difference import read_relations
from followspot_persons.color.hsi import hsi
from followspot_persons.color.likelihood import FLOOR
from followspot_persons.color.pairs import (
    NOTHING_SEEN,
    difference_likelihood,
    pair_responses,
    telling_pairs,
)
from followspot_persons.likelihood.certainty import HALF
from followspot_persons.likelihood.fitness import UNSURE_BOX, Detection, Fitness, Weights, log_prior
from followspot_persons.particles.ascent import FINEST, STEPS, ascend
from followspot_persons.particles.condensation import Search, condense
from followspot_persons.particles.motion import MAX_TILT
from followspot_persons.particles.swarm import swarmed
from followspot_persons.pose_tracker import PoseTracker

SHAPE = read_shape()
PAIRS = telling_pairs(SHAPE, read_relations())
EYE = np.array([0, 0, 1.2])


def rng():
    return np.random.default_rng(3)


def test_pairs_differ_in_people_and_are_seen_together():
    first, second = PAIRS
    assert len(set(zip(first.tolist(), second.tolist(), strict=True))) == 120
    outward = SHAPE.surface.outward
    assert ((outward[first] * outward[second]).sum(axis=1) >= 0).all()
    head = SHAPE.surface.head
    assert (head[first] != head[second]).mean() > 0.5  # skin or hair, and a shirt


def test_differences_do_not_change_with_the_light_and_colours_do():
    mean = hsi(clothes(SHAPE, (160, 60, 40), (160, 60, 40)).astype(np.uint8)).astype(float)
    variance = np.full((45, 3), 0.004)
    brighter = mean + np.array([0, 0, 0.15])
    usual, other = (pair_responses(c[None], mean, variance, PAIRS) for c in (mean, brighter))
    np.testing.assert_allclose(other, usual, atol=1e-9)
    swapped = mean.copy()
    swapped[PAIRS[0, 0], 2] += 0.5
    assert pair_responses(swapped[None], mean, variance, PAIRS)[0, 0] < 0.8 * usual[0, 0]


def test_the_difference_likelihood_is_a_geometric_mean_weighted_by_the_visibility_of_both():
    responses, visibility = rng().uniform(0.1, 1, (3, 120)), rng().random((3, 45))
    weight = visibility[:, PAIRS[0]] * visibility[:, PAIRS[1]]
    expected = np.prod(responses ** (weight / weight.sum(axis=1, keepdims=True)), axis=1)
    np.testing.assert_allclose(difference_likelihood(responses, visibility, PAIRS), expected)
    assert difference_likelihood(responses, 0 * visibility, PAIRS)[0] == NOTHING_SEEN
    assert difference_likelihood(0 * responses, visibility, PAIRS)[0] == pytest.approx(float(FLOOR))


@pytest.fixture(scope="module")
def scene():
    """The fitness in a picture of a body that faces the camera, with its colours known."""
    colors = hsi(clothes(SHAPE, (160, 60, 40), (40, 60, 160)).astype(np.uint8))
    known = (colors, np.full((45, 3), 0.002, np.float32))
    picture = picture_of(perspective(), drawn(perspective(), standing(2.5)))
    return Fitness(picture, SHAPE, Weights(), colors=known, pairs=PAIRS)


def test_differences_are_a_cue_of_equation_7_with_a_weight_of_their_own(scene):
    poses = np.stack([standing(2.5), standing(2.5, 0.5)])
    seen = view(scene.picture.camera, SHAPE, poses)
    edge, color, difference = scene.edge(seen), scene.color(seen), scene.difference(seen)
    assert difference[0] > 1.3 * difference[1]
    weights = Weights(difference=0.5, gamma=0.6)
    cues = np.stack([edge, color, 0.5 * difference])
    expected = 0.6 * np.prod(cues, axis=0) ** (1 / 3) + 0.4 * cues.mean(axis=0)
    np.testing.assert_allclose(replace(scene, weights=weights).likelihood(poses), expected, rtol=1e-6)


def test_colours_count_by_a_power_in_the_search_and_as_they_are_in_the_likelihood(scene):
    """A body that is too small has the right colours everywhere, so they must not decide on its size."""
    poses = np.stack([standing(2.5), standing(3.5)])
    seen = view(scene.picture.camera, SHAPE, poses)
    edge, color = scene.edge(seen), scene.color(seen)
    halved = replace(scene, weights=Weights(color_power=0.5, gamma=1.0, sharpness=20.0))
    expected = 10 * np.log(edge * color**0.5) + log_prior(poses, halved.prior)
    np.testing.assert_allclose(halved(poses), expected, rtol=1e-6)
    np.testing.assert_allclose(halved.likelihood(poses), (edge * color) ** 0.5, rtol=1e-6)


def test_a_cue_of_weight_0_does_not_count(scene):
    poses = standing(2.5)[None]
    edge = scene.edge(view(scene.picture.camera, SHAPE, poses))
    alone = replace(scene, weights=Weights(color=0.0, difference=0.0))
    np.testing.assert_allclose(alone.likelihood(poses), edge, rtol=1e-6)


def test_a_box_weighs_by_choice_as_surely_as_the_detector_is_of_it(scene):
    poses = np.stack([standing(2.5), standing(2.5, 0.5)])
    seen = view(scene.picture.camera, SHAPE, poses)

    def told(real_valued, certainty):
        detection = replace(detection_of(scene.picture.camera, standing(2.5)), certainty=certainty)
        return replace(scene, weights=Weights(real_valued=real_valued), detection=detection).box(seen)

    np.testing.assert_array_equal(told(False, 0.1), told(False, 1.0))
    np.testing.assert_allclose(told(True, 1.0), told(False, 1.0))
    np.testing.assert_allclose(told(True, 0.0), UNSURE_BOX)
    np.testing.assert_allclose(told(True, 0.5), (told(False, 1.0) + UNSURE_BOX) / 2)


def test_the_certainty_of_a_detection_is_by_its_score():
    camera = perspective()
    frame = frame_of(camera, drawn(camera))
    for score, certain in ((HALF, 0.5), (HALF + 5, 0.99), (HALF - 5, 0.01)):
        boxes = boxes_of(camera, frame, standing(2.5), score=score)
        assert Detection.row(boxes, 0).certainty == pytest.approx(certain, abs=0.01)


def test_weights_and_gamma_are_parameters():
    tracker = ready(
        PoseTracker,
        perspective(),
        edge_weight=0.9,
        color_weight=0.8,
        difference_weight=0.7,
        hog_weight=0.6,
        gamma=0.5,
        color_power=0.4,
        likelihood_power=20,
        real_valued_boxes=True,
    )
    assert tracker.cues.weights == Weights(
        edge=0.9,
        color=0.8,
        difference=0.7,
        hog=0.6,
        gamma=0.5,
        color_power=0.4,
        sharpness=20,
        real_valued=True,
    )
    assert ready(PoseTracker, perspective()).cues.weights == Weights()


def hill(pose):
    top = np.array([3.0, 0.0, 1.7, 1.0, 0.2, 0.1])
    return -(((pose - top) / [1, 1, 1, 4, 4, 4]) ** 2).sum(axis=1)


def start(count=30):
    return np.array([3.0, 0.0, 1.7, 1.0, 0.2, 0.1]) + rng().normal(0, 0.2, (count, 6))


def test_rounds_of_ascent_end_at_the_maximum_and_cost_nothing_from_there():
    asked = []

    def counted(pose):
        asked.append(len(pose))
        return hill(pose)

    poses, values = ascend(start(), hill(start()), counted, EYE, 100)
    finest = FINEST * np.array([0.03, 0.02, 0.02, 0.25, 0.25, 0.12])
    assert np.median(-values) < (finest**2).sum()
    assert len(asked) < 60 * len(STEPS)
    assert asked[0] == 60 > asked[-1]
    one, _ = ascend(start(), hill(start()), hill, EYE, 1)
    assert np.median(-hill(one)) > 3 * np.median(-values)
    again, _ = ascend(poses, values, hill, EYE, 100)
    np.testing.assert_allclose(hill(again), values, atol=3e-3)


def test_a_swarm_finds_the_maximum_and_never_loses_a_place():
    poses, values = swarmed(start(), hill(start()), hill, 12, rng())
    assert (values >= hill(start())).all()
    np.testing.assert_allclose(values, hill(poses))
    assert np.median(values / hill(start())) < 0.2
    kept, _ = swarmed(start(), hill(start()), hill, 0, rng())
    np.testing.assert_array_equal(kept, start())


def test_a_swarm_flies_the_short_way_round_and_keeps_the_limits():
    pose = np.array([[3, 0, 1.7, 3.1, 0, MAX_TILT], [3, 0, 1.7, -3.1, 0, 0.0]])
    asked = []

    def level(poses):
        asked.append(poses.copy())
        return np.zeros(len(poses))

    swarmed(pose, np.array([1.0, 0.0]), level, 4, rng())
    places = np.concatenate(asked)
    assert np.cos(places[:, HEADING]).max() < -0.5
    assert places[:, 5].max() <= MAX_TILT


@pytest.mark.parametrize(("name", "swarm"), [("ascent", False), ("swarm", True)])
def test_the_local_search_is_a_parameter(name, swarm):
    search = ready(PoseTracker, perspective(), local_search=name, search_rounds=7).search
    assert search == Search(300, 0.15, 0.2, 7, swarm)


def test_a_swarm_takes_the_place_of_the_ascent():
    asked = []

    def counted(pose):
        asked.append(len(pose))
        return hill(pose)

    condense(start(100), np.zeros(2), 0.1, counted, EYE, Search(100, 0.1, 0.2, 5, swarm=True), rng())
    assert asked == [100] + [20] * 5
