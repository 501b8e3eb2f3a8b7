"""`balls.smooth` with positions that come late."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from tests.plugins.balls.smoothed import ROOM, noisy, path, positions, smooth, tracks

from followspot.context import Context
from followspot.messages import identical
from followspot.tracking import Positions, Tracks


def late_run(by: int, lag: int, warn: list[str], late: Sequence[int] = (7, 8, 12)) -> list[Tracks]:
    """Some positions come `by` frames late; the tracker, which did not have them, extrapolates."""
    stage = smooth(Context(room=ROOM, warn=warn.append), lag_frames=lag)
    measured, found = noisy(path(30)), []
    held: dict[int, Positions] = {}
    for n, place in enumerate(measured):
        seen = positions(n, {0: place})
        if n in late:
            held[n + by], seen = seen, None  # type: ignore[assignment]
        window = tuple(one for one in (held.pop(n, None), seen) if one is not None)
        found += stage.process(tracks(n, {0: place}), window)
    return [*found, *stage.remaining()]


@pytest.mark.parametrize("by", [1, 3, 5])
def test_positions_that_come_late_are_used_as_if_they_had_come_in_time(by: int) -> None:
    warned: list[str] = []
    punctual, late = (late_run(n, 5, warned) for n in (0, by))
    assert np.array([one.xyz[0] for one in late[12:]]) == pytest.approx(
        np.array([one.xyz[0] for one in punctual[12:]]), abs=1e-9
    )  # frames that were sent before the last came are not the same
    without = late_run(100, 5, warned)
    gain = [np.abs(one[12].xyz - punctual[12].xyz).max() for one in (late, without)]
    assert gain[0] < 0.3 * gain[1]
    assert warned == []


@pytest.mark.parametrize("by", [6, 7])
def test_positions_that_come_too_late_are_left_out_and_told_once(by: int) -> None:
    warned: list[str] = []
    late, without = late_run(by, 5, warned), late_run(100, 5, warned)
    assert all(identical(a, b) for a, b in zip(late, without, strict=True))
    assert warned == ["positions came more than 5 frames late and were left out"]


def test_late_positions_join_both_sides_of_a_gap_but_add_no_row() -> None:
    results = []
    for late in (True, False):
        stage, found = smooth(lag_frames=8), []
        for n in range(30):
            place = (0.0, 0.0, 1.0 + 0.05 * n)
            gap = 10 <= n < 13
            seen = [] if gap else [positions(n, {0: place}, sigma=0.02)]
            if late and n == 15:
                came = [positions(m, {0: (0.0, 0.0, 1.0 + 0.05 * m)}, sigma=0.001) for m in (10, 11, 12)]
                seen = [*came, *seen]
            found += stage.process(tracks(n, {} if gap else {0: place}), tuple(seen))
        results.append([*found, *stage.remaining()])
    joined, apart = results
    assert (
        [len(one.xyz) for one in joined] == [len(one.xyz) for one in apart] == [1] * 10 + [0] * 3 + [1] * 17
    )
    assert joined[13].sigma.max() < 0.5 * apart[13].sigma.max()


def test_a_late_position_that_does_not_agree_is_left_out() -> None:
    results = []
    for wrong in (True, False):
        stage, found = smooth(lag_frames=4), []
        for n in range(20):
            seen = [positions(n, {0: (0, 0, 1)})]
            if wrong and n == 12:
                seen = [positions(11, {0: (0.5, 0, 1)}), *seen]
            found += stage.process(tracks(n, {0: (0, 0, 1)}), tuple(seen))
        results.append([*found, *stage.remaining()])
    assert all(np.array_equal(a.xyz, b.xyz) for a, b in zip(*results, strict=True))


def test_positions_between_the_frames_are_used_at_their_own_time() -> None:
    stage, found = smooth(lag_frames=4), []
    for n in range(20):
        seen = [positions(n, {0: (0.1 * n, 0, 1)}, sigma=0.01)]
        if n:
            seen = [positions(n - 0.5, {0: (0.1 * (n - 0.5), 0, 1)}, sigma=0.001), *seen]
        found += stage.process(tracks(n, {0: (0.1 * n, 0, 1)}), tuple(seen))
    found += stage.remaining()
    assert len(found) == 20
    assert found[10].xyz[0] == pytest.approx([1.0, 0, 1], abs=1e-3)
    assert found[10].sigma.max() < 0.003
