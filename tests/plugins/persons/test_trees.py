"""Channels of windows, and the boosted trees that classify them."""

from dataclasses import replace

import numpy as np
import pytest

from followspot_persons.hog.cells import CELL_FEATURES
from followspot_persons.hog.channels import CELLS, CHANNELS, ORIENTATIONS, channels
from followspot_persons.hog.model import SHIPPED, TREES, UNLIKELY, classify_features, load
from followspot_persons.hog.trees import ROWS, Trees, log_odds
from followspot_persons.hog.window import HEIGHT, WIDTH

RNG = np.random.default_rng(0)
MAPS = 5 + ORIENTATIONS


def maps(window):
    return channels([window])[0].reshape(MAPS, CELLS[1], CELLS[0])


def test_trees_add_what_their_leaves_say():
    trees = Trees(RNG.integers(0, 9, (7, 3)), RNG.normal(size=(7, 3)), RNG.normal(size=(7, 4)))
    features = RNG.normal(size=(ROWS + 30, 9))

    def leaf(row, number):
        (root, *children), (bound, *bounds) = trees.feature[number], trees.threshold[number]
        side = int(row[root] > bound)
        return trees.leaf[number, 2 * side + int(row[children[side]] > bounds[side])]

    expected = [sum(leaf(row, number) for number in range(7)) for row in features]
    np.testing.assert_allclose(log_odds(trees, features), expected)


def test_no_trees_say_nothing():
    none = Trees(np.zeros((0, 3), np.intp), np.zeros((0, 3)), np.zeros((0, 4)))
    assert log_odds(none, RNG.normal(size=(3, 5))).tolist() == [0, 0, 0]


def test_a_cell_has_the_mean_of_its_pixels():
    """Of the ratio of red over green in a window that is red in one cell."""
    window = np.full((HEIGHT, WIDTH, 3), 100, np.uint8)
    window[8:12, 20:24] = (100, 100, 200)
    found = maps(window)[1]
    assert found[2, 5] == pytest.approx(np.log(208 / 108), abs=1e-5)
    found[2, 5] = 0
    assert np.abs(found).max() < 1e-6


@pytest.mark.parametrize("number", range(ORIENTATIONS))
def test_an_edge_counts_for_its_orientation(number):
    """A ramp whose brightness rises along one orientation, and one between two; greys are whole numbers."""
    v, u = np.mgrid[:HEIGHT, :WIDTH]
    beside = (number + 1) % ORIENTATIONS
    for turned in (0.0, 0.5):
        angle = np.pi * (number + turned) / ORIENTATIONS
        grey = 128 + 2.2 * ((u - 32) * np.cos(angle) + (v - 40) * np.sin(angle))
        found = maps(np.repeat(np.rint(grey)[..., None], 3, axis=2).astype(np.uint8))
        np.testing.assert_allclose(found[5:].sum(axis=0), found[4], rtol=1e-4)
        share = found[5:, 4:-4, 4:-4].sum(axis=(1, 2)) / found[4, 4:-4, 4:-4].sum()
        if turned:
            assert share[[number, beside]].sum() > 0.9
            assert abs(share[number] - share[beside]) < 0.1
        else:
            assert share[number] > 0.75


def test_the_weights_in_use_have_trees():
    assert len(load(SHIPPED).tree_leaf) == 600


def test_channels_hardly_depend_on_the_exposure():
    window = RNG.integers(40, 120, (HEIGHT, WIDTH, 3), np.uint8)
    dark, bright = maps(window), maps(2 * window)
    assert np.abs(dark[0] - bright[0]).max() < 0.1
    assert np.abs(dark[4:] - bright[4:]).max() < 0.15 * dark[4:].max()


def test_trees_are_asked_only_where_the_network_sees_a_chance():
    """Their word is a share of the score there; elsewhere the network's stands alone."""
    model = replace(
        load(SHIPPED),
        tree_feature=np.zeros((4, 3), np.intp),
        tree_threshold=np.zeros((4, 3), np.float32),
        tree_leaf=np.zeros((4, 4), np.float32),
    )
    cell_features = RNG.normal(size=(40, CELL_FEATURES)).astype(np.float32)
    asked = []

    def described(rows):
        asked.append(rows)
        return np.zeros((len(rows), CHANNELS), np.float32)

    network = replace(model, output_bias=model.output_bias + 100)
    alone = classify_features(network, cell_features, described).score / (1 - TREES) - 100
    assert len(asked.pop()) == 40
    shift = UNLIKELY - np.median(alone)
    shifted = replace(model, output_bias=model.output_bias + np.eye(len(model.output_bias))[0] * shift)
    leaves = replace(shifted, tree_leaf=np.full((4, 4), 0.25, np.float32))
    found = classify_features(leaves, cell_features, described).score
    [rows] = asked
    assert 10 < len(rows) < 30
    expected = alone + shift
    assert (np.delete(expected, rows) <= UNLIKELY).all()
    expected[rows] = (1 - TREES) * expected[rows] + TREES
    np.testing.assert_allclose(found, expected, atol=1e-3)
