"""`balls.smooth`: the best estimate from all positions, in just the frames in which the tracker has one."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.plugins.balls.smoothed import PERIOD, ROOM, noisy, path, positions, smooth, tracks

from followspot.messages import Array, identical
from followspot.testing import check_stage
from followspot.tracking import PREDICTED, Tracks
from followspot_balls.smooth.stage import Smooth


def run(stage: Smooth, measured: Array, positioned: Iterable[int] | None = None) -> list[Tracks]:
    """All frames of target 0; positioned: the frames that have a position."""
    there = set(range(len(measured)) if positioned is None else positioned)
    found: list[Tracks] = []
    for frame, place in enumerate(measured):
        seen = (positions(frame, {0: place}),) if frame in there else ()
        found += stage.process(tracks(frame, {0: place}), seen)
    return found + list(stage.remaining())


def least_squares(measured: Array, sigma: float, there: Sequence[int]) -> tuple[Array, Array]:
    """Places (N, 3) and their variance (N,) of all measurements at once.

    The unknowns are the first place, the first velocity and the acceleration of each step.
    """
    count, T = len(measured), PERIOD * 1e-9
    number = np.arange(count)
    since = np.clip(number[:, None] - number[:-1] - 1, 0, None) * T
    pushed = np.where(number[:, None] > number[:-1], T * T / 2 + T * since, 0.0)
    A = np.column_stack([np.ones(count), number * T, pushed])
    prior = np.diag([0.0, 1 / 3.0**2, *[1 / 12.0**2] * (count - 1)])
    seen = A[there] / sigma
    covariance = np.linalg.inv(seen.T @ seen + prior)
    found = A @ covariance @ seen.T @ (measured[there] / sigma)
    return found, np.einsum("ij,jk,ik->i", A, covariance, A)


@pytest.mark.parametrize("lag", [0, 59])
def test_the_whole_recording_is_the_least_squares_solution(lag: int) -> None:
    measured, there = noisy(path(60)), [n for n in range(60) if n % 7 or n == 0]
    found = run(smooth(lag_frames=lag, bounce_gate=1e6), measured, there)
    expected, variance = least_squares(measured, 0.01, there)
    assert np.array([one.xyz[0] for one in found]) == pytest.approx(expected, abs=1e-6)
    assert np.array([one.sigma[0, 0] for one in found]) == pytest.approx(np.sqrt(variance), rel=1e-3)


def test_what_a_track_states_beyond_the_errors_of_its_positions_stays() -> None:
    """As of a track that may have left its target: no later position tells."""
    measured, doubtful = noisy(path(40)), range(20, 30)
    usual, wide = smooth(lag_frames=0), smooth(lag_frames=0)
    for frame, place in enumerate(measured):
        seen = (positions(frame, {0: place}),)
        usual.process(tracks(frame, {0: place}), seen)
        wide.process(tracks(frame, {0: place}, sigma=0.1 if frame in doubtful else 1e-3), seen)
    for frame, (one, other) in enumerate(zip(usual.remaining(), wide.remaining(), strict=True)):
        assert other.xyz.tobytes() == one.xyz.tobytes()
        if frame in doubtful:  # 1 cm is what positions are off, and so the most that the filter states
            assert 0.1**2 - 0.01**2 <= (other.sigma**2 - one.sigma**2).min() < 0.1**2
        else:
            assert other.sigma.tobytes() == one.sigma.tobytes()


def test_a_lag_of_some_frames_uses_just_the_frames_up_to_it() -> None:
    measured, lag = noisy(path(40)), 5
    found = run(smooth(lag_frames=lag, bounce_gate=1e6), measured)
    for frame in (0, 11, 30):
        known = measured[: frame + lag + 1]
        expected, _ = least_squares(known, 0.01, list(range(len(known))))
        assert found[frame].xyz[0] == pytest.approx(expected[frame], abs=1e-6)


def test_a_frame_is_sent_when_it_is_as_old_as_the_lag_and_the_rest_at_the_end() -> None:
    stage = smooth(lag_frames=3)
    sent = [len(stage.process(tracks(n, {0: (0, 0, 0)}), (positions(n, {0: (0, 0, 0)}),))) for n in range(6)]
    assert sent == [0, 0, 0, 1, 1, 1]
    rest = list(stage.remaining())
    assert [(one.header.time, one.header.seq) for one in rest] == [(n * PERIOD, n) for n in (3, 4, 5)]


def test_smoothing_takes_a_quarter_of_the_error_of_a_ball_that_moves_at_random() -> None:
    true = path(300)
    measured = noisy(true, 0.004)
    raw = np.linalg.norm(measured - true, axis=1)
    stage = smooth(lag_frames=6)
    found: list[Tracks] = []
    for n, place in enumerate(measured):
        found += stage.process(tracks(n, {0: place}), (positions(n, {0: place}, sigma=0.004),))
    found += stage.remaining()
    error = np.linalg.norm(np.array([one.xyz[0] for one in found]) - true, axis=1)
    assert np.sqrt(np.square(error).mean()) < 0.76 * np.sqrt(np.square(raw).mean())


def test_rows_and_states_are_those_of_the_tracker() -> None:
    stage = smooth(lag_frames=2)
    given = [
        tracks(0, {0: (0, 0, 1)}),
        tracks(1, {0: (0, 0, 1), 1: (1, 0, 1)}),
        tracks(2, {1: (1, 0, 1)}, PREDICTED),  # 0 is hidden; positions that the tracker refuses are no rows
        tracks(3, {}),
        tracks(4, {0: (0, 0, 1)}),
    ]
    found: list[Tracks] = []
    for frame, message in enumerate(given):
        found += stage.process(message, (positions(frame, {0: (0, 0, 1), 1: (1, 0, 1)}),))
    found += stage.remaining()
    assert [(one.target.tolist(), one.state.tolist()) for one in found] == [
        (one.target.tolist(), one.state.tolist()) for one in given
    ]
    assert [one.header.time for one in found] == [one.header.time for one in given]


def test_positions_that_the_tracker_refuses_do_not_move_a_target() -> None:
    away = {0: (5.0, 5.0, 5.0)}
    results = []
    for refused in (True, False):
        stage, found = smooth(lag_frames=2), []
        for n in range(10):
            hidden = 4 <= n < 7
            seen = positions(n, away if hidden else {0: (0.1 * n, 0, 1)})
            report = {} if hidden else {0: (0.1 * n, 0, 1)}
            found += stage.process(tracks(n, report), (seen,) if refused or not hidden else ())  # type: ignore[arg-type]
        results.append([*found, *stage.remaining()])
    assert all(identical(a, b) for a, b in zip(*results, strict=True))


def test_a_target_that_comes_back_elsewhere_is_not_joined_with_where_it_was() -> None:
    stage, found = smooth(lag_frames=0), []
    for n in range(20):
        place = (0.0, 0.0, 1.0) if n < 10 else (2.0, 0.0, 1.0)
        report = {} if n == 10 else {0: place}
        found += stage.process(tracks(n, report), (positions(n, report, support=1),))  # type: ignore[arg-type]
    found += stage.remaining()
    x = [one.xyz[0, 0] for one in found if len(one.xyz)]
    assert x == pytest.approx([0.0] * 10 + [2.0] * 9, abs=1e-9)
    alone = run(smooth(lag_frames=0), np.tile([0.0, 0.0, 1.0], (10, 1)))
    assert [one.sigma.tolist() for one in found[:10]] == [one.sigma.tolist() for one in alone]


def test_one_that_late_positions_carry_over_a_gap_may_still_come_back_elsewhere() -> None:
    stage, found = smooth(lag_frames=0), []
    for n in range(30):
        place = (0.0, 0.0, 1.0) if n < 13 else (2.0, 0.0, 1.0)
        report = {} if 10 <= n < 13 else {0: place}
        late = [positions(m, {0: (0.0, 0.0, 1.0)}) for m in (10, 11, 12)] if n == 15 else []
        found += stage.process(tracks(n, report), (*late, positions(n, report, support=1)))  # type: ignore[arg-type]
    found += stage.remaining()
    assert found[9].xyz[0, 0] < 0.1
    assert found[13].xyz[0, 0] > 1.9


def test_without_positions_a_target_begins_where_the_tracker_reports_it() -> None:
    stage = smooth(lag_frames=1)
    for n in range(3):
        found = stage.process(tracks(n, {1: (1.0, 2.0, 3.0)}, sigma=0.5), ())
        if n == 1:
            assert found[0].xyz[0] == pytest.approx([1.0, 2.0, 3.0])
            assert found[0].sigma[0] == pytest.approx([0.5] * 3)


def test_positions_that_are_no_numbers_are_left_out() -> None:
    stage, found = smooth(lag_frames=2), []
    for n in range(8):
        place = (np.nan, 0.0, 1.0) if n == 4 else (0.0, 0.0, 1.0)
        found += stage.process(tracks(n, {0: (0.0, 0.0, 1.0)}), (positions(n, {0: place}),))
    assert len(found) == 6
    assert all(np.isfinite(one.xyz).all() for one in found)


def test_a_bounce_stays_sharp() -> None:
    height = np.abs((np.arange(41) - 20) * 0.15)
    places = np.column_stack([height * 0, height * 0, height])
    sharp, blunt = (
        np.array([one.xyz[0, 2] for one in run(smooth(lag_frames=6, bounce_gate=gate), places)])
        for gate in (3.0, 1e6)
    )
    assert np.abs(sharp - height).max() < 0.5 * np.abs(blunt - height).max()


def test_targets_of_other_rooms_and_numbers_that_are_none_pass_as_they_are() -> None:
    stage = smooth(lag_frames=1)
    strange = {7: (1.0, 2.0, 3.0), 0: (np.nan, 0.0, 0.0)}
    for n in range(3):
        found = stage.process(tracks(n, strange), (positions(n, strange),))
    (one,) = found
    assert one.target.tolist() == [7, 0]
    assert one.xyz[0].tolist() == [1.0, 2.0, 3.0]


@settings(deadline=None, max_examples=10)
@given(seed=st.integers(0, 2**32 - 1), cut=st.integers(1, 39), lag=st.sampled_from([0, 1, 4]))
def test_a_successor_carries_on_to_the_bit_and_owes_the_same(seed: int, cut: int, lag: int) -> None:
    rng = np.random.default_rng(seed)
    old, new = smooth(lag_frames=lag), smooth(lag_frames=lag)
    outputs: tuple[list[Tracks], list[Tracks]] = ([], [])
    for n in range(40):
        if n == cut:
            new.restore(old.state())
        seen = {t: rng.normal(0, 0.1, 3) for t in range(2) if rng.random() < 0.8}
        window = tuple(positions(max(n - int(rng.integers(0, 6)), 0), {t: p}) for t, p in seen.items())
        message = tracks(n, {t: p for t, p in seen.items() if rng.random() < 0.9})
        for stage, found in zip((old, new) if n >= cut else (old,), outputs, strict=False):
            made = stage.process(message, window)
            found += made if n >= cut else ()
    for stage, found in zip((old, new), outputs, strict=True):
        found += stage.remaining()
    assert len(outputs[0]) == len(outputs[1]) > 0
    assert all(identical(a, b) for a, b in zip(*outputs, strict=True))


def test_a_smoother_of_whole_recordings_keeps_the_promises_of_a_stage() -> None:
    check_stage(Smooth, room=ROOM, messages=100, lag_frames=0)
