"""`tools/try_whole_bodies.py`: what is compared, and how it is told."""

import numpy as np

from followspot_persons.hog.model import SHIPPED, load
from followspot_persons.hog.network import Network
from followspot_persons.hog.trees import Trees
from followspot_persons.hog.whole_model import INPUTS, WholeModel
from followspot_train.linear import searched
from followspot_train.pictures import Background
from try_whole_bodies import folders, scored, text

PIXELS = np.random.default_rng(0).integers(0, 256, (220, 260, 3), np.uint8)


def test_windows_are_scored_alone_and_with_whole_bodies_that_only_raise():
    trees = Trees(np.zeros((1, 3), np.intp), np.zeros((1, 3)), np.full((1, 4), 9.0))
    network = Network(np.zeros((INPUTS, 1)), np.zeros(1), np.zeros((1, 1)), np.full(1, 9.0))
    alone, both = scored(load(SHIPPED), WholeModel(network, trees), Background(PIXELS, "street0"))
    assert len(alone) == len(both)
    assert (both >= alone).all()
    assert (both > alone).any()


def test_windows_are_counted_by_folder():
    held = [
        Background(PIXELS, "street0", "a"),
        Background(PIXELS, "street0", "a"),
        Background(PIXELS, "x", "b"),
    ]
    found = folders(held, [np.zeros(2), np.ones(3), np.ones(1)])
    assert found["a"].scores.tolist() == [0, 0, 1, 1, 1]
    assert found["a"].windows == 2 * searched(PIXELS) == 2 * found["b"].windows


def test_a_line_has_both_rates_of_each_folder():
    one, few = {"recall": 0.9}, {"recall": 0.8}
    row = {"trial": 2, "judged_by": "whole bodies", "found": {"a/b": one}, "found_at_threshold": {"a/b": few}}
    assert text(row) == "trial 2, whole bodies: b 90.0, 80.0 %"
