"""Pairs of least cost together."""

from __future__ import annotations

import numpy as np

from followspot_persons.nearest_neighbours import matched


def test_the_surest_pairs_come_first_and_none_twice_or_beyond_the_limit() -> None:
    cost = np.array([[0.5, 0.2, np.inf], [0.1, 0.3, 0.9], [np.nan, 2.0, 1.0]])
    assert matched(cost, 1.0) == [(1, 0), (0, 1), (2, 2)]
    assert matched(cost, 0.9) == [(1, 0), (0, 1)]
    assert matched(np.zeros((0, 3)), 1.0) == []


def test_a_pair_that_is_the_surest_gives_way_if_all_pairs_together_are_surer() -> None:
    assert matched(np.array([[0.48, 1.17], [0.47, 0.54]]), 1.6) == [(0, 0), (1, 1)]
