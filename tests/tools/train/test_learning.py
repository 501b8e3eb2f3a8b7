"""Learning of linear weights, networks and trees, against their derivatives and minima."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from followspot_persons.hog.model import (
    DIRECTIONS,
    OUTPUTS,
)
from followspot_persons.hog.network import outputs
from followspot_persons.hog.trees import log_odds
from followspot_train import boosting, network, svm

RNG = np.random.default_rng(0)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 1000))
def test_weights_minimise_the_squared_hinge(seed):
    """At the minimum the gradient w - 2 C sum(sign x max(0, 1 - sign w x)) vanishes."""
    rng = np.random.default_rng(seed)
    X = np.column_stack([rng.normal(size=(40, 2)), np.ones(40)]).astype(np.float32)
    sign = np.where(X[:, 0] + 0.3 * rng.normal(size=40) > 0, 1.0, -1.0)
    cost = rng.uniform(0.01, 0.05, 40)
    w = svm.fit(X, sign, cost, rng)
    short = np.maximum(0, 1 - sign * (X @ w))
    gradient = w - 2 * (cost * sign * short) @ X
    assert np.abs(gradient).max() < 5e-3


def entropy(out, person, torso, head):
    """The cross entropies of which `network.errors` is the derivative, summed over rows."""
    total = np.logaddexp(0, out[:, 0]) - person * out[:, 0]
    for first, true in ((1, torso), (1 + DIRECTIONS, head)):
        part = out[:, first : first + DIRECTIONS]
        total = total + (true * (np.logaddexp.reduce(part, axis=1)[:, None] - part)).sum(axis=1)
    return total.sum()


def test_the_network_learns_along_the_derivative_of_its_cross_entropy():
    out = RNG.normal(size=(3, OUTPUTS))
    torso = network.directions(np.array([0.3, np.nan, -2.0]))
    truth = (np.array([1.0, 0.0, 1.0]), torso, torso[::-1])
    wrong = network.errors(out, truth[0], truth[1:])
    for row, column in [(0, 0), (1, 0), (0, 5), (1, 5), (2, 30)]:
        step = np.zeros_like(out)
        step[row, column] = 1e-6
        slope = (entropy(out + step, *truth) - entropy(out - step, *truth)) / 2e-6
        assert wrong[row, column] == pytest.approx(slope, abs=1e-6)


def test_nothing_is_learnt_from_an_unknown_heading():
    unknown = network.directions(np.array([np.nan]))
    wrong = network.errors(RNG.normal(size=(1, OUTPUTS)), np.array([1.0]), [unknown, unknown])
    assert not wrong[:, 1:].any()
    assert wrong[0, 0] != 0


def quiet(_):
    pass


def test_a_network_learns_what_no_line_can_part_without_directions(monkeypatch):
    """Persons are where two features have the same sign; inputs of half precision will do."""
    rng = np.random.default_rng(4)
    inputs = rng.normal(size=(3000, 4)).astype(np.float16)
    person = (inputs[:, 1] * inputs[:, 3] > 0).astype(np.float32)
    monkeypatch.setattr(network, "DROPPED_INPUT", 0.0)
    monkeypatch.setattr(network, "EPOCHS", 60)
    learnt = network.train(network.Examples(inputs[:2000], person[:2000]), rng, quiet)
    said = outputs(learnt, inputs[2000:].astype(np.float32))
    assert said.shape == (1000, 1)
    assert ((said[:, 0] > 0) == person[2000:]).mean() > 0.9


def test_trees_learn_what_no_line_can_part(monkeypatch):
    """Persons are where two features are above 0; the other eight say nothing."""
    rng = np.random.default_rng(4)
    features = rng.normal(size=(3000, 10)).astype(np.float32)
    person = ((features[:, 3] > 0) & (features[:, 8] > 0)).astype(float)
    monkeypatch.setattr(boosting, "TREES", 60)
    trees = boosting.train(features[:2000], person[:2000], rng, quiet)
    said = log_odds(trees, features[2000:])
    assert ((said > 0) == person[2000:]).mean() > 0.95
    assert set(trees.feature[0]) >= {3, 8}


def test_leaves_step_to_the_minimum_of_the_cross_entropy(monkeypatch):
    """One tree with whole steps: the slope of its cross entropy, by the log-odds of a leaf, falls by far."""
    rng = np.random.default_rng(5)
    features = rng.normal(size=(4000, 3)).astype(np.float32)
    person = (rng.random(4000) < np.where(features[:, 1] > 0.5, 0.6, 0.3)).astype(float)
    monkeypatch.setattr(boosting, "TREES", 1)
    monkeypatch.setattr(boosting, "RATE", 1.0)
    said = log_odds(boosting.train(features, person, rng, quiet), features)
    for value in np.unique(said):
        own = person[said == value]
        assert 1 / (1 + np.exp(-value)) == pytest.approx(own.mean(), abs=0.03)
