"""What is known of a person's height, and how surely."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.plugins.persons.drawn import perspective

from followspot.geometry import project
from followspot_persons.body.standing import WAIST
from followspot_persons.body.stature import (
    CONTACT_SIGMA,
    FIRST_CONTACTS,
    PROPORTION_SIGMA,
    SPREAD,
    USUAL,
    Stature,
    size_sigma,
    weighted_median,
)
from followspot_persons.body.stature import sized as sized_by_box
from followspot_persons.likelihood.certainty import HALF, certainty

EYE = 1.2


def sized(height, pictures=60):
    known = Stature()
    for _ in range(pictures):
        known = known.sized(height, EYE)
    return known


def test_a_box_whose_size_was_not_measured_says_nothing_of_the_height():
    camera, box = perspective(), np.array([139.5, 80, 179.5, 140])
    assert len(sized_by_box(Stature(), camera, box, 0.5).sizes) == 1
    assert len(sized_by_box(Stature(), camera, box, 0.0).sizes) == 0


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
    assert size_sigma(height, EYE) == pytest.approx(PROPORTION_SIGMA * (other - height) / 0.001, rel=0.01)
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


def test_a_few_boxes_of_a_head_alone_do_not_make_a_person_tall():
    known = Stature()
    for number in range(12):
        known = known.sized(1.95 if number < 5 else 1.6, EYE)
    assert known.by_size == pytest.approx(1.6)


def test_sure_boxes_outweigh_more_boxes_that_may_show_a_part_of_the_body():
    known = Stature()
    for number in range(8):
        known = known.sized(1.95, EYE, 0.3) if number < 5 else known.sized(1.6, EYE, 0.9)
    assert known.by_size == 1.6
    sure, unsure = Stature().sized(1.6, EYE, 0.9), Stature().sized(1.6, EYE, 0.1)
    assert sure.size_sigma < 0.5 * unsure.size_sigma


def test_the_weighted_median_has_half_of_the_weight_on_either_side():
    values = np.array([3.0, 1.0, 2.0, 4.0])
    assert weighted_median(values, np.ones(4)) == np.median(values) == 2.5
    assert weighted_median(values, np.array([0.1, 2.0, 0.2, 0.3])) == 1.0
    assert weighted_median(values[:1], np.array([0.2])) == 3.0


def test_a_box_of_a_high_score_is_surer():
    assert certainty(HALF) == 0.5
    assert certainty(1.0) < 0.2 < 0.8 < certainty(5.0) < 1


def test_of_many_pictures_the_last_count():
    known = sized(1.85)
    for _ in range(60):
        known = known.sized(1.6, EYE)
    assert known.by_size == pytest.approx(1.6)


@pytest.mark.parametrize("height", [1.55, 1.9])
def test_a_box_gives_the_height_whatever_was_believed_before(height):
    """The pose that fits a picture is drawn to the height that was believed: it would confirm itself."""
    camera = perspective()
    top, low = project(camera, np.array([[2.5, 0.0, height], [2.5, 0.0, WAIST * height]]))
    box = np.array([top[0] - 40, top[1], top[0] + 40, low[1]])
    assert sized_by_box(sized(1.72, 3), camera, box).sizes[-1] == pytest.approx(height, abs=0.01)


def test_what_is_no_upper_body_gives_no_height():
    camera = perspective()
    known = sized(1.72, 3)
    assert sized_by_box(known, camera, np.array([300.0, 100.0, 340.0, 110.0])) is known
    nowhere = replace(camera, translation=np.zeros(3))
    assert sized_by_box(known, nowhere, np.array([300.0, 100.0, 340.0, 190.0])) is known
