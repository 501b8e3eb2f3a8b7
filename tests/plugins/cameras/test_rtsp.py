"""A network camera whose clock is off, drifts, or is not told; that vanishes; that wants a password."""

from __future__ import annotations

import re
import time
from collections import Counter
from dataclasses import replace
from itertools import islice
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError
from tests.plugins.cameras.attempts import one_of
from tests.plugins.cameras.recordings import context

pytest.importorskip("av", reason="av is not installed")
from tests.plugins.cameras.rtsp_frames import last
from tests.plugins.cameras.rtsp_server import SIZE, RtspCamera, encoded

from followspot_cameras.rtsp.stage import Rtsp


def stage(camera: RtspCamera, said: list[str], **params: Any) -> Rtsp:
    return Rtsp(context("color", SIZE, warn=said.append), url=camera.url, **params)


@pytest.mark.parametrize(("shift", "drift"), [(0.25, 300e-6), (-0.25, -300e-6)])
def test_capture_times_are_those_of_a_clock_that_is_off_and_drifts(shift: float, drift: float) -> None:
    def attempt() -> bool:
        said: list[str] = []
        with RtspCamera(shift=shift, drift=drift, latency=0.04) as camera:
            source = stage(camera, said)
            frames = last(20, source.process(), camera, within=5.0)
            source.close()
        assert all(frame.pixels.shape == (48, 64, 3) for frame in frames)
        told = re.search(r": its clock is (.+) ms off, which is corrected$", said[0])
        assert told is not None
        return len(said) == 1 and abs(float(told[1]) - 1000 * shift) < 50.0

    assert one_of(4, attempt)


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


def test_pictures_that_cannot_be_decoded_are_counted_and_the_next_ones_come() -> None:
    """The third picture has all of its packets, and no slice that can be read."""
    said: list[str] = []
    lost: Counter[str] = Counter()
    made = context("color", SIZE, warn=said.append)
    made = replace(made, lost=lambda kind, number: lost.update({kind: number}))
    pictures = encoded()
    pictures[2] = [bytes([pictures[2][0][0]]) + b"\xff" * 40]
    with RtspCamera(reports=None, pictures=pictures) as camera:
        source = Rtsp(made, url=camera.url, wait_for_report=0)
        frames = list(islice(source.process(), 14))
        source.close()
    assert len(frames) == 14
    assert +lost == {"packet_loss": 2}


def test_a_server_that_is_killed_and_comes_back_takes_part_within_three_seconds() -> None:
    def attempt() -> bool:
        said: list[str] = []
        with RtspCamera(latency=0.04) as camera:
            source = stage(camera, said)
            frames = source.process()
            first = list(islice(frames, 8))
        with RtspCamera(port=camera.port, latency=0.04, reports=None):
            back = time.monotonic()
            begun = next(frames)
            took = time.monotonic() - back
            second = list(islice(frames, 5))
            source.close()
        times = [frame.header.time for frame in (*first, begun, *second)]
        assert times == sorted(set(times))
        assert times[-1] < time.time_ns()
        told = [text for text in said if "clock" not in text]  # a busy machine makes the clock look late
        assert told[0].endswith("; connecting again until it answers")
        assert ": is back after " in told[1]
        return took < 3.0

    assert one_of(4, attempt)


def test_a_camera_is_not_gone_while_the_graph_holds_a_picture() -> None:
    def attempt() -> bool:
        said: list[str] = []
        with RtspCamera(latency=0.04) as camera:
            source = stage(camera, said, read_timeout=0.3)
            frames = source.process()
            for _ in range(2):
                next(frames)
                time.sleep(0.5)
            next(frames)
            source.close()
        return not [text for text in said if "connecting again" in text]

    assert one_of(4, attempt)


def test_a_password_is_sent_as_a_digest_and_shown_nowhere() -> None:
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
