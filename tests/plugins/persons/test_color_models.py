"""What is learnt of a person's colours, and what it tells of the sides that nobody has seen (section 3.3)."""

import numpy as np
import pytest

from followspot_persons.body.shape import read_shape
from followspot_persons.color.difference import OBSERVATION, ColorRelations, completed, read_relations
from followspot_persons.color.hsi import from_plane, hsi, plane
from followspot_persons.color.model import FIRST_VARIANCE, ColorModel, learnt
from followspot_persons.slow_instance.identity import same_person

RNG = np.random.default_rng(5)
NAMES = read_shape().names
SHIRT = ("chest", "ribs", "belly")


def test_hsi_of_pure_colours():
    pixels = np.array([[0, 0, 255], [0, 255, 0], [255, 0, 0], [255, 255, 255], [40, 40, 40]], np.uint8)
    expected = [[0, 1, 1 / 3], [1 / 3, 1, 1 / 3], [2 / 3, 1, 1 / 3], [0, 0, 1], [0, 0, 120 / 765]]
    np.testing.assert_allclose(hsi(pixels), expected, atol=1e-5)


def seen_often(colors, weight=1.0, memory=1000.0):
    model = ColorModel.unseen(colors.shape[1])
    for color in colors:
        model = learnt(model, color, np.full(colors.shape[1], weight), memory)
    return model


def test_the_recursive_mean_is_the_maximum_likelihood_estimate():
    colors = RNG.uniform(0.2, 0.8, (30, 2, 3))
    model = seen_often(colors)
    np.testing.assert_allclose(plane(model.mean), plane(colors).mean(axis=0), atol=1e-12)
    assert model.evidence.tolist() == [30, 30]


def test_the_recursive_variance_approaches_that_of_the_colours():
    sigma = np.array([0.02, 0.05, 0.1])
    colors = np.array([0.4, 0.5, 0.5]) + sigma * RNG.standard_normal((800, 1, 3))
    model = seen_often(colors, memory=1e6)
    np.testing.assert_allclose(np.sqrt(model.variance[0]), sigma, rtol=0.1)


def test_hues_on_both_sides_of_red_are_alike():
    hue = np.where(np.arange(200) % 2, 0.02, 0.98)
    colors = np.column_stack([hue, np.full(200, 0.5), np.full(200, 0.5)])[:, None]
    model = seen_often(colors, memory=1e6)
    assert abs(model.mean[0, 0] - np.rint(model.mean[0, 0])) < 0.01
    assert np.sqrt(model.variance[0, 0]) == pytest.approx(0.02, rel=0.1)


def test_what_was_not_seen_stays_unknown():
    model = learnt(ColorModel.unseen(2), np.full((2, 3), 0.5), np.array([1.0, 0.0]), 30)
    assert model.evidence.tolist() == [1, 0]
    np.testing.assert_array_equal(model.variance[1], FIRST_VARIANCE)


def test_with_limited_memory_new_light_is_learnt():
    before, after = np.full((60, 1, 3), 0.3), np.full((60, 1, 3), 0.6)
    model = seen_often(np.concatenate([before, after]), memory=20)
    assert abs(model.mean[0, 2] - 0.6) < 0.3 * 0.05


def test_unseen_features_are_the_conditional_gaussian_of_the_seen_ones():
    """mean_2 + C_21 (C_11 + noise)^-1 (x_1 - mean_1), for each coordinate."""
    covariance = np.array([[0.05, 0.04], [0.04, 0.06]])
    relations = ColorRelations(np.array([[0.1, 0.0, 0.5], [0.2, 0.1, 0.4]]), covariance, covariance)
    color = np.array([[0.3, 0.1, 0.7]])
    model = ColorModel(from_plane(np.vstack([color, color])), np.full((2, 3), 0.01), np.array([20.0, 0.0]))
    told = plane(completed(model, relations).mean)[1]
    for k, noise in ((0, 0.01), (1, 0.01), (2, 0.02)):
        gain = 0.04 / (0.05 + OBSERVATION + noise / 20)
        expected = relations.mean[1, k] + gain * (color[0, k] - relations.mean[0, k])
        assert told[k] == pytest.approx(expected)


@pytest.mark.parametrize("hue", [0.0, 0.35, 0.6])
def test_the_back_of_a_shirt_is_told_by_its_front_and_less_surely(hue):
    front, back = (np.isin(NAMES, [f"{part} {side}" for part in SHIRT]) for side in (0, 180))
    model = ColorModel.unseen(len(NAMES))
    shirt = np.tile([hue, 0.7, 0.4], (len(NAMES), 1))
    for _ in range(10):
        model = learnt(model, shirt, front.astype(float), 30)
    told = completed(model, read_relations())
    apart = np.abs(told.mean[back, 0] - hue)
    assert np.minimum(apart, 1 - apart).max() < 0.06
    assert (told.variance[back, 1] > told.variance[front, 1].max()).all()
    assert (told.evidence[back] == 0).all()


def dressed(hue, intensity=0.4):
    colors = np.tile([hue, 0.6, intensity], (10, len(NAMES), 1))
    return seen_often(colors, memory=30)


def test_the_same_clothes_are_one_person_and_others_are_not():
    relations = read_relations()
    same = same_person(dressed(0.3), dressed(0.31), (1.75, 1.76), relations)
    other = same_person(dressed(0.3), dressed(0.8), (1.75, 1.76), relations)
    taller = same_person(dressed(0.3), dressed(0.31), (1.75, 1.95), relations)
    assert same > 0 > other
    assert taller < same
