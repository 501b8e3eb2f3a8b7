"""The leave-one-out choice of the errors of scale."""

from __future__ import annotations

import pytest

from choose_inertial import chosen, distance

SHARES = {
    "a": {0.001: 0.80, 0.002: 0.94, 0.004: 0.99},
    "b": {0.001: 0.82, 0.002: 0.95, 0.004: 0.99},
    "c": {0.001: 0.95, 0.002: 0.99, 0.004: 1.00},
}


def test_value_is_chosen_without_the_trial_that_judges_it() -> None:
    assert chosen(SHARES, "c") == 0.002
    assert chosen({"a": SHARES["a"], "c": SHARES["c"]}, "a") == 0.001


def test_too_large_and_too_small_sigmas_are_both_far_from_honest() -> None:
    assert distance(0.95) == pytest.approx(0.0)
    assert distance(0.99) > distance(0.97) > 0.0
    assert distance(0.80) > distance(0.92) > 0.0
    assert distance(1.0) < 10.0
