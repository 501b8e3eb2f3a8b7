"""Trials of a detector: what is held out, its thresholds and its calibration."""

from dataclasses import replace

import numpy as np
import pytest

from followspot_persons.hog.cells import CELL_FEATURES
from followspot_persons.hog.channels import CHANNELS
from followspot_persons.hog.model import (
    DIRECTIONS,
    OPTIONAL,
    SHIPPED,
    Classification,
    classify_features,
    load,
    trusted,
)
from followspot_train import figures, recipe
from followspot_train.command import calibrated
from followspot_train.pictures import Background, Person, Pictures

RNG = np.random.default_rng(0)


def tried(persons, others, windows=100_000):
    """A trial that gave these scores to windows of persons and of one folder of backgrounds."""
    none, unknown = np.zeros(0), np.zeros((len(persons), DIRECTIONS))
    said = Classification(persons, unknown, unknown)
    streets = {"streets": recipe.Searched(others, windows)}
    return recipe.Trial(None, none, none, said, said, np.zeros(len(persons)), np.zeros(len(persons)), streets)


def test_the_threshold_of_the_trials_becomes_the_score_0():
    """Whatever network and trees say, and however far apart they hold persons and others."""
    one = {name: np.zeros((1, *OPTIONAL[name].shape[1:]), OPTIONAL[name].dtype) for name in OPTIONAL}
    model = replace(load(SHIPPED), **{**one, "calibration": OPTIONAL["calibration"]})
    trial = tried(RNG.normal(6, 1, 50), np.linspace(-5, 5, 1001))
    cell_features = RNG.normal(size=(20, CELL_FEATURES)).astype(np.float32)

    def described(rows):
        return np.zeros((len(rows), CHANNELS), np.float32)

    before, after = (
        classify_features(m, cell_features, described).score for m in (model, calibrated(model, [trial]))
    )
    factor = np.ptp(after) / np.ptp(before)
    assert factor == pytest.approx(figures.steepness([trial]), rel=1e-4)
    np.testing.assert_allclose(after, factor * (before - figures.threshold([trial])), atol=1e-3)


@pytest.mark.parametrize("softness", [1.0, 2.0, 5.0])
def test_calibrated_scores_differ_by_log_odds_however_soft_they_were(softness):
    """Of two normal distributions of one sigma the log-odds rise by their distance over the variance."""
    rng = np.random.default_rng(6)
    persons, others = rng.normal(3, 1.5, 4000), rng.normal(-1, 1.5, 100_000)
    found = figures.steepness([tried(persons / softness, others / softness)])
    assert found / softness == pytest.approx(4 / 1.5**2, rel=0.05)


def test_a_calibration_ends_even_if_nothing_is_mistaken():
    """Persons and others far apart, or hardly any: no factor of any size would be wrong."""
    apart = figures.steepness([tried(np.full(5, 40.0), np.full(5, -40.0), 5)])
    assert apart == pytest.approx(1.0, abs=0.05)
    assert np.isfinite(figures.steepness([tried(np.zeros(0), np.zeros(0), 0)]))


def people(bodies=8, rooms=("a", "b", "c")):
    pixels = np.zeros((2, 2, 3), np.uint8)
    known = [Person(pixels, np.zeros(4), body, room) for body in range(bodies) for room in rooms]
    unknown = [Person(pixels, np.zeros(4), -1, f"street{i % 4}", folder="streets") for i in range(12)]
    places = [*rooms, *(f"street{i}" for i in range(4))]
    return Pictures(tuple(known + unknown), tuple(Background(pixels, place) for place in places))


def test_no_body_and_no_place_is_both_learnt_and_held_out():
    pictures = people()
    held = []
    for split in recipe.splits(pictures):
        learnt = [pictures.persons[i] for i in split.learnt]
        tried = [pictures.persons[i] for i in split.held]
        assert {p.place for p in tried} == split.held_places
        assert not {p.place for p in learnt} & split.held_places
        assert not {p.body for p in learnt if p.body >= 0} & {p.body for p in tried if p.body >= 0}
        held += [p.body for p in tried if p.body >= 0]
    assert set(held) == set(range(8))


def test_each_folder_has_a_place_and_bodies_held_out_and_its_numbers_are_its_own():
    one, pixels = people(), np.zeros((2, 2, 3), np.uint8)
    other = [Person(pixels, np.zeros(4), body, f"hall{body % 4}", folder="halls") for body in range(8)]
    pictures = one + Pictures(tuple(other), tuple(Background(pixels, f"hall{i}") for i in range(4)))
    held = []
    for fold, split in enumerate(recipe.splits(pictures)):
        assert f"hall{fold}" in split.held_places
        tried = [pictures.persons[i] for i in split.held]
        assert {p.folder for p in tried} == {"", "streets", "halls"}
        held += [p.body for p in tried if p.folder == "halls"]
    assert sorted(held) == list(range(8))


def test_recall_is_at_the_score_that_a_share_of_all_windows_exceeds():
    scores = np.arange(100.0)
    assert figures.score_at(scores, 10_000, 1e-3) == 89.0
    assert (scores > 89.0).sum() == 10


def test_mistakes_in_hard_backgrounds_are_not_hidden_by_easy_ones():
    hard, easy = recipe.Searched(np.arange(100.0), 10_000), recipe.Searched(np.arange(50.0), 10**6)
    none = np.zeros(0)
    trial = recipe.Trial(None, none, none, None, None, none, none, {"hard": hard, "easy": easy})
    assert figures.threshold_at([trial], 1e-3) == 89.0
    assert figures.threshold_at([trial, trial], 1e-3) == 89.0


def test_trust_finds_how_wrong_the_network_is_on_strangers():
    true = RNG.integers(0, DIRECTIONS, 4000)
    said = np.where(RNG.random(4000) < 0.12, RNG.integers(0, DIRECTIONS, 4000), true)
    logits = np.zeros((4000, DIRECTIONS))
    logits[np.arange(4000), said] = 40
    angle = 2 * np.pi * true / DIRECTIONS
    factor, mistaken = figures.best_trust(logits, angle)
    assert mistaken == 0.12
    assert trusted(logits, factor, mistaken).min() > np.log(0.12 / DIRECTIONS) - 1e-6
