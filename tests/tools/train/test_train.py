"""`followspot train hog`: what is learnt, what is held out, and what is refused."""

import json
from dataclasses import replace

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from followspot import InputError
from followspot.cli.main import main
from followspot_persons.hog.cells import CELL_FEATURES
from followspot_persons.hog.channels import CHANNELS
from followspot_persons.hog.model import (
    DIRECTIONS,
    OPTIONAL,
    OUTPUTS,
    SHIPPED,
    Classification,
    classify_features,
    load,
    trusted,
)
from followspot_persons.hog.network import outputs
from followspot_persons.hog.trees import log_odds
from followspot_persons.hog.window import ABOVE
from followspot_train import boosting, figures, linear, network, recipe, svm, windows
from followspot_train.command import calibrated
from followspot_train.pictures import Background, Person, Pictures, read_folder

RNG = np.random.default_rng(0)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 1000))
def test_weights_minimise_the_squared_hinge(seed):
    """At the minimum the gradient w - 2 C sum(sign x max(0, 1 - sign w x)) vanishes."""
    rng = np.random.default_rng(seed)
    X = np.column_stack([rng.normal(size=(40, 2)), np.ones(40)]).astype(np.float32)
    sign = np.where(X[:, 0] + 0.3 * rng.normal(size=40) > 0, 1.0, -1.0)
    cost = rng.uniform(0.01, 0.05, 40)
    w = svm.fit(X, sign, cost, rng)
    short = np.maximum(0, 1 - sign * (X @ w))
    gradient = w - 2 * (cost * sign * short) @ X
    assert np.abs(gradient).max() < 5e-3


def entropy(out, person, torso, head):
    """The cross entropies of which `network.errors` is the derivative, summed over rows."""
    total = np.logaddexp(0, out[:, 0]) - person * out[:, 0]
    for first, true in ((1, torso), (1 + DIRECTIONS, head)):
        part = out[:, first : first + DIRECTIONS]
        total = total + (true * (np.logaddexp.reduce(part, axis=1)[:, None] - part)).sum(axis=1)
    return total.sum()


def test_the_network_learns_along_the_derivative_of_its_cross_entropy():
    out = RNG.normal(size=(3, OUTPUTS))
    torso = network.directions(np.array([0.3, np.nan, -2.0]))
    truth = (np.array([1.0, 0.0, 1.0]), torso, torso[::-1])
    wrong = network.errors(out, truth[0], truth[1:])
    for row, column in [(0, 0), (1, 0), (0, 5), (1, 5), (2, 30)]:
        step = np.zeros_like(out)
        step[row, column] = 1e-6
        slope = (entropy(out + step, *truth) - entropy(out - step, *truth)) / 2e-6
        assert wrong[row, column] == pytest.approx(slope, abs=1e-6)


def test_nothing_is_learnt_from_an_unknown_heading():
    unknown = network.directions(np.array([np.nan]))
    wrong = network.errors(RNG.normal(size=(1, OUTPUTS)), np.array([1.0]), [unknown, unknown])
    assert not wrong[:, 1:].any()
    assert wrong[0, 0] != 0


def quiet(_):
    pass


def test_a_network_learns_what_no_line_can_part_without_directions(monkeypatch):
    """Persons are where two features have the same sign; inputs of half precision will do."""
    rng = np.random.default_rng(4)
    inputs = rng.normal(size=(3000, 4)).astype(np.float16)
    person = (inputs[:, 1] * inputs[:, 3] > 0).astype(np.float32)
    monkeypatch.setattr(network, "DROPPED_INPUT", 0.0)
    monkeypatch.setattr(network, "EPOCHS", 60)
    learnt = network.train(network.Examples(inputs[:2000], person[:2000]), rng, quiet)
    said = outputs(learnt, inputs[2000:].astype(np.float32))
    assert said.shape == (1000, 1)
    assert ((said[:, 0] > 0) == person[2000:]).mean() > 0.9


def test_trees_learn_what_no_line_can_part(monkeypatch):
    """Persons are where two features are above 0; the other eight say nothing."""
    rng = np.random.default_rng(4)
    features = rng.normal(size=(3000, 10)).astype(np.float32)
    person = ((features[:, 3] > 0) & (features[:, 8] > 0)).astype(float)
    monkeypatch.setattr(boosting, "TREES", 60)
    trees = boosting.train(features[:2000], person[:2000], rng, quiet)
    said = log_odds(trees, features[2000:])
    assert ((said > 0) == person[2000:]).mean() > 0.95
    assert set(trees.feature[0]) >= {3, 8}


def test_leaves_step_to_the_minimum_of_the_cross_entropy(monkeypatch):
    """One tree with whole steps: the slope of its cross entropy, by the log-odds of a leaf, falls by far."""
    rng = np.random.default_rng(5)
    features = rng.normal(size=(4000, 3)).astype(np.float32)
    person = (rng.random(4000) < np.where(features[:, 1] > 0.5, 0.6, 0.3)).astype(float)
    monkeypatch.setattr(boosting, "TREES", 1)
    monkeypatch.setattr(boosting, "RATE", 1.0)
    said = log_odds(boosting.train(features, person, rng, quiet), features)
    for value in np.unique(said):
        own = person[said == value]
        assert 1 / (1 + np.exp(-value)) == pytest.approx(own.mean(), abs=0.03)


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


def figure(rng, towards):
    """A crop with a head and a torso, and a bright bar on the side that it turns to."""
    pixels = rng.integers(90, 110, (112, 96, 3), np.uint8)
    cv2.circle(pixels, (48, 34), 12, (60, 90, 160), -1)
    cv2.ellipse(pixels, (48, 96), (24, 44), 0, 180, 360, (40, 40, 40), -1)
    cv2.rectangle(
        pixels, (47 + int(12 * np.sin(towards)), 60), (51 + int(12 * np.sin(towards)), 90), (255,) * 3
    )
    return pixels


def test_persons_are_learnt_with_heads_above_the_picture_too(monkeypatch):
    monkeypatch.setattr(windows, "described", lambda cut, owner, headings: np.array(cut))
    pixels = RNG.integers(0, 256, (112, 96, 3), np.uint8)
    persons = [Person(pixels, np.array([24.0, 20.0, 72.0, 92.0]), 0, "a")] * 4
    shares = []
    for above, cut in ((0, 1.0), (ABOVE, 1.0), (ABOVE, windows.CUT)):
        monkeypatch.setattr(windows, "CUT", cut)
        learnt = windows.found(persons, 20, above, np.random.default_rng(0))
        shares.append(np.mean([np.array_equal(w[0], w[1]) for w in learnt]))
    assert shares[:2] == [0.0, 1.0]
    assert 0.08 < shares[2] < 0.25


def test_backgrounds_are_searched_over_the_top_of_the_picture():
    pixels = RNG.integers(0, 256, (80, 64, 3), np.uint8)
    bare = list(linear.sizes(pixels))
    for picture, inside in zip(linear.sizes(pixels, above=ABOVE), bare, strict=True):
        np.testing.assert_array_equal(picture[ABOVE:], inside)
        assert (picture[:ABOVE] == inside[0]).all()


@pytest.fixture
def folder(tmp_path):
    """Four bodies in two rooms."""
    rows = ["file,body,room,torso_heading,head_pan"]
    for number in range(32):
        towards = 2 * np.pi * (number // 4) / 8 - np.pi
        cv2.imwrite(str(tmp_path / f"c{number}.png"), figure(RNG, towards))
        rows.append(f"c{number}.png,{number % 4},{'ab'[number // 4 % 2]},{towards},0.1")
    (tmp_path / "boxes.csv").write_text("\n".join(rows))
    for room in "ab":
        cv2.imwrite(str(tmp_path / f"neg_{room}.png"), RNG.integers(0, 256, (150, 170, 3), np.uint8))
    return tmp_path


def test_the_command_writes_weights_and_tells_figures_of_strangers(folder, monkeypatch, capsys):
    for name, value in (("FIRST", 60), ("HARD", 40), ("ROUNDS", 1)):
        monkeypatch.setattr(linear, name, value)
    monkeypatch.setattr(recipe, "DECEIVING", 50)
    monkeypatch.setattr(boosting, "TREES", 40)
    monkeypatch.setattr(recipe, "VIEWS", 6)
    out = folder / "weights.npz"
    assert main(["train", "hog", str(folder), "-o", str(out), "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["persons"] == 32
    assert list(report["found"]) == [str(folder)]
    found = report["found"][str(folder)]
    assert found["persons"] == 16  # each fold tries one body in one room of the two
    assert found["recall"] >= 0.9
    assert set(report["torso"]) == {"median_deg", "within_22_5", "within_45", "flipped"}
    assert set(report["opencv"]) == {str(folder)}
    assert load(out).hidden.shape[1] == network.UNITS
    monkeypatch.setattr(boosting, "TREES", 2)
    monkeypatch.setattr(recipe, "VIEWS", 2)
    assert main(["train", "hog", str(folder), "-o", str(folder / "again.npz")]) == 0
    assert f"found at 1 false positive in 1,000 windows: {folder}" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("spoil", "cause"),
    [
        (lambda folder: (folder / "c3.png").unlink(), "c3.png is no picture"),
        (lambda folder: rewrite(folder, "c3.png", "../c3.png"), "line 5: .*no name of a file"),
        (lambda folder: rewrite(folder, "torso_heading", "heading"), "line 2: .*torso_heading"),
        (lambda folder: rewrite(folder, "c3.png,3,a", "c3.png,x,a"), "line 5: .*invalid literal"),
        (lambda folder: rewrite(folder, "c3.png,3,a", f"c3.png,{10**30},a"), "line 5: .*bodies are numbered"),
        (lambda folder: rewrite(folder, "c3.png,3,a", "c3.png,3,**"), "line 5: .*no name of a room"),
        (lambda folder: rewrite(folder, ",0.1\nc3.png", ",inf\nc3.png"), "line 4: .*headings are rad"),
        (lambda folder: cv2.imwrite(str(folder / "c3.png"), np.zeros((90, 96, 3))), "c3.png is no crop of"),
        (lambda folder: (folder / "boxes.csv").write_bytes(b"\xff\xfe"), "boxes.csv cannot be read: .*utf-8"),
        (lambda folder: rewrite(folder, "c3.png", "c" * 200_000), "boxes.csv cannot be read: field larger"),
        (lambda folder: (folder / "boxes.csv").unlink(), "no pictures to learn from"),
    ],
)
def test_folders_that_cannot_be_learnt_from_are_refused(folder, spoil, cause):
    spoil(folder)
    with pytest.raises(InputError, match=cause):
        read_folder(folder)


def test_a_picture_without_people_is_of_one_room_although_names_of_two_begin_alike(folder):
    rewrite(folder, ",a,", ",hall1,")
    rewrite(folder, ",b,", ",hall10,")
    for name, shade in (("hall1_0", 1), ("hall10_0", 10), ("hall100", 10)):
        cv2.imwrite(str(folder / f"neg_{name}.png"), np.full((150, 170, 3), shade, np.uint8))
    found = [(one.place, int(one.pixels.max())) for one in read_folder(folder).backgrounds]
    assert found == [("hall1", 1), ("hall10", 10), ("hall10", 10)]


def rewrite(folder, old, new):
    file = folder / "boxes.csv"
    file.write_text(file.read_text().replace(old, new))


def test_too_few_bodies_and_a_wrong_name_are_told_at_once(folder, capsys):
    rewrite(folder, ",3,", ",2,")
    assert main(["train", "hog", str(folder), "-o", str(folder / "weights.txt")]) == 2
    told = capsys.readouterr().err
    assert "3 numbered bodies" in told
    assert "name a file .npz" in told
