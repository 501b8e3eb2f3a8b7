"""A network camera whose clock is off, drifts, or is not told; that vanishes; that wants a password."""

from __future__ import annotations

import re
import time
from itertools import islice
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError
from tests.plugins.cameras.recordings import context

from followspot.tracking import Frame

pytest.importorskip("av", reason="av is not installed")
from tests.plugins.cameras.rtsp_server import SIZE, RtspCamera

from followspot_cameras.rtsp.stage import Rtsp


def stage(camera: RtspCamera, said: list[str], **params: Any) -> Rtsp:
    return Rtsp(context("color", SIZE, warn=said.append), url=camera.url, **params)


def errors(frames: list[Frame], camera: RtspCamera) -> np.ndarray:
    """Capture times less the true ones, ms; pictures are 50 ms apart."""
    true = np.array(camera.captured)
    found = np.array([frame.header.time for frame in frames])
    nearest = np.abs(found[:, None] - true).argmin(axis=1)
    assert (np.diff(nearest) == 1).all()
    return (found - true[nearest]) / 1e6


@pytest.mark.parametrize(("shift", "drift"), [(0.25, 300e-6), (-0.25, -300e-6)])
def test_capture_times_are_those_of_a_clock_that_is_off_and_drifts(shift: float, drift: float) -> None:
    said: list[str] = []
    with RtspCamera(shift=shift, drift=drift, latency=0.04) as camera:
        source = stage(camera, said)
        frames = list(islice(source.process(), 20))
        source.close()
        assert np.median(np.abs(errors(frames, camera))) < 5.0
    assert len(said) == 1
    told = re.search(r": its clock is (.+) ms off, which is corrected$", said[0])
    assert told is not None
    assert abs(float(told[1]) - 1000 * shift) < 50.0
    assert all(frame.pixels.shape == (48, 64, 3) for frame in frames)


def test_pictures_are_decoded_in_their_order() -> None:
    with RtspCamera() as camera:
        source = stage(camera, [])
        levels = [frame.pixels.mean() for frame in islice(source.process(), 12)]
        source.close()
    rises = np.diff(levels)
    assert ((rises > 10) | (rises < -100)).all()
    assert (rises < 0).sum() <= 2


def test_without_reports_the_arrival_counts_and_the_user_is_told() -> None:
    said: list[str] = []
    with RtspCamera(reports=None, shift=5.0) as camera:
        source = stage(camera, said, wait_for_report=0.2)
        before = time.time_ns()
        frames = list(islice(source.process(), 3))
        source.close()
    assert before + 200e6 < frames[0].header.time < frames[-1].header.time < time.time_ns()
    assert len(said) == 1
    assert said[0].endswith("sends no reports of its clock: capture times are those of the arrival")


def test_a_server_that_is_killed_and_comes_back_takes_part_within_three_seconds() -> None:
    said: list[str] = []
    with RtspCamera(latency=0.04) as camera:
        source = stage(camera, said)
        frames = source.process()
        first = list(islice(frames, 8))
    with RtspCamera(port=camera.port, latency=0.04, reports=None) as again:
        back = time.monotonic()
        second = list(islice(frames, 5))
        assert time.monotonic() - back < 3.0
        assert np.median(np.abs(errors(second, again))) < 20.0, "as late as before, until it reports again"
        source.close()
    assert second[0].header.time > first[-1].header.time
    assert [text.partition("/cam: ")[2].split(";")[-1] for text in said] == [
        " connecting again until it answers",
        "is back",
    ]


def test_a_password_is_sent_as_a_digest_and_shown_to_nobody() -> None:
    said: list[str] = []
    with RtspCamera(password="secret") as camera:
        source = stage(camera, said, wait_for_report=0)
        assert list(islice(source.process(), 1))
        source.close()
    assert any('username="viewer"' in request for request in camera.requests)
    assert not any("secret" in text for text in (*camera.requests, *said, source.origin))


@pytest.mark.parametrize("url", ["http://a/b", "rtsp://", "/dev/video0", "rtsp://a/b\r\nX: y", "file:///a"])
def test_only_addresses_of_network_cameras_are_taken(url: str) -> None:
    with pytest.raises(ValidationError):
        Rtsp(context(), url=url)
