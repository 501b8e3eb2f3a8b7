"""Numbers of a camera's frames and its clock: wrap-around, gaps, restarts, drift, slow readings."""

from __future__ import annotations

import numpy as np
import pytest

from followspot_cameras.frame_numbers import SHORT, FrameNumbers
from followspot_cameras.genicam.camera_clock import CameraClock, Reading
from followspot_cameras.genicam.capture_times import CaptureTimes

MS, S = 1_000_000, 1_000_000_000


def told(numbers: FrameNumbers, identifiers: list[int]) -> list[tuple[int | None, int]]:
    return [(numbers.next(identifier), numbers.number) for identifier in identifiers]


def test_numbers_rise_over_the_wrap_around_of_16_bits_and_skip_no_zero() -> None:
    numbers = FrameNumbers()
    assert told(numbers, [65_534, 65_535, 1, 2]) == [(0, 0), (0, 1), (0, 2), (0, 3)]


def test_every_frame_of_two_turns_has_its_own_number() -> None:
    numbers = FrameNumbers()
    missing = [numbers.next(1 + n % SHORT) for n in range(2 * SHORT + 5)]
    assert not any(missing)
    assert numbers.number == 2 * SHORT + 4


def test_missing_frames_are_counted_also_over_the_wrap_around() -> None:
    assert told(FrameNumbers(), [5, 6, 9, 10]) == [(0, 0), (0, 1), (2, 4), (0, 5)]
    assert told(FrameNumbers(), [65_533, 3]) == [(0, 0), (4, 5)]


def test_a_frame_that_came_before_has_no_number_and_a_camera_that_starts_anew_goes_on() -> None:
    numbers = FrameNumbers()
    assert told(numbers, [500, 500, 1, 2]) == [(0, 0), (None, 0), (0, 1), (0, 2)]
    assert numbers.restarts == 1


def test_wide_identifiers_do_not_wrap() -> None:
    numbers = FrameNumbers(largest=0)
    assert told(numbers, [65_535, 65_536, 65_538]) == [(0, 0), (0, 1), (1, 3)]


def reading(at: int, drift: float, rng: np.random.Generator) -> Reading:
    """Of a camera whose clock shows 7 s at 100 s, too quick by `drift`; 0.2 ms or more there and back."""
    there, back = 100_000 + rng.exponential(100_000, 2).astype(int)
    return Reading(round((at + there - 100 * S) * (1 + drift)) + 7 * S, at, at + int(there + back))


@pytest.mark.parametrize("drift", [0.0, 50e-6, -100e-6])
def test_a_camera_clock_is_followed_within_a_tenth_of_a_millisecond(drift: float) -> None:
    clock, rng = CameraClock(), np.random.default_rng(1)
    errors = []
    for second in range(100, 160):
        for n in range(3 if clock.known else 8):
            clock.add(reading(second * S + n * MS, drift, rng))
        true = second * S + S // 2
        errors.append(clock.steady_time(round((true - 100 * S) * (1 + drift)) + 7 * S) - true)
    assert np.abs(errors).max() < 0.1 * MS
    assert abs(clock.drift - drift) < 2e-6
    assert clock.settings == 0


def test_a_camera_clock_that_is_set_is_followed_at_once() -> None:
    clock, rng = CameraClock(), np.random.default_rng(1)
    for second in range(100, 120):
        clock.add(reading(second * S, 0.0, rng))
    later = reading(120 * S, 0.0, rng)
    moved = later._replace(camera=later.camera + 3 * S)
    clock.add(moved)
    assert clock.settings == 1
    assert abs(clock.steady_time(moved.camera) - moved.middle) < 0.3 * MS


def test_pictures_stamped_by_another_clock_than_the_camera_tells_go_by_the_least_delay() -> None:
    times = CaptureTimes(lambda: Reading(900 * S, 50 * S, 50 * S + 1000))
    times.update(0)
    times.capture_time(3 * S, 50 * S)
    assert times.by == "delay"


def test_pictures_without_a_time_are_captured_when_they_come() -> None:
    times = CaptureTimes(lambda: None)
    times.update(0)
    first, second = times.capture_time(None, 50 * S), times.capture_time(None, 51 * S)
    assert times.by == "arrival"
    assert abs(second - first - S) < MS


def test_capture_times_rise_even_if_a_camera_says_otherwise() -> None:
    times = CaptureTimes(lambda: Reading(50 * S, 50 * S, 50 * S))
    times.update(0)
    assert times.capture_time(50 * S, 50 * S) < times.capture_time(49 * S, 50 * S + 1)
