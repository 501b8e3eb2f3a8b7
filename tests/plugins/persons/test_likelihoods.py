"""Each likelihood against the equation of Weinrich, Müller & Gross 2010, written out."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from followspot_persons.body.shape import read_shape, turn
from followspot_persons.color.likelihood import (
    FLOOR,
    NARROWEST,
    channel_responses,
    color_likelihood,
    feature_responses,
    intensity_share,
)
from followspot_persons.hog.likelihood import NOTHING, box_likelihood, heading_log_likelihood
from followspot_persons.likelihood.combination import gamma_operation
from followspot_persons.likelihood.edges import edge_likelihood

RNG = np.random.default_rng(4)


def test_edge_likelihood_is_the_mean_of_gaussians_weighted_by_magnitude():
    """F^E = 1/m sum_i M_i exp(-d_i^2 / (2 sigma^2)), d_i the angle between two lines: modulo pi."""
    magnitude, orientation, expected = RNG.integers(0, 256, (3, 5, 19))
    rows = []
    for m, o, e in zip(magnitude, orientation, expected, strict=True):
        terms = []
        for magnitude_i, turn_i in zip(m, (o - e) * math.pi / 256, strict=True):
            d = min(turn_i % math.pi, -turn_i % math.pi)
            terms.append(magnitude_i / 255 * math.exp(-(d**2) / (2 * 0.4**2)))
        rows.append(sum(terms) / len(terms))
    said = edge_likelihood(
        magnitude.astype(np.uint8), orientation.astype(np.uint8), expected * np.pi / 256, 0.4
    )
    np.testing.assert_allclose(said, rows, rtol=1e-5)


def test_the_shipped_shape_has_the_features_of_the_paper():
    shape = read_shape()
    assert len(shape.outline.side) == 19
    assert len(shape.names) == 45


def test_visibility_falls_with_the_angle_between_feature_centre_and_camera():
    """Section 3.1: no normals; a feature on the far side is invisible."""
    shape = read_shape()
    heading = np.linspace(-np.pi, np.pi, 12)
    seen = turn(shape, heading, heading, np.zeros(12)).visibility
    forward, left = shape.surface.outward.T
    for row, angle in zip(seen, heading, strict=True):
        toward = forward * math.cos(angle) - left * math.sin(angle)
        np.testing.assert_allclose(row, np.maximum(toward, 0), atol=1e-6)


def test_hog_likelihood_is_vertical_overlap_times_horizontal_distance_to_the_nearest_box():
    expected = np.array([[100.0, 50, 140, 110]])
    near, far = [110.0, 56, 158, 128], [400.0, 50, 440, 110]
    overlap = (110 - 56) / (128 - 50)
    apart = ((110 + 158) / 2 - (100 + 140) / 2) / (128 - 56)
    said = box_likelihood(expected, np.array([far, near]), 0.15)
    assert said[0] == pytest.approx(overlap * math.exp(-0.5 * (apart / 0.15) ** 2))


def test_of_two_boxes_on_a_body_the_better_one_counts_alone():
    expected = np.array([[100.0, 50, 140, 110]])
    good, worse = [100.0, 52, 140, 110], [104.0, 46, 150, 115]
    both = box_likelihood(expected, np.array([worse, good]), 0.15)
    assert both == box_likelihood(expected, np.array([good]), 0.15)


def test_the_width_of_boxes_does_not_count():
    """Figure 3: the ratio of sides of detected boxes is fixed, so areas say nothing."""
    expected = np.array([[100.0, 50, 140, 110], [60.0, 50, 180, 110]])
    said = box_likelihood(expected, np.array([[90.0, 45, 138, 117]]), 0.15)
    assert said[0] == said[1]


def test_a_box_across_the_seam_is_near_and_no_box_is_not_impossible():
    expected = np.array([[1380.0, 50, 1400, 110]])
    assert box_likelihood(expected, expected - [1396, 0, 1396, 0], 0.15, turn=1396)[0] == 1
    assert box_likelihood(expected, np.empty((0, 4)), 0.15)[0] == NOTHING


def test_headings_of_a_detector_count_between_its_directions_too():
    table = np.log(np.array([0.4, 0.3, 0.2, 0.1]))
    said = heading_log_likelihood(table, np.array([0, np.pi / 4, -np.pi / 2]))
    np.testing.assert_allclose(
        said, [0, (math.log(0.3) - math.log(0.4)) / 2, math.log(0.1) - math.log(0.4)], atol=1e-12
    )


def test_channels_respond_by_their_gaussians_and_hue_goes_round():
    mean, variance = np.array([[0.98, 0.5, 0.4]]), np.array([[0.01, 0.02, 0.04]])
    colors = np.array([[[0.04, 0.6, 0.5]]])
    difference = np.array([0.06, 0.1, 0.1])
    peak = NARROWEST / np.sqrt(variance[0])
    said = channel_responses(colors, mean, variance)
    np.testing.assert_allclose(said[0, 0], peak * np.exp(-(difference**2) / (2 * variance[0])), rtol=1e-6)


def test_hue_counts_at_medium_intensity_only():
    share = intensity_share(np.array([0.0, 0.06, 0.18, 0.5, 0.82, 0.95, 1.0]))
    assert share[[0, 1, 5, 6]].tolist() == [1, 1, 1, 1]
    assert share[3] == 0
    assert 0 < share[2] < 1
    assert 0 < share[4] < 1


def test_channels_mix_by_intensity_as_in_equation_5():
    """w = lambda w_I + (1 - lambda) (w_H + w_S + w_I) / 3."""
    colors = RNG.random((4, 45, 3))
    mean, variance = RNG.random((45, 3)), RNG.uniform(0.01, 0.1, (45, 3))
    w_h, w_s, w_i = np.moveaxis(channel_responses(colors, mean, variance), -1, 0)
    share = intensity_share(colors[..., 2])
    mixed = share * w_i + (1 - share) * (w_h + w_s + w_i) / 3
    np.testing.assert_allclose(feature_responses(colors, mean, variance), mixed, rtol=1e-6)


def test_color_likelihood_is_the_geometric_mean_weighted_by_visibility_as_in_equation_6():
    """F^C = exp(sum v_i ln w_i / sum v_j)."""
    responses, visibility = RNG.uniform(0.1, 1, (3, 45)), RNG.random((3, 45))
    rows = [
        math.exp(sum(v * math.log(w) for v, w in zip(vs, ws, strict=True)) / sum(vs))
        for vs, ws in zip(visibility, responses, strict=True)
    ]
    np.testing.assert_allclose(color_likelihood(responses, visibility), rows, rtol=1e-9)


def test_a_hidden_feature_says_nothing_and_one_wrong_one_does_not_decide():
    responses = np.array([[0.9, 0.9, 0.0]])
    assert color_likelihood(responses, np.array([[1.0, 1.0, 0.0]]))[0] == pytest.approx(0.9)
    expected = (0.9 * 0.9 * float(FLOOR)) ** (1 / 3)
    assert color_likelihood(responses, np.ones((1, 3)))[0] == pytest.approx(expected)


def test_cues_combine_by_the_gamma_operation_of_equation_7():
    """P = gamma (prod alpha F)^(1/|M|) + (1 - gamma) / |M| sum alpha F."""
    edge, color, hog = RNG.random((3, 6))
    shares = (1.0, 0.8, 0.6)
    products = [(1.0 * e * 0.8 * c * 0.6 * h) ** (1 / 3) for e, c, h in zip(edge, color, hog, strict=True)]
    means = [(1.0 * e + 0.8 * c + 0.6 * h) / 3 for e, c, h in zip(edge, color, hog, strict=True)]
    said = gamma_operation([edge, color, hog], shares, 0.7)
    np.testing.assert_allclose(said, 0.7 * np.array(products) + 0.3 * np.array(means), rtol=1e-9)


@settings(deadline=None)
@given(st.lists(st.floats(0, 1), min_size=1, max_size=4), st.floats(0, 1))
def test_the_combination_lies_between_geometric_and_arithmetic_mean(values, gamma):
    said = gamma_operation([np.array([v]) for v in values], [1.0] * len(values), gamma)[0]
    geometric = math.prod(values) ** (1 / len(values))
    assert geometric - 1e-9 <= said <= sum(values) / len(values) + 1e-9
