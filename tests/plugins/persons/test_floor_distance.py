"""Where a person stands, if some of the feet seen were those of others."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from followspot.plain_values import from_plain, to_plain
from followspot_persons.background.floor_contact import STRIDE_SIGMA, Contact
from followspot_persons.body.stature import PROPORTION_SIGMA
from followspot_persons.slow_instance.floor_distance import MOST, UNUSUAL, UNUSUAL_SIGMA, FloorDistance

PERIOD = 0.2
"""Time from one picture to the next, s."""


def feet(distance):
    return Contact(distance, STRIDE_SIGMA)


def followed(distance, *pictures):
    """The distance after pictures of feet and size of a box, m each, None if not seen."""
    for foot, size in pictures:
        told = None if size is None else Contact(size, 0.15 * size)
        distance = distance.later(None if foot is None else feet(foot), told, PERIOD)
    return distance


def test_first_feet_that_were_somebody_elses_hold_nobody_for_long():
    """The foot of a wall passed for feet at 6.6 m; the sizes of boxes say nothing, the next feet 3.8 m."""
    first = FloorDistance.of(feet(6.6))
    assert followed(first, (3.8, None)).contact.distance == 6.6
    assert followed(first, (3.8, None), (3.8, None)).contact == feet(3.8)


def test_one_picture_with_the_feet_of_others_moves_nobody():
    told = followed(FloorDistance.of(feet(3.0)), *[(3.0, 3.0)] * 10)
    other = followed(told, (4.2, 3.0))
    assert other.contact.distance == pytest.approx(3.0, abs=0.01)
    assert followed(other, (3.0, 3.0)).contact == feet(3.0)


def test_feet_seen_often_are_given_up_for_others_seen_twice():
    told = followed(FloorDistance.of(feet(3.0)), *[(3.0, 3.0)] * 30)
    assert followed(told, (4.2, 4.2), (4.2, 4.2)).contact == feet(4.2)


def test_sizes_choose_among_feet():
    """The first feet are as far from the second ones as these from them; boxes say who is right."""
    first = FloorDistance.of(feet(4.0))
    for size in (3.0, 4.0):
        assert followed(first, (3.0, size)).contact.distance == pytest.approx(size, abs=0.05)


def test_sizes_alone_tell_the_distance_if_they_contradict_the_only_feet():
    sizes = followed(FloorDistance(), *[(None, 3.0)] * 8)
    assert followed(sizes, (3.3, 3.0)).contact == feet(3.3)
    assert followed(sizes, (6.0, 3.0)).contact is None
    assert followed(sizes, (6.0, 3.0)).sized.distance == pytest.approx(3.0)


def walks_away(unusual=True):
    """Feet seen up to 3.0 m, then hidden for half a second, then seen again; boxes are a third too large."""
    told, truth = FloorDistance.of(feet(2.7)), 2.7
    for step in range(7):
        truth += 0.1
        told = followed(told, (None if step in (3, 4) else truth, 0.75 * truth))
        if not unusual:
            told = replace(told, hypotheses=tuple(replace(h, proportion=0.08) for h in told.hypotheses))
    return told, truth


def test_boxes_that_are_a_third_too_large_refuse_no_feet():
    """Sizes that err by 8 % would refuse the feet that are seen again, and hold the person too near."""
    told, truth = walks_away()
    assert told.contact == feet(truth)
    assert told.hypotheses[0].proportion == UNUSUAL_SIGMA
    held, truth = walks_away(unusual=False)
    assert held.contact.distance < truth - 0.8


def test_sizes_are_usual_while_they_agree_with_feet():
    told = followed(FloorDistance.of(feet(3.0)), *[(3.0, 3.1)] * 6)
    usual, unusual = told.hypotheses[:2]
    assert (usual.proportion, unusual.proportion) == (PROPORTION_SIGMA, UNUSUAL_SIGMA)
    assert unusual.contact == usual.contact
    assert unusual.weight(told.sized) < UNUSUAL * usual.weight(told.sized)


def test_sizes_tell_no_distance_better_than_to_their_common_error():
    told = followed(FloorDistance.of(feet(3.0)), *[(None, 3.0)] * 60)
    usual, unusual = (h.contact for h in told.hypotheses[:2])
    assert usual.sigma == pytest.approx(PROPORTION_SIGMA * 3.0, rel=0.15)
    assert unusual.sigma == pytest.approx(UNUSUAL_SIGMA * 3.0, rel=0.15)


def test_few_hypotheses_are_kept_and_one_says_that_no_feet_were_the_persons():
    told, random = FloorDistance.of(feet(3.0)), np.random.default_rng(1)
    for _ in range(40):
        told = followed(told, (float(random.uniform(2, 8)), 4.0))
        assert len(told.hypotheses) <= MOST + 1
        assert [h.contact for h in told.hypotheses].count(None) == 1
        assert sum(h.evidence for h in told.hypotheses) == pytest.approx(1)
        assert sum(share for share, _ in told.apparent(PERIOD)) == pytest.approx(1)


def test_boxes_are_expected_between_the_feet_and_the_sizes_of_before():
    """A person whose proportions make it seem a sixth nearer than its feet stand."""
    told = FloorDistance.of(feet(3.0))
    (_, by_feet), *_ = told.apparent(PERIOD)
    assert by_feet.distance == 3.0
    (share, place), *_ = followed(told, *[(3.0, 2.5)] * 20).apparent(PERIOD)
    assert share > 0.9
    assert 2.5 < place.distance < 2.85
    assert place.sigma < by_feet.sigma


def test_a_successor_knows_all_hypotheses():
    told = followed(FloorDistance.of(feet(6.6)), (3.8, 5.0))
    assert len(told.hypotheses) > 1
    assert from_plain(FloorDistance, to_plain(told)) == told
    assert from_plain(FloorDistance, to_plain(replace(told, sized=None))).sized is None
