"""Rooms with covered balls, and what counts as within reach, beyond it, and as a switch."""

from __future__ import annotations

import numpy as np

from bench.balls.covered_rooms import counted, summary
from benching.random_rooms import random_room
from followspot_accuracy import TrackTable, TruthTable

TIME = np.arange(10) / 10


def truth() -> TruthTable:
    """Two targets 1 m apart; the first is half covered in the first four frames and not trackable last."""
    xyz = np.zeros((10, 2, 3))
    xyz[:, 1, 0] = 1.0
    flags = np.ones((10, 2), bool)
    trackable, pair = flags.copy(), flags.copy()
    trackable[9, 0], pair[:4, 0] = False, False
    return TruthTable(("red", "blue"), TIME, xyz, ~flags, trackable, pair)


def test_frames_are_counted_by_their_errors_and_by_what_the_track_states() -> None:
    off = np.array([0.02, 0.2, 0.02, 0.02, 1.0, 1.0, 0.02, 0.02, 0.02, 0.02])
    xyz = np.column_stack([off, np.zeros((10, 2))])
    tracks = TrackTable(
        ("red",), TIME, np.zeros(10, int), np.zeros(10, np.uint8), xyz, sigma=np.full((10, 3), 0.02)
    )
    red = [one for one in counted(tracks, truth(), 5, "balls.bundle") if one.target == "red"]
    every, covered = red
    assert (every.frames, every.within, every.beyond, every.switches) == (9, 6, 3, 1)
    assert (every.rated, every.inside) == (9, 6)
    assert (covered.situation, covered.frames, covered.within, covered.beyond) == ("half covered", 4, 3, 1)
    rows = {(row[0], row[1]): row[2:] for row in summary(red)}
    assert rows["balls.bundle", "all"][:3] == ["9", "66.67%", "33.33%"]


def test_rooms_with_covered_balls_have_five_cameras_or_more() -> None:
    for seed in range(20):
        room = random_room(seed, 60, covered=True)
        assert 5 <= len(room.cameras) <= 8
        assert 2 <= len(room.targets) <= 6
        assert room.truth is not None
        assert all(one.source and one.source.params == room.truth.params for one in room.cameras.values())
        assert room.truth.params["cover_balls"]
