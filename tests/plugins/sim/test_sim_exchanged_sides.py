"""A simulated network exchanges left and right of people for some time, of those seen from behind more."""

from __future__ import annotations

import numpy as np
import pytest

from followspot import Camera, Context, Room
from followspot.room import Member
from followspot_sim.actor.exchanged_sides import Exchanges
from followspot_sim.actor.landmarks import NAMES
from followspot_sim.actor.points import PersonPoints

ALONG_X = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])
MIRROR = [NAMES.index(f"{'right' if n[0] == 'l' else 'left'}_{n.split('_')[1]}") for n in NAMES[1:]]
FPS, SHARE, DURATION = 25, 0.2, 0.6


def found(exchange_share: float) -> np.ndarray:
    """Pixels of the joints of one person that walks and turns, (F, 17, 2), NaN for joints not found."""
    matrix = np.array([[700.0, 0, 640], [0, 700.0, 480], [0, 0, 1]])
    camera = Camera("cam", "color", (1280, 960), matrix, np.zeros(5), ALONG_X, -ALONG_X @ [-3.0, 0, 1.2])
    params = {"people": 1, "seed": 4, "frames": 300, "fps": FPS, "person_miss": 0, "clutter": 0}
    context = Context("points", Room("sim", {"cam": camera}), Member("cameras", "cam"))
    stage = PersonPoints(context, **params, exchange_share=exchange_share, exchange_time=DURATION)
    stage.setup()
    pixel = np.full((300, 17, 2), np.nan)
    for frame, each in enumerate(stage.process()):
        pixel[frame, each.points.label] = each.points.pixel
    return pixel


def test_exchanged_joints_are_those_of_the_other_side() -> None:
    right, wrong = found(0.0), found(SHARE)
    other = right[:, [0, *MIRROR]]
    same = (np.equal(wrong, right) | np.isnan(wrong) & np.isnan(right)).all(axis=-1)
    exchanged = (np.equal(wrong, other) | np.isnan(wrong) & np.isnan(other)).all(axis=-1)
    assert (same | exchanged).all()
    assert same[:, 0].all()  # the nose has no side
    pictures = np.flatnonzero(~same.all(axis=1))
    assert 0 < len(pictures) < 0.5 * len(right)
    lengths = [len(run) for run in np.split(pictures, np.flatnonzero(np.diff(pictures) > 1) + 1)]
    assert np.median(lengths) >= 0.9 * DURATION * FPS


@pytest.mark.parametrize(("cosine", "factor"), [(1.0, 0.1), (0.0, 1.0), (-1.0, 1.9)])
def test_sides_are_exchanged_more_from_behind(cosine: float, factor: float) -> None:
    exchanges = Exchanges(SHARE, DURATION, (1, 2))
    names = [exchanges.names(k * DURATION, np.full(4, cosine)) for k in range(1000)]
    share = np.mean([(one != np.arange(len(NAMES))).any(axis=1) for one in names])
    assert share == pytest.approx(SHARE * factor, abs=0.02)
