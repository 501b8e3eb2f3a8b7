"""How exact the sightings of a target in its clips are said to be."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
from tests.tools.calibrate.ball_clips import FRAMES, TRUE, write_clips

from followspot.messages import Array
from followspot_calibrate.target_sightings import find_target_sightings

Direction = Callable[[np.random.Generator], float]
"""Angle in the picture, rad."""


def sigma(clips: Path) -> Array:
    """Of the sightings of each moment, px."""
    found = find_target_sightings(clips, TRUE)
    assert len(found.sigma) == FRAMES
    return found.sigma


def with_dim_light(clips: Path, direction: Direction) -> Path:
    """The clips with a dim spot at the edge of the ball in each picture."""
    rng = np.random.default_rng(3)
    for path in sorted(clips.rglob("*.png")):
        picture = cv2.imread(str(path))
        rows, columns = np.nonzero(picture[..., 1])
        radius, angle = np.sqrt(len(rows) / np.pi), direction(rng)
        spot = np.zeros_like(picture)
        place = np.array([columns.mean(), rows.mean()]) + radius * np.array([np.cos(angle), np.sin(angle)])
        cv2.circle(spot, np.rint(place).astype(int).tolist(), round(0.4 * radius), (0, 100, 0), -1)
        cv2.imwrite(str(path), np.maximum(picture, spot))
    return clips


@pytest.mark.parametrize(
    ("direction", "counts"),
    [(lambda rng: rng.uniform(0, 2 * np.pi), False), (lambda rng: 0.5, True)],
    ids=["another side each time", "one side"],
)
def test_light_beside_a_target_counts_if_it_is_on_one_side_in_all_pictures(
    tmp_path: Path, direction: Direction, counts: bool
) -> None:
    plain = sigma(write_clips(tmp_path / "plain"))
    other = sigma(with_dim_light(write_clips(tmp_path / "other"), direction))
    assert (other > 1.3 * plain).all() if counts else other == pytest.approx(plain, rel=0.05)
