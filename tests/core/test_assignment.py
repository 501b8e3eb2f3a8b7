"""Assignments against all permutations."""

from itertools import permutations

import numpy as np
import pytest

from followspot.assignment import assigned


def best_total(gain: np.ndarray) -> float:
    """The largest sum over all ways to pair rows with columns."""
    wide = gain if gain.shape[0] <= gain.shape[1] else gain.T
    rows = np.arange(wide.shape[0])
    worth = np.where(wide > 0, wide, 0.0)
    return max(float(worth[rows, list(way)].sum()) for way in permutations(range(wide.shape[1]), len(rows)))


@pytest.mark.parametrize("shape", [(1, 1), (3, 3), (2, 5), (5, 2), (4, 6), (6, 5)])
def test_no_other_assignment_gains_more(shape: tuple[int, int]) -> None:
    rng = np.random.default_rng(sum(shape))
    for _ in range(30):
        gain = rng.normal(size=shape).round(1)
        rows, columns = assigned(gain)
        assert gain[rows, columns].sum() == pytest.approx(best_total(gain))
        assert len(set(rows)) == len(set(columns)) == len(rows)
        assert (gain[rows, columns] > 0).all()
        assert (np.diff(rows) > 0).all()


def test_pairs_without_gain_stay_apart() -> None:
    rows, columns = assigned(np.array([[-np.inf, 2.0, np.nan], [0.0, 3.0, -1.0], [5.0, 0.0, 0.0]]))
    assert (rows.tolist(), columns.tolist()) == ([1, 2], [1, 0])


@pytest.mark.parametrize("shape", [(0, 0), (0, 3), (3, 0)])
def test_nothing_is_assigned_to_nothing(shape: tuple[int, int]) -> None:
    assert [len(part) for part in assigned(np.zeros(shape))] == [0, 0]
