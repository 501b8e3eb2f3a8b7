"""`tools/render_crops.py`: people of whom nothing but the seed is needed, to train the detector with."""

import sys

import numpy as np
import pytest

import render_crops
from followspot_persons.hog.model import DIRECTIONS, classify, load
from followspot_persons.hog.window import cut
from followspot_train.pictures import read_folder


def test_crops_show_upper_bodies_and_their_headings(tmp_path, monkeypatch, capsys):
    words = ["--seeds", "9000", "9002", "--pictures", "2", "-o", str(tmp_path)]
    monkeypatch.setattr(sys, "argv", ["render_crops.py", *words])
    render_crops.main()
    pictures = read_folder(tmp_path)
    assert capsys.readouterr().out == f"{len(pictures.persons)} crops in {tmp_path}\n"
    assert len(pictures.persons) >= 4
    assert len(pictures.backgrounds) == 2
    found = classify(load(), [cut(person.pixels, person.box) for person in pictures.persons])
    assert np.median(found.score) > 0
    towards = 2 * np.pi * found.torso.argmax(axis=1) / DIRECTIONS
    off = np.angle(np.exp(1j * (towards - [person.torso for person in pictures.persons])))
    assert np.abs(off).mean() == pytest.approx(0, abs=np.pi / 4)
