"""`followspot train headings`: directions of strangers, by a network that leaves the scores as they are."""

import json
from dataclasses import replace

import cv2
import numpy as np
import pytest

from followspot.cli.main import main
from followspot_persons.hog.cells import CELL_FEATURES, cell_features
from followspot_persons.hog.model import DIRECTIONS, HEADINGS, SHIPPED, classify, load
from followspot_persons.hog.network import Network, outputs
from followspot_persons.hog.window import HEIGHT, WIDTH
from followspot_train import headings, network, tones

RNG = np.random.default_rng(0)


def figure(towards):
    """A crop of a body whose face, and the buttons of whose shirt, are where it looks."""
    pixels = RNG.integers(90, 130, (112, 96, 3), np.uint8)
    cv2.ellipse(pixels, (48, 34), (9, 12), 0, 0, 360, (30, 30, 30), -1)
    cv2.rectangle(pixels, (28, 46), (68, 100), (60, 120, 60), -1)
    if np.cos(towards) > -0.3:
        aside = int(9 * np.sin(towards))
        cv2.circle(pixels, (48 + aside, 36), 6, (120, 150, 200), -1)
        cv2.line(pixels, (48 + 2 * aside, 48), (48 + 2 * aside, 98), (255, 255, 255), 7)
    return pixels


@pytest.fixture
def folder(tmp_path):
    """Four bodies in two rooms, and no background, which headings do not need."""
    rows = ["file,body,room,torso_heading,head_pan"]
    for number in range(64):
        towards = 2 * np.pi * (number // 4) / 16 - np.pi
        cv2.imwrite(str(tmp_path / f"c{number}.png"), figure(towards))
        rows.append(f"c{number}.png,{number % 4},{'ab'[number // 4 % 2]},{towards:.4f},0.0")
    (tmp_path / "boxes.csv").write_text("\n".join(rows))
    return tmp_path


@pytest.fixture
def quick(monkeypatch):
    for name, value in (("WINDOWS", 8), ("UNITS", 16), ("MEMBERS", 2)):
        monkeypatch.setattr(headings, name, value)


def test_directions_of_strangers_are_predicted_and_scores_stay(folder, quick, capsys, monkeypatch):
    out = folder / "weights.npz"
    assert main(["train", "headings", str(folder), "-o", str(out), "--json"]) == 0
    report = json.loads(capsys.readouterr().out)[str(folder)]
    assert report["persons"] == 32  # each fold tries one body in one room of the two
    assert report["torso"]["within_45"] > 0.5
    assert report["head"]["within_45"] > 0.5
    learnt, before = load(out), load(SHIPPED)
    assert learnt.heading_hidden.shape == (CELL_FEATURES, 32)
    window = RNG.integers(0, 256, (3, HEIGHT, WIDTH, 3), np.uint8)
    np.testing.assert_array_equal(classify(learnt, window).score, classify(before, window).score)
    assert not np.allclose(classify(learnt, window).torso, classify(before, window).torso)
    for name, value in (("WINDOWS", 4), ("MEMBERS", 1)):
        monkeypatch.setattr(headings, name, value)
    above = str(folder / "above.npz")
    assert main(["train", "headings", str(folder), "-o", above, "--above"]) == 0
    assert "direction of the head: median" in capsys.readouterr().out


def test_a_network_of_headings_tells_directions_and_without_one_that_of_the_scores_does():
    model, window = load(SHIPPED), RNG.integers(0, 256, (3, HEIGHT, WIDTH, 3), np.uint8)
    always = replace(model, **HEADINGS | {"heading_hidden": np.zeros((CELL_FEATURES, 1), np.float32)})
    always = replace(
        always,
        heading_hidden_bias=np.ones(1, np.float32),
        heading_output=20 * np.eye(1, 2 * DIRECTIONS, DIRECTIONS + 5, dtype=np.float32),
    )
    assert (classify(always, window).head.argmax(axis=1) == 5).all()
    alone = classify(replace(model, **HEADINGS), window)
    said = outputs(model.network, cell_features(window))[:, 1:]
    np.testing.assert_array_equal(alone.torso.argmax(axis=1), said[:, :DIRECTIONS].argmax(axis=1))
    np.testing.assert_array_equal(alone.score, classify(always, window).score)


def test_the_mean_of_networks_says_what_they_say_at_the_mean():
    def one(units):
        shapes = (CELL_FEATURES, units), (units,), (units, 1 + 2 * DIRECTIONS), (1 + 2 * DIRECTIONS,)
        return Network(*(RNG.normal(size=shape) for shape in shapes))

    members, inputs = [one(3), one(5)], RNG.normal(size=(4, CELL_FEATURES))
    apart = np.mean([outputs(member, inputs)[:, 1:] for member in members], axis=0)
    np.testing.assert_allclose(outputs(headings.mean(members), inputs), apart)


def test_the_folder_where_a_network_errs_most_says_how_far_it_is_trusted():
    def predictions(mistaken):
        true = RNG.uniform(-np.pi, np.pi, 2000)
        seen = np.where(RNG.random(2000) < mistaken, RNG.uniform(-np.pi, np.pi, 2000), true)
        logits = np.log(network.directions(seen) + 1e-9)
        return headings.Predictions(logits, logits, np.arange(2000), true, true)

    model, layers = load(SHIPPED), Network(*HEADINGS.values())
    hard, both = [predictions(0.15)], [predictions(0.01), predictions(0.15)]
    alone, together = (headings.with_headings(model, layers, tried).trust for tried in (hard, both))
    assert together[0, 1] >= 0.12
    np.testing.assert_allclose(alone, together, atol=0.05)


def test_hair_gets_another_tone_and_the_body_below_does_not():
    window = np.full((HEIGHT, WIDTH, 3), (170, 90, 40), np.uint8)  # nothing like skin
    cv2.ellipse(window, (32, 18), (9, 12), 0, 0, 360, (60, 30, 15), -1)
    other = [tones.recoloured(window, RNG) for _ in range(200)]
    hair = np.array([pixels[18, 32].mean() for pixels in other])
    assert 0.05 < np.mean(hair == 35) < 0.3
    assert hair.min() < 30
    assert hair.max() > 100
    assert all(np.array_equal(pixels[45:], window[45:]) for pixels in other)


def test_skin_gets_another_brightness():
    window = np.full((HEIGHT, WIDTH, 3), 120, np.uint8)
    window[60:] = (110, 135, 190)
    skin = np.array([tones.recoloured(window, RNG)[70, 32, 2] for _ in range(200)])
    assert skin.min() < 130
    assert skin.max() > 210


def test_people_without_headings_do_not_count(folder, tmp_path, capsys):
    for part in ("pos", "neg"):
        (tmp_path / "streets" / part).mkdir(parents=True)
        cv2.imwrite(str(tmp_path / "streets" / part / "a.png"), RNG.integers(0, 256, (160, 96, 3), np.uint8))
    out = tmp_path / "weights.npz"
    assert main(["train", "headings", str(tmp_path / "streets"), "-o", str(out)]) == 2
    assert "0 bodies with headings in 0 rooms" in capsys.readouterr().err
    assert main(["train", "headings", str(folder), "-o", str(tmp_path / "weights.txt")]) == 2
    assert "name a file .npz" in capsys.readouterr().err
