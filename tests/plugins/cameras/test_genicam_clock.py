"""A camera that stamps by the clock that it tells, and one whose clock is this host's (PTP)."""

from __future__ import annotations

import threading
import time
from itertools import islice

import numpy as np
import pytest
from tests.plugins.cameras.genicam_port import own_port
from tests.plugins.cameras.gev_camera import HEIGHT, WIDTH, GevCamera
from tests.plugins.cameras.gvcp_camera import serving
from tests.plugins.cameras.recordings import context

from followspot_cameras.genicam.camera_clock import Reading
from followspot_cameras.genicam.capture_times import CaptureTimes

MS, S = 1_000_000, 1_000_000_000


def test_pictures_have_the_times_at_which_the_camera_took_them() -> None:
    """Its clock is 5000 s off and drifts; on a busy host, readings without delay come sooner or later."""
    pytest.importorskip("viva_genicam", reason="viva-genicam is not installed")
    from followspot_cameras.genicam.stage import Genicam

    camera = GevCamera(fps=60, shift=5000 * S, drift=50e-6)
    taking = threading.Thread(target=camera.work)
    where = {"camera": "127.0.0.1", "backend": "viva-genicam", "interface": "127.0.0.1"}
    with own_port(), serving(camera):
        taking.start()
        source = Genicam(context("infrared", (WIDTH, HEIGHT)), **where)
        found: list[int] = []
        for frame in islice(source.process(), 1200):
            found = [*found[-19:], frame.header.time]
            taken = np.array([moment for _, moment in camera.captured])
            off = np.abs(np.array(found)[:, None] - taken).min(axis=1)
            if len(found) == 20 and off.max() < MS / 10:
                break
        source.close()
        camera.end()
        taking.join()
    assert off.max() < MS / 10


def told_from(stamps: list[int], now: int, clock: int) -> tuple[list[str], list[int]]:
    """How the times of pictures are told, and how long before their arrival they are, ns, of a camera whose
    clock reads `clock` at `now` of this host; a picture comes 20 ms after its time.
    """
    times = CaptureTimes(lambda: Reading(clock, now, now))
    times.update(now)
    times.start(now)
    by, before = [], []
    for stamp in stamps:
        arrival = now + stamp + 20 * MS
        since_1970 = arrival + time.time_ns() - time.monotonic_ns()
        before.append(since_1970 - times.capture_time(stamp, arrival))
        by.append(times.by)
    return by, before


def test_a_clock_that_began_with_the_pictures_never_counts_as_the_one_that_the_camera_tells() -> None:
    """The one that it tells was at 2 s then: after 2 s, a picture seems to be of after the start."""
    by, before = told_from([k * 50 * MS for k in range(80)], now=100 * S, clock=2 * S)
    assert set(by) == {"delay"}
    assert max(before) < 5 * MS


def test_a_picture_that_was_begun_before_the_start_is_an_exception() -> None:
    by, before = told_from([k * 50 * MS for k in range(-2, 8)], now=100 * S, clock=0)
    assert by == ["delay"] * 2 + ["camera"] * 8
    assert all(abs(one - 20 * MS) < MS for one in before[2:])


@pytest.mark.parametrize("ahead", [0, 37 * S])
def test_stamps_of_this_computers_clock_or_of_ptp_are_taken_as_they_are(ahead: int) -> None:
    """PTP counts no leap seconds."""
    times = CaptureTimes(lambda: None)
    times.update(time.monotonic_ns())
    taken = time.time_ns() - 300 * MS
    assert times.capture_time(taken + ahead, time.monotonic_ns()) == taken
    assert times.by == "shared"


def test_stamps_of_another_clock_are_not_taken_as_they_are() -> None:
    times = CaptureTimes(lambda: None)
    times.update(time.monotonic_ns())
    stamp = time.time_ns() - 2 * S
    assert times.capture_time(stamp, time.monotonic_ns()) > stamp + S
    assert times.by == "delay"
