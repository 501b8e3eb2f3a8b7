"""`followspot train whole`: legs are learnt from pictures that have room for them."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from followspot import InputError
from followspot.cli.main import main
from followspot_persons.hog import whole_model
from followspot_persons.hog.model import SHIPPED
from followspot_persons.hog.model import load as load_hog
from followspot_persons.hog.model import save as save_hog
from followspot_persons.hog.trees import Trees
from followspot_persons.hog.whole import within
from followspot_persons.hog.whole_model import INPUTS, LAYOUT, WholeModel, load, whole_log_odds
from followspot_persons.hog.window import BODY, FEATURES, cut
from followspot_train import boosting, linear, network, whole
from followspot_train.pictures import PEDESTRIAN, Background, Person

EVERYWHERE = np.append(np.zeros(FEATURES, np.float32), np.float32(1))
"""Weights that propose each window."""


def standing(rng, legs):
    """A crop of the INRIA form: head and torso on noise, and two legs."""
    pixels = rng.integers(90, 110, (160, 96, 3), np.uint8)
    cv2.circle(pixels, (48, 36), 6, (150, 170, 200), -1)
    cv2.rectangle(pixels, (38, 44), (58, 74), (40, 40, 160), -1)
    if legs:
        for column in (42, 54):
            cv2.rectangle(pixels, (column - 3, 74), (column + 3, 130), (20, 20, 20), -1)
    return pixels


def people(rng, legs, count):
    return [Person(standing(rng, legs), PEDESTRIAN, -1, f"street{i % 4}") for i in range(count)]


@pytest.fixture
def quick(monkeypatch):
    monkeypatch.setattr(boosting, "TREES", 60)
    monkeypatch.setattr(whole, "EACH", 100)


def said(model, persons):
    return whole_log_odds(model, [cut(p.pixels, p.box, layout=LAYOUT) for p in persons])


def test_strangers_with_legs_are_told_from_those_without_by_the_network_and_by_the_trees(quick, monkeypatch):
    """The trees' log-odds are those of even chances, so that 0 parts them; the network saw few windows."""
    rng = np.random.default_rng(0)
    without = [Background(np.tile(standing(rng, False), (2, 3, 1)), "street0") for _ in range(3)]
    model = whole.learn(people(rng, True, 12), without, EVERYWHERE, rng, lambda _: None)
    with_legs, legless = people(rng, True, 10), people(rng, False, 10)
    monkeypatch.setattr(whole_model, "TREES", 1.0)
    assert said(model, with_legs).min() > 0 > said(model, legless).max()
    monkeypatch.setattr(whole_model, "TREES", 0.0)
    assert said(model, with_legs).min() > said(model, legless).max()


@pytest.mark.thorough
def test_odds_do_not_depend_on_how_many_backgrounds_are_learnt_from(quick, monkeypatch):
    """Nothing can be told of pictures that are alike, so that chances are even."""
    grey = np.full((160, 96, 3), 100, np.uint8)
    monkeypatch.setattr(whole, "relit", lambda window, _: window)
    for count in (1, 5):
        rng = np.random.default_rng(0)
        persons = [Person(grey, PEDESTRIAN, -1, "street0") for _ in range(4)]
        places = [Background(np.tile(grey, (2, 3, 1)), "street0") for _ in range(count)]
        model = whole.learn(persons, places, EVERYWHERE, rng, lambda _: None)
        assert said(model, persons) == pytest.approx(0, abs=0.05)


def test_crops_without_room_for_legs_are_left_out():
    upper = Person(np.zeros((112, 96, 3), np.uint8), np.array([24.0, 22, 72, 94]), 1, "room")
    [kept] = whole.whole([upper, *people(np.random.default_rng(0), True, 1)])
    assert kept.pixels.shape == (160, 96, 3)


def test_places_are_boxes_in_the_picture_for_each_window():
    pixels = np.random.default_rng(0).integers(0, 256, (200, 260, 3), np.uint8)
    box = linear.places(pixels, EVERYWHERE)
    assert len(box) == linear.searched(pixels)
    tall = box[:, 3] - box[:, 1]
    assert tall.min() == pytest.approx((BODY[3] - BODY[1]) / linear.SIZES[1], rel=0.01)
    assert (box[:, :2] > 0).all()
    assert (box[:, 2:] < [260, 200]).all()
    assert within(box, pixels.shape).any()


def test_the_command_writes_weights_and_refuses_pictures_without_legs(quick, tmp_path, capsys):
    rng, folder = np.random.default_rng(0), tmp_path / "streets"
    for part in ("pos", "neg"):
        (folder / part).mkdir(parents=True)
    for number in range(6):
        cv2.imwrite(str(folder / "pos" / f"{number}.png"), standing(rng, True))
        cv2.imwrite(str(folder / "neg" / f"{number}.png"), rng.integers(0, 256, (200, 260, 3), np.uint8))
    hog, out = tmp_path / "hog.npz", tmp_path / "whole.npz"
    save_hog(replace(load_hog(SHIPPED), linear=EVERYWHERE), hog)
    words = ["train", "whole", str(folder), "--weights", str(hog), "-o"]
    assert main([*words, str(out)]) == 0
    assert str(out) in capsys.readouterr().out
    written = load(out)
    assert isinstance(written, WholeModel)
    assert len(written.trees.leaf) == 60
    assert written.network.hidden.shape == (INPUTS, network.UNITS)
    assert main([*words, str(tmp_path / "whole.txt")]) == 2
    assert "name a file .npz" in capsys.readouterr().err
    with pytest.raises(InputError, match="whole people"):
        whole.learn([], [], EVERYWHERE, rng, lambda _: None)


def test_arms_and_legs_are_learnt_as_no_person(quick, monkeypatch):
    """Of crops without room for legs as well."""
    rng, learnt = np.random.default_rng(0), []

    def kept(features, person, rng, report_progress):
        learnt.append(len(person) - int(person.sum()))
        return Trees(np.zeros((1, 3), np.intp), np.zeros((1, 3)), np.zeros((1, 4)))

    monkeypatch.setattr(boosting, "train", kept)
    upper = Person(np.zeros((112, 96, 3), np.uint8), np.array([24.0, 22, 72, 94]), 1, "room")
    places = [Background(standing(rng, False), "street0")]
    for parts in (0, 40):
        monkeypatch.setattr(whole, "PARTS", parts)
        whole.learn(
            [upper, *people(rng, True, 1)], places, EVERYWHERE, np.random.default_rng(0), lambda _: None
        )
    assert 40 < learnt[1] - learnt[0] <= 80
