"""How probable it is that a detection is a person's, and how much it counts then."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from tests.plugins.persons.box_bodies import standing
from tests.plugins.persons.crowded import corner_room
from tests.plugins.persons.joint_tracks import bodies

from followspot import Array
from followspot.assignment import assigned
from followspot_persons.associate.assignment.association_probabilities import association_probabilities
from followspot_persons.associate.boxes.ellipsoid import boxes_of
from followspot_persons.associate.boxes.model import BoxModel
from followspot_persons.associate.colors.torso_colors import BINS
from followspot_persons.associate.colors.track_colors import unknown_colors
from followspot_persons.associate.detections import Detections
from followspot_persons.associate.existence import log_visibility
from followspot_persons.associate.joints import tracks as joint_tracks
from followspot_persons.associate.multi_view.views import Noise, views_of
from followspot_persons.associate.tracks.camera_association import Association, associated
from followspot_persons.associate.tracks.lost_people import LostPeople
from followspot_persons.associate.tracks.tracks import LifeCycles, Tracks

VIEWS = views_of(tuple(corner_room().cameras.values()))
VIEW = VIEWS.each[0]
SURE = np.ones(3)


def enumerated(log_ratio: Array) -> Array:
    """The probabilities by all ways to assign the detections."""
    ratio, total, found = np.exp(log_ratio), 0.0, np.zeros(log_ratio.shape)
    rows, columns = log_ratio.shape
    for choice in product(range(-1, columns), repeat=rows):
        taken = [column for column in choice if column >= 0]
        if len(set(taken)) < len(taken):
            continue
        weight = np.prod([ratio[row, column] for row, column in enumerate(choice) if column >= 0])
        total += weight
        for row, column in enumerate(choice):
            if column >= 0:
                found[row, column] += weight
    return found / total


def test_probabilities_are_nearly_those_of_all_assignments() -> None:
    rng = np.random.default_rng(1)
    tables = rng.normal(1.0, 3.0, (200, 3, 3))
    off = np.array([association_probabilities(one, SURE) - enumerated(one) for one in tables])
    assert np.abs(off).max() < 0.2
    assert np.abs(off).mean() < 0.01
    for log_ratio in rng.normal(1.0, 3.0, (50, 3)):  # exact without a cycle of rivals
        for one in (log_ratio[None], log_ratio[:, None]):
            np.testing.assert_allclose(association_probabilities(one, SURE[: len(one)]), enumerated(one))


def test_many_joints_that_fit_leave_no_doubt() -> None:
    """Ratios of twenty joints, beside which 1 is lost in a sum."""
    sure = np.array([[90.0, 70.0], [60.0, 80.0]])
    np.testing.assert_allclose(association_probabilities(sure, SURE[:2]), np.eye(2), atol=1e-6)
    np.testing.assert_allclose(association_probabilities(sure[:1, :1], SURE[:1]), 1.0)
    rivals = association_probabilities(np.array([[500.0, np.nan], [40.0, -np.inf]]), SURE[:2])[:, :1]
    np.testing.assert_allclose(rivals, [[1.0], [0.0]], atol=1e-6)


def test_a_rival_that_may_not_exist_claims_less() -> None:
    log_ratio = np.array([[4.0], [4.0]])
    alone, beside_nobody, rivals = (
        association_probabilities(log_ratio, np.array([1.0, existence]))[0, 0]
        for existence in (0.0, 0.1, 1.0)
    )
    assert alone == pytest.approx(1 / (1 + np.exp(-4.0)))
    assert alone > beside_nobody > rivals
    assert rivals == pytest.approx(enumerated(log_ratio)[0, 0])


def test_the_less_of_a_body_a_camera_sees_the_less_probable_its_detection() -> None:
    log_ratio = log_visibility(np.array([1.0, 0.6, 0.3, 0.0]))
    np.testing.assert_allclose(log_ratio[:3], np.log([1.0, 0.6, 0.3]))
    assert -4.0 < log_ratio[3] < log_ratio[2]  # it may be seen all the same


@pytest.mark.parametrize("probability", [0.0, 0.3, 1.0])
def test_a_box_counts_as_much_as_it_is_probably_the_bodys(probability: float) -> None:
    before, row = standing((0.3, 0.2)), np.zeros(1, int)
    box = boxes_of(VIEW, before.likeliest)[0] + [12.0, -4.0, 9.0, 6.0]
    model = BoxModel(0.01, np.array([0.0, 0.0, 1.0, 0.0]))
    theirs = model.updated(before, row, VIEW, box, np.ones(1))
    after = model.updated(before, row, VIEW, box, np.array([probability]))
    move = theirs.state - before.state
    assert np.abs(move).max() > 0.02
    np.testing.assert_allclose(after.state, before.state + probability * move)
    spread = probability * (1 - probability) * move[..., None] * move[..., None, :]
    mixed = probability * theirs.covariance + (1 - probability) * before.covariance + spread
    np.testing.assert_allclose(after.covariance, mixed, atol=1e-12)
    shape = before.shape + probability * (theirs.shape - before.shape)
    np.testing.assert_allclose(after.shape, shape, atol=1e-5)


@pytest.mark.parametrize("probability", [0.0, 0.3, 1.0])
def test_joints_count_as_much_as_they_are_probably_the_bodys(probability: float) -> None:
    before = bodies(0.1)
    points = joint_tracks.expected(before, VIEW, Noise(2.0, 0.03, 0.01))
    found = points.there + np.array([6.0, -3.0])
    theirs = joint_tracks.updated(before, points, found, np.ones(1))
    after = joint_tracks.updated(before, points, found, np.array([probability]))
    moves = [getattr(theirs, name) - getattr(before, name) for name in ("xyz", "velocity")]
    for name, first, second in (
        ("position_covariance", 0, 0),
        ("cross_covariance", 0, 1),
        ("velocity_covariance", 1, 1),
    ):
        spread = probability * (1 - probability) * moves[first][..., :, None] * moves[second][..., None, :]
        own, other = getattr(theirs, name), getattr(before, name)
        mixed = probability * own + (1 - probability) * other + spread
        np.testing.assert_allclose(getattr(after, name), mixed, atol=1e-12)
    np.testing.assert_allclose(after.xyz, before.xyz + probability * moves[0])


def test_who_is_hidden_does_not_take_the_second_box_of_whom_hides_it() -> None:
    """The nearer person has its box already, and nothing is found where the hidden one is."""
    away = -VIEW.center[:2] / np.linalg.norm(VIEW.center[:2])
    people = standing((0.0, 0.0), tuple(0.4 * away))
    box = boxes_of(VIEW, people.likeliest)[0]
    double = box[0] + 0.08 * (box[0, 3] - box[0, 1]) * np.array([0.0, 1.0, 0.0, 1.0])
    life = LifeCycles(np.array([1, 2]), np.full(2, 8.0), np.zeros(2, int), unknown_colors(2, 4))
    tracks = Tracks(people, life, 0, 2, np.zeros((4, 2), int), LostPeople.none(4))
    given = Detections(0, 0, np.stack([box[0], double]), np.full((2, BINS), np.nan))
    first = np.array([True, False])
    before = replace(Association.none(given, 2), found=first, used=first)
    model = BoxModel(0.01, np.array([0.0, 0.0, 1.0, 0.0]))

    def found(number: int) -> list[bool]:
        """Who has a box; number: of the nearer person, 0 if it is not confirmed."""
        near = replace(tracks, life=replace(life, number=np.array([number, 2])))
        return associated(near, model, VIEW, before, assigned)[1].found.tolist()

    assert model.log_ratios(people, VIEW, double[None])[1, 0] > 0
    assert found(1) == [True, False]
    assert found(0) == [True, True]  # who may not exist hides nobody


def test_a_box_that_may_be_a_rivals_is_less_evidence_of_existence() -> None:
    def gain(*xy: tuple[float, float]) -> float:
        people, count = standing(*xy), len(xy)
        colors = unknown_colors(count, 4)
        life = LifeCycles(np.arange(1, count + 1), np.full(count, 8.0), np.zeros(count, int), colors)
        tracks = Tracks(people, life, 0, count, np.zeros((4, 2), int), LostPeople.none(4))
        box = boxes_of(VIEW, people.likeliest[:1])[0]
        before = Association.none(Detections(0, 0, box, np.full((1, BINS), np.nan)), count)
        model = BoxModel(0.01, np.array([0.0, 0.0, 1.0, 0.0]))
        return float(
            associated(tracks, model, VIEW, before, assigned)[1].gain(0.9, model.odds_limits.detection).sum()
        )

    assert gain((0.0, 0.0)) == pytest.approx(2.0, rel=0.01)
    assert gain((0.0, 0.0), (0.0, 0.0)) == pytest.approx(1.0, rel=0.01)
