"""A ball that lies on the floor where its track expects it is no projection, though it fits the floor."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.plugins.balls.scene import RADIUS, blobs_of, forecast_at, make_room
from tests.plugins.balls.seen_points import undistorted

from followspot.context import Context
from followspot.messages import Array
from followspot.tracking import LOST, MISSING, PREDICTED, TRACKED, Forecast, Pairs
from followspot_balls.pairs.lying_targets import LyingTargets
from followspot_balls.verify_pairs import VerifyPairs

ROOM = make_room()
SPOT = (0.3, -0.2, RADIUS)
"""The centre of a ball on the floor; at this tolerance its pair fits the floor."""
FAR = (1.5, 1.5, 1.0)
TOLERANCE = 6.0


def paired(forecast: Forecast | None, targets: list[bool], clearance: float = 0.03) -> Pairs:
    """Pairs of both colour cameras that see light there; the infrared cameras see something elsewhere."""
    light = [
        blobs_of(c, [SPOT if c.kind == "color" else FAR], [targets if c.kind == "color" else [False, True]])
        for c in ROOM.cameras.values()
    ]
    stage = VerifyPairs(Context(room=ROOM), homography_tolerance=TOLERANCE, resting_clearance=clearance)
    stage.setup()
    return stage.process(tuple(light), forecast)


def of_colors(pairs: Pairs) -> Array:
    """Pairs of the two colour cameras, cam0 and cam2."""
    return np.asarray((pairs.view == [0, 2]).all(axis=1))


def expected(status: int, place: tuple[float, float, float]) -> Forecast:
    """The first target with a status at a place."""
    return replace(forecast_at([place, FAR]), state=np.array([status, TRACKED], np.uint8))


def test_light_on_the_floor_is_a_projection_without_a_track() -> None:
    assert not of_colors(paired(None, [True, False])).any()


@pytest.mark.parametrize("status", [TRACKED, PREDICTED, MISSING])
def test_light_where_a_ball_lies_that_is_not_lost_is_kept_and_proves_nothing(status: int) -> None:
    pairs = paired(expected(status, SPOT), [True, False])
    kept = of_colors(pairs)
    assert kept.sum() == 1
    assert not pairs.confirmed[kept].any()
    assert not pairs.evident[kept].any()


def test_without_clearance_only_infrared_light_excuses_a_ball() -> None:
    assert not of_colors(paired(expected(TRACKED, SPOT), [True, False], clearance=0.0)).any()


@pytest.mark.parametrize(
    ("status", "place", "targets"),
    [
        (LOST, SPOT, [True, False]),
        (TRACKED, (SPOT[0] + 0.2, SPOT[1], RADIUS), [True, False]),
        (TRACKED, (SPOT[0], SPOT[1], RADIUS + 0.05), [True, False]),
        (TRACKED, SPOT, [False, True]),
    ],
    ids=["lost", "elsewhere", "above the floor", "of another colour"],
)
def test_other_light_on_the_floor_stays_a_projection(
    status: int, place: tuple[float, float, float], targets: list[bool]
) -> None:
    assert not of_colors(paired(expected(status, place), targets)).any()


def test_both_blobs_of_a_pair_must_be_where_the_ball_is() -> None:
    ends = np.array([undistorted(np.array(SPOT))[[0, 2]]] * 3)
    ends[1, 0] += 20.0
    ends[2, 1] += 20.0
    cameras, targets = np.array([[0, 2]] * 3), np.array([[True, False]] * 3)
    shown = LyingTargets(ROOM, 0.03).shown(ends, cameras, targets, expected(TRACKED, SPOT))
    assert shown.tolist() == [True, False, False]
