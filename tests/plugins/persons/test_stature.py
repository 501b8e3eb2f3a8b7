"""What is known of a person's height, and how surely."""

from __future__ import annotations

import numpy as np
import pytest

from followspot_persons.stature import CONTACT_SIGMA, FIRST_CONTACTS, SPREAD, USUAL, Stature, size_sigma

EYE = 1.2


def sized(height, pictures=60):
    known = Stature()
    for _ in range(pictures):
        known = known.sized(height, EYE)
    return known


def test_of_an_unknown_person_the_height_is_that_of_people():
    assert Stature().estimate == (USUAL, SPREAD)


def test_pictures_in_a_row_do_not_make_the_size_of_a_body_sure():
    """Its proportions are one error in all of them, so people at large still count."""
    mean, sigma = sized(1.85).estimate
    assert USUAL + 0.05 < mean < 1.84
    assert 0.03 < sigma < SPREAD
    assert sigma == pytest.approx((SPREAD**-2 + size_sigma(1.85, EYE) ** -2) ** -0.5, rel=0.02)


def test_a_height_follows_from_the_distance_by_the_slope_of_the_line_of_sight():
    """With r = k h and h = z + s r, an error of k changes h by this much."""
    slope, k = 0.2, 1.5
    height = EYE / (1 - k * slope)
    other = EYE / (1 - 1.001 * k * slope)
    assert size_sigma(height, EYE) == pytest.approx(0.08 * (other - height) / 0.001, rel=0.01)
    assert size_sigma(1.7, 1.69) == 0.015
    assert size_sigma(1.7, 0.0) == np.inf


def test_feet_on_the_floor_overrule_the_size():
    known = sized(1.85)
    for _ in range(20):
        known = known.stood(1.70)
    mean, sigma = known.estimate
    assert mean == pytest.approx(1.73, abs=0.02)
    assert sigma < CONTACT_SIGMA
    back = known
    for _ in range(40):
        back = back.stood(1.90)
    assert back.estimate[0] > 1.85


def test_few_feet_do_not_count_and_feet_that_are_not_told_from_the_floor_count_little():
    few = Stature()
    for _ in range(FIRST_CONTACTS - 1):
        few = few.stood(1.6)
    assert few.estimate == Stature().estimate
    told = Stature()
    for number in range(30):
        told = told.stood(1.70 if number % 2 else 1.95)
    assert told.estimate[0] < 1.72
