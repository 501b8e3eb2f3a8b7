"""`followspot train hog`: what the command reads, writes and refuses."""

import json

import cv2
import numpy as np
import pytest

from followspot import InputError
from followspot.cli.main import main
from followspot_persons.hog.model import (
    load,
)
from followspot_persons.hog.window import ABOVE
from followspot_train import boosting, linear, network, recipe, windows
from followspot_train.pictures import Person, read_folder

RNG = np.random.default_rng(0)


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
