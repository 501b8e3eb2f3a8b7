"""Percentage of correct parts: which limbs of skeletons lie within half their length of the true ones."""

from __future__ import annotations

import numpy as np
import pytest

from followspot_accuracy.persons.parts import correct_parts

LIMBS = [(0, 1), (1, 2)]
"""A thigh and a shin."""
LEG = np.array([[0.0, 0.0, 0.9], [0.0, 0.0, 0.5], [0.0, 0.0, 0.1]])


def legs(*across):
    """Legs that stand at these places, (P, 3, 3) m."""
    return LEG + np.array(across)[:, None, None] * [1, 0, 0]


@pytest.mark.parametrize(("off", "correct"), [(0.0, True), (0.19, True), (0.21, False)])
def test_a_part_may_be_off_by_half_its_length(off, correct):
    assert (correct_parts(legs(off), legs(0.0), LIMBS) == correct).all()


def test_the_mean_of_both_ends_counts():
    found = legs(0.0)
    found[0, 2, 0] = 0.39
    assert correct_parts(found, legs(0.0), LIMBS).tolist() == [[True, True]]
    found[0, 2, 0] = 0.41
    assert correct_parts(found, legs(0.0), LIMBS).tolist() == [[True, False]]


def test_each_person_is_compared_with_the_nearest_skeleton():
    assert correct_parts(legs(2.05, 0.1), legs(0.0, 2.0), LIMBS).all()


def test_what_is_not_found_is_wrong():
    found = legs(0.0)
    found[0, 2] = np.nan
    assert correct_parts(found, legs(0.0), LIMBS).tolist() == [[True, False]]
    assert correct_parts(found[:0], legs(0.0, 1.0), LIMBS).tolist() == [[False, False]] * 2
    assert correct_parts(found, legs(0.0)[:0], LIMBS).shape == (0, 2)
    assert not correct_parts(np.full((1, 3, 3), np.nan), legs(0.0), LIMBS).any()
