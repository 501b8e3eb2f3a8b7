"""A meter tells how regularly a port sends, to those who ask, as long as they do."""

from __future__ import annotations

import numpy as np
import pytest

from followspot import Context
from followspot.messages import Header, stamped
from followspot.taps.framing import framed_record
from followspot.tracking import Blobs
from followspot.wire import unpack
from followspot_dashboard.echo import Echo
from followspot_dashboard.meter import MOST, Meter, Rhythm, rhythm

MS = 1_000_000
MESSAGE = stamped(Blobs.empty(), Header("camera/cam0", 3, 0))


class Post:
    """To somebody on another host."""

    def __init__(self) -> None:
        self.wanted = False
        self.sent: list[bytes] = []

    def send(self, packet: bytes) -> None:
        self.sent.append(packet)

    def close(self) -> None:
        self.wanted = False


def test_rate_jitter_and_longest_gap_are_those_of_the_gaps() -> None:
    times = np.cumsum([0, 10, 10, 30, 10]) * MS
    found = rhythm(7, times)
    assert (found.count, found.mean_ms, found.worst_ms) == (7, 15.0, 30.0)
    assert found.rate == pytest.approx(1e3 / 15)
    assert found.jitter_ms == pytest.approx(np.std([10, 10, 30, 10]))
    assert found.p95_ms == 30.0
    assert rhythm(99, np.cumsum([10] * 19 + [30, 50]) * MS).p95_ms == 30.0
    assert rhythm(1, times[:1]).rate == 0.0


def test_only_the_window_counts_and_reports_are_rare() -> None:
    post, now = Post(), [0]
    post.wanted = True
    meter = Meter(Context(post=post), port="color/cam0.blobs", window=1.0, report_interval=0.5)
    meter.monotonic_ns = lambda: now[0]  # type: ignore[method-assign]
    meter.setup()
    for number in range(300):
        now[0] += 10 * MS if number < 150 else 20 * MS
        meter.process(MESSAGE)
    assert len(post.sent) == 9  # at once, and in 4.49 s after that
    record = framed_record(post.sent[-1])
    assert record is not None
    port, number, packed = record
    assert (port, number) == ("color/cam0.blobs", 8)
    told = unpack(packed, Rhythm)
    assert isinstance(told, Rhythm)
    assert (told.mean_ms, told.jitter_ms, told.header.seq) == (20.0, 0.0, 3)
    for _ in range(2 * MOST):
        meter.process(MESSAGE)
    assert len(meter.times) == MOST


@pytest.mark.parametrize("kind", [Meter, Echo])
def test_who_went_is_not_told_any_more_and_who_never_came_is_waited_for(kind: type[Meter | Echo]) -> None:
    post = Post()
    stage = kind(Context(post=post), port="color/cam0.blobs")
    stage.setup()
    stage.process(MESSAGE)
    assert post.sent == []
    post.wanted = True
    if isinstance(stage, Meter):
        stage.tell_at = 0
    stage.process(MESSAGE)
    assert len(post.sent) == 1
    post.wanted = False
    with pytest.raises(EOFError):
        stage.process(MESSAGE)
    stage.close()
