"""Whether views show a ball: remembered for a while, learnt only where a picture contains it."""

from __future__ import annotations

import numpy as np
import pytest

from followspot_balls.association.visibility import predicted, updated

SEEN = np.array([True])


def test_the_rule_of_bayes_by_hand() -> None:
    assert updated(np.array([0.6]), np.array([9.0]), SEEN) == pytest.approx(5.4 / 5.8)
    assert updated(np.array([0.6]), np.array([0.0]), SEEN) == pytest.approx(0.0)
    assert updated(np.array([0.6]), np.array([1.0]), SEEN) == pytest.approx(0.6)


def test_a_view_that_cannot_see_the_place_teaches_nothing() -> None:
    assert updated(np.array([0.6]), np.array([0.0]), ~SEEN) == pytest.approx(0.6)


def test_what_was_known_fades_towards_the_usual_share() -> None:
    assert predicted(np.array([0.0, 1.0, 0.6]), 0.6, 0.9) == pytest.approx([0.06, 0.96, 0.6])
    shown = np.array([0.0])
    for _ in range(100):
        shown = predicted(shown, 0.6, 0.9)
    assert shown == pytest.approx(0.6, abs=1e-4)
