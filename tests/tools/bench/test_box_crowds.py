"""The simulated boxes of people who hide each other, and the benchmark that measures with them."""

from __future__ import annotations

import json
import sys
from dataclasses import replace

import numpy as np
import pytest

from bench.persons import box_crowds
from benching.box_people import FALLING, NEVER, People, moved, people, surfaces
from benching.box_pictures import Network, network
from followspot.room_file import load

CAMERA = load(box_crowds.ROOM).cameras["south_west"]


def exact(count: int) -> Network:
    """A network without bias and false boxes."""
    return replace(network(CAMERA, count, 0.0, np.random.default_rng(1)), bias=np.zeros((count, 4)))


def standing(xy: list[tuple[float, float]]) -> People:
    crowd = people(len(xy), np.random.default_rng(1))
    return replace(crowd, xy=np.array(xy), arrives=np.zeros(len(xy)), stride=np.zeros(len(xy)))


def test_a_person_behind_another_is_hidden() -> None:
    corner = CAMERA.center[:2]
    ways = [tuple(corner * share) for share in (0.2, 0.3)]  # the second one stands nearer, in one line
    shares = {
        number: share
        for number, share, _ in exact(2).visible(surfaces(standing(ways)), np.random.default_rng(1))
    }
    assert shares[1] == 1.0
    assert shares[0] < 0.6


def test_a_box_encloses_the_body_in_the_picture() -> None:
    surface = surfaces(standing([(0.0, 0.0)]))
    ((_, share, box),) = exact(1).visible(surface, np.random.default_rng(1))
    image = (surface[0] @ CAMERA.rotation.T + CAMERA.translation) @ CAMERA.matrix.T
    uv = image[:, :2] / image[:, 2:]
    assert share == 1.0
    assert np.allclose(box, [*uv.min(axis=0), *uv.max(axis=0)])


def test_who_is_not_there_yet_has_no_box() -> None:
    crowd = people(3, np.random.default_rng(1))
    assert crowd.present.tolist() == [True, False, False]
    assert not len(exact(0).boxes(surfaces(crowd)[:0], np.zeros(0, bool), np.random.default_rng(1)).box)


def test_a_fall_ends_on_the_floor_and_the_person_gets_up_again() -> None:
    rng = np.random.default_rng(1)
    crowd = replace(standing([(0.0, 0.0)]), fell=np.zeros(1))
    for _ in range(round(FALLING / 0.05) + 2):
        crowd = moved(crowd, 0.05, (), rng)
    assert surfaces(crowd)[0, :, 2].max() < 0.6
    for _ in range(100):
        crowd = moved(crowd, 0.05, (), rng)
    assert crowd.fell[0] == NEVER
    assert surfaces(crowd)[0, :, 2].max() > 1.4


def test_the_figures_of_each_number_of_people_are_told(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["box_crowds.py", "--people", "1", "2", "--seeds", "1", "--frames", "12", "--json"]
    monkeypatch.setattr(sys, "argv", words)
    box_crowds.main()
    figures = json.loads(capsys.readouterr().out)
    assert set(figures) == {"1", "2"}
    assert all(one["mota"] > 0.5 and one["mean_m"] < 0.2 for one in figures.values())
