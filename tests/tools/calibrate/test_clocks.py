"""`calibrate clocks`: offsets from the motion of targets, on drawn sightings whose clocks are known."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from followspot import Room, room_file
from followspot.errors import FollowspotError
from followspot.geometry import project
from followspot.messages import Array
from followspot.tracking import MISSING, TRACKED
from followspot_accuracy import TrackTable
from followspot_calibrate.clocks.command import check, with_offsets
from followspot_calibrate.clocks.estimation import Offsets, estimated
from followspot_calibrate.clocks.moments import moments, velocities
from followspot_calibrate.tracked import BlobTable, Tracked, moments_at

ROOM = room_file.load(Path(__file__).parents[3] / "graphs/rooms/simulated.yaml")
P = np.array([c.projection for c in ROOM.cameras.values()])
TRUE = np.array([0.011, -0.014, 0.004, 0.013, -0.009, -0.005])
FPS = 60.0
NOISE = 0.25
"""Of a centroid, px."""


def swinging(time: Array, target: int) -> Array:
    """A ball on a figure of eight in the middle of the room: (N,) s -> (N, 3) m."""
    phase = 2.1 * time + target
    return np.column_stack([np.cos(phase), 0.8 * np.sin(2 * phase), 1.2 + 0.4 * np.sin(phase + target)])


def filmed(
    rng: np.random.Generator,
    *,
    offset: Array = TRUE,
    frames: int = 240,
    speed: float = 1.0,
    late: Array | None = None,
    hidden: float = 0.0,
) -> Tracked:
    """Tracks and blobs of two balls; a fifth of the blobs is missing, a twentieth is wrong.

    late: (C,) s, by which the cameras' honest time stamps are later; hidden: px, by which a ball that is
    half hidden seems to be elsewhere for a second.
    """
    stamps = np.zeros(len(offset)) if late is None else late
    time = np.arange(frames) / FPS + 1.0
    tracks, blobs = [], []
    for target in (0, 1):
        place = swinging(speed * time, target)
        tracks.append((time, np.full(frames, target), place + rng.normal(0, 0.004, place.shape)))
        for number, camera in enumerate(ROOM.cameras.values()):
            seen = swinging(speed * (time + stamps[number] + offset[number]), target)
            pixel = project(camera, seen) + rng.normal(0, NOISE, (frames, 2))
            if hidden:
                pixel += rng.normal(0, hidden, (frames, 2))[time.astype(int)]
            wrong = rng.random(frames) < 0.05
            pixel[wrong] += rng.normal(0, 5, (int(wrong.sum()), 2))
            kept = rng.random(frames) > 0.2
            rows = int(kept.sum())
            columns = (np.full(rows, number), np.full(rows, target))
            blobs.append((time[kept] + stamps[number], *columns, pixel[kept]))
    t, k, xyz = (np.concatenate(column) for column in zip(*tracks, strict=True))
    table = TrackTable(tuple(ROOM.targets), t, k, np.full(len(t), TRACKED, "u1"), xyz)
    return Tracked(table, BlobTable(*(np.concatenate(column) for column in zip(*blobs, strict=True))))


def found(tracked: Tracked, start: Array | None = None) -> Offsets:
    begin = np.zeros(len(P)) if start is None else start
    return estimated(moments(tracked, ROOM, begin), P, begin)


@pytest.fixture(scope="module")
def rng() -> np.random.Generator:
    return np.random.default_rng(5)


def test_offsets_are_found_though_places_and_offsets_are_unknown_together(rng: np.random.Generator) -> None:
    result = found(filmed(rng))
    # 400 sightings a camera of 0.25 px at about 100 px/s: 0.15 ms
    assert result.offset == pytest.approx(TRUE, abs=6e-4)
    assert (result.sigma < 4e-4).all()
    assert (result.sightings > 200).all()


@pytest.mark.parametrize(
    ("frames", "hidden"), [(120, 0.0), pytest.param(300, 0.5, marks=pytest.mark.thorough)]
)
def test_the_stated_deviation_is_that_of_the_errors(frames: int, hidden: float) -> None:
    errors = []
    for seed in range(12):
        result = found(filmed(np.random.default_rng(seed), frames=frames, hidden=hidden))
        errors.append((result.offset - TRUE) / result.sigma)
    assert 0.6 < np.sqrt(np.mean(np.square(errors))) < 1.7


def test_a_start_near_the_truth_changes_nothing(rng: np.random.Generator) -> None:
    tracked = filmed(rng)
    cold = found(tracked)
    assert found(tracked, cold.offset).offset == pytest.approx(cold.offset, abs=1e-4)


@settings(max_examples=10, deadline=None)
@given(st.lists(st.floats(-0.015, 0.015), min_size=6, max_size=6), st.integers(0, 1000))
def test_any_offsets_are_found_but_for_what_all_share(offsets: list[float], seed: int) -> None:
    true = np.array(offsets)
    result = found(filmed(np.random.default_rng(seed), offset=true, frames=150))
    assert result.offset.sum() == pytest.approx(0.0, abs=1e-9)
    assert result.offset == pytest.approx(true - true.mean(), abs=1.5e-3)


def test_honest_time_stamps_are_no_clock_offsets(rng: np.random.Generator) -> None:
    late = np.array([0.0, 0.002, 0.006, 0.001, 0.0, 0.007])
    result = found(filmed(rng, offset=np.zeros(6), late=late))
    assert result.offset == pytest.approx(np.zeros(6), abs=6e-4)


def test_one_camera_can_be_the_reference(rng: np.random.Generator) -> None:
    result = found(filmed(rng))
    relative = result.relative_to(2)
    assert relative.offset == pytest.approx(result.offset - result.offset[2])
    assert relative.sigma[2] == pytest.approx(0.0, abs=1e-12)
    assert relative.sigma[0] ** 2 == pytest.approx(
        result.covariance[0, 0] + result.covariance[2, 2] - 2 * result.covariance[0, 2]
    )


def test_targets_at_rest_are_refused_by_the_name_of_every_camera(rng: np.random.Generator) -> None:
    with pytest.raises(FollowspotError, match=r"cam0: \d sightings of moving targets") as caught:
        check(ROOM, found(filmed(rng, speed=0.0)), 2e-3)
    assert len(str(caught.value).splitlines()) == len(P)


def test_a_run_that_tracked_nothing_is_refused_like_one_without_motion() -> None:
    nothing = np.zeros(0)
    table = TrackTable(
        tuple(ROOM.targets), nothing, nothing.astype(int), nothing.astype("u1"), np.zeros((0, 3))
    )
    blobs = BlobTable(nothing, nothing.astype(int), nothing.astype(int), np.zeros((0, 2)))
    with pytest.raises(FollowspotError, match="cam5: 0 sightings"):
        check(ROOM, found(Tracked(table, blobs)), 2e-3)


def test_a_camera_that_saw_too_little_is_named(rng: np.random.Generator) -> None:
    tracked = filmed(rng)
    blobs = tracked.blobs
    kept = (blobs.camera != 3) | (np.arange(len(blobs.time)) % 40 == 0)
    few = BlobTable(blobs.time[kept], blobs.camera[kept], blobs.target[kept], blobs.pixel[kept])
    with pytest.raises(FollowspotError, match="cam3") as caught:
        check(ROOM, found(Tracked(tracked.tracks, few)), 2e-3)
    assert len(str(caught.value).splitlines()) == 1


def test_cameras_that_never_share_a_target_are_refused(rng: np.random.Generator) -> None:
    tracked = filmed(rng)
    blobs = tracked.blobs
    kept = blobs.target == (blobs.camera < 3)
    parted = BlobTable(blobs.time[kept], blobs.camera[kept], blobs.target[kept], blobs.pixel[kept])
    with pytest.raises(FollowspotError, match="ms only, 2 wanted"):
        check(ROOM, found(Tracked(tracked.tracks, parted)), 2e-3)


def test_a_blob_belongs_to_the_moment_that_its_message_was_joined_to() -> None:
    time, target = np.array([1.0, 1.1, 1.2, 1.0, 1.1]), np.array([0, 0, 0, 1, 1])
    blob = np.array([1.0, 1.04, 1.06, 1.1, 1.24, 0.99, 1.04, 1.11, 1.2])
    of = np.array([0, 0, 0, 0, 0, 0, 1, 1, 2])
    blobs = BlobTable(blob, np.zeros(9, int), of, np.zeros((9, 2)))
    assert moments_at(time, target, blobs).tolist() == [0, 0, -1, 1, 2, -1, 3, 4, -1]


def test_velocities_are_slopes_and_stop_at_gaps() -> None:
    time = np.array([0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.9, 1.0, 0.0, 0.1])
    target = np.array([0] * 8 + [1] * 2)
    found = velocities(time, target, np.outer(time, [1.0, -2.0, 0.5]))
    assert np.isfinite(found[:, 0]).tolist() == [False, False, True, True] + [False] * 6
    assert found[2] == pytest.approx([1.0, -2.0, 0.5])


def test_only_measured_positions_are_moments(rng: np.random.Generator) -> None:
    tracked = filmed(rng, frames=20)
    state = tracked.tracks.state.copy()
    state[:5] = MISSING
    some = moments(Tracked(replace(tracked.tracks, state=state), tracked.blobs), ROOM, np.zeros(6))
    assert len(some.time) == 35


def test_a_room_keeps_everything_but_its_offsets() -> None:
    changed: Room = with_offsets(ROOM, TRUE)
    assert [c.clock_offset for c in changed.cameras.values()] == TRUE.tolist()
    assert changed.targets is ROOM.targets
