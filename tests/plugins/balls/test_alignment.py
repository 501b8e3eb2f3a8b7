"""Cameras that are not synchronised: their blobs are moved to the moment of the joined message."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.plugins.balls.scene import blobs_of, forecast_at, make_room

from followspot.context import Context
from followspot.geometry import project, undistort
from followspot.message_checks.sealing import seal
from followspot.messages import Array, Header, identical, stamped
from followspot.room import Room
from followspot.tracking import LOST, Blobs, Forecast, Pairs
from followspot_balls.pairs.time_alignment import delays
from followspot_balls.verify_pairs import VerifyPairs

ROOM = make_room()
MILLISECOND = 1_000_000
BALL, OTHER = np.array([0.1, 0.2, 1.0]), np.array([-0.3, 0.4, 1.2])
VELOCITY = np.array([[3.0, -1.0, 2.0], [-2.0, 0.5, 0.0]])
OFFSETS = {"cam0": 0.015, "cam1": -0.012, "cam2": 0.0, "cam3": 0.007}


def with_offsets(offsets: dict[str, float]) -> Room:
    cameras = {n: replace(c, clock_offset=offsets.get(n, 0.0)) for n, c in ROOM.cameras.items()}
    return replace(ROOM, cameras=cameras)


def moving(velocity: Array = VELOCITY) -> Forecast:
    """The forecast of both balls, exact."""
    return seal(replace(forecast_at([tuple(BALL), tuple(OTHER)]), velocity=velocity))


def seen(camera: str, offset: float, targets: list[list[bool]], milliseconds: int = 0) -> Blobs:
    """Exact blobs of the first balls, one for each row, `offset` seconds after the forecast's time."""
    places = (np.array([BALL, OTHER]) + VELOCITY * offset)[: len(targets)]
    blobs = blobs_of(ROOM.cameras[camera], [tuple(p) for p in places], targets)
    return stamped(blobs, Header(f"camera/{camera}", 0, milliseconds * MILLISECOND))


def verify(room: Room, blobs: list[Blobs], forecast: Forecast | None) -> Pairs:
    stage = VerifyPairs(Context(room=room))
    stage.setup()
    return stage.process(tuple(blobs), forecast)


def ideal(camera: str) -> Array:
    """Undistorted images of both balls at the forecast's time."""
    one = ROOM.cameras[camera]
    return undistort(one, project(one, np.array([BALL, OTHER])))


def assert_at_one_moment(pairs: Pairs) -> None:
    """Every pair shows the first ball where its cameras would have seen it together."""
    assert len(pairs.view) == 6
    for row, (first, second) in enumerate(pairs.view.tolist()):
        expected = [ideal(pairs.cameras[number])[0] for number in (first, second)]
        assert pairs.xy[row] == pytest.approx(np.array(expected), abs=0.02)


def test_blobs_seen_early_or_late_move_to_where_one_moment_shows_them() -> None:
    labels = [[True, False]]
    blobs = [seen(name, offset, labels) for name, offset in OFFSETS.items()]
    assert_at_one_moment(verify(with_offsets(OFFSETS), blobs, moving()))
    unmoved = verify(ROOM, blobs, moving())
    assert unmoved.epipolar.max(initial=0.0) > 0.5 or len(unmoved.view) < 6


def test_honest_time_stamps_are_heeded_without_any_clock_offset() -> None:
    labels = [[True, False]]
    late = {"cam0": 0, "cam1": 3, "cam2": 14, "cam3": 8}
    blobs = [seen(name, ms * 1e-3, labels, ms) for name, ms in late.items()]
    assert_at_one_moment(verify(ROOM, blobs, moving()))


def test_clock_offset_and_time_stamp_add_up() -> None:
    blobs = [seen("cam0", 0, [[True, False]], 5), seen("cam1", 0, [[True, True]], 9)]
    assert delays(blobs, np.array([0.015, -0.012])) == pytest.approx([0.015, -0.008])


@settings(max_examples=50, deadline=None)
@given(st.lists(st.floats(-1.0, 1.0), min_size=4, max_size=4))
def test_without_motion_nothing_moves_whatever_the_clocks_say(offsets: list[float]) -> None:
    blobs = [seen(name, 0.0, [[True, False], [False, True]]) for name in ROOM.cameras]
    still = moving(np.zeros((2, 3)))
    room = with_offsets(dict(zip(ROOM.cameras, offsets, strict=True)))
    assert identical(seal(verify(room, blobs, still)), seal(verify(ROOM, blobs, None)))


def test_an_infrared_blob_moves_with_the_nearest_of_its_targets() -> None:
    room = with_offsets({"cam1": 0.015, "cam3": 0.015})
    both = [[True, True], [True, True]]
    pairs = verify(room, [seen("cam1", 0.015, both), seen("cam3", 0.015, both)], moving())
    for row, (ball, same) in enumerate(pairs.blob.tolist()):
        assert pairs.xy[row, 0] == pytest.approx(ideal("cam1")[ball], abs=0.02)
        assert pairs.xy[row, 1] == pytest.approx(ideal("cam3")[same], abs=0.02)
    assert [b for b in pairs.blob.tolist() if b[0] == b[1]] == [[0, 0], [1, 1]]


def test_a_blob_moves_with_a_target_that_it_may_be_though_another_is_nearer() -> None:
    beside = seal(replace(forecast_at([tuple(BALL + 0.05), tuple(BALL)]), velocity=VELOCITY))
    room = with_offsets({"cam0": 0.015, "cam2": 0.015})
    blobs = [seen("cam0", 0.015, [[True, False]]), seen("cam2", 0.015, [[True, False]])]
    pairs = verify(room, blobs, beside)
    assert pairs.xy[0, 0] == pytest.approx(ideal("cam0")[0], abs=0.1)


@pytest.mark.parametrize("reason", ["lost", "far away", "no forecast yet", "first forecast"])
def test_a_blob_of_no_known_target_stays(reason: str) -> None:
    away = [tuple(BALL + 0.9), tuple(OTHER)]
    forecasts: dict[str, Forecast | None] = {
        "lost": seal(replace(moving(), state=np.full(2, LOST, np.uint8))),
        "far away": seal(replace(forecast_at(away), velocity=VELOCITY)),
        "no forecast yet": None,
        "first forecast": Forecast.empty(),
    }
    blobs = [seen(name, 0.0, [[True, False]]) for name in ROOM.cameras]
    stay = verify(ROOM, blobs, None)
    assert identical(verify(with_offsets(OFFSETS), blobs, forecasts[reason]), stay)


def test_a_target_behind_a_camera_moves_none_of_its_blobs() -> None:
    behind = ROOM.cameras["cam0"].center - ROOM.cameras["cam0"].rotation[2]
    forecast = seal(replace(forecast_at([tuple(behind), tuple(behind)]), velocity=VELOCITY))
    blobs = [seen(name, 0.0, [[True, False]]) for name in ("cam0", "cam2")]
    room = with_offsets({"cam0": 0.01})
    assert identical(verify(room, blobs, forecast), verify(ROOM, blobs, None))


def test_synchronised_cameras_are_left_alone_bit_for_bit() -> None:
    blobs = [seen(name, 0.0, [[True, False], [False, True]]) for name in ROOM.cameras]
    assert identical(verify(ROOM, blobs, moving()), verify(ROOM, blobs, None))
