"""Tracks for the eye."""

import numpy as np
import pytest

from followspot import Context, Header, Room, Target
from followspot.messages import stamped
from followspot.tracking import Tracks
from followspot_sinks.console import Console


def test_rate_of_printing_follows_capture_time(capsys: pytest.CaptureFixture[str]) -> None:
    sink = Console(Context(room=Room(targets={"red": Target("red", 0.1)})), maximum_rate=10)
    sink.setup()
    for frame in range(60):
        message = Tracks(
            target=np.array([0], "i4"),
            state=np.array([1], "u1"),
            xyz=np.array([[1.0, -2.0, frame / 100]]),
            velocity=np.zeros((1, 3)),
            sigma=np.full((1, 3), 0.004),
        )
        sink.process(stamped(message, Header("track", frame, frame * 10**9 // 60)))
    printed = capsys.readouterr().out.splitlines()
    assert len(printed) == 10
    assert printed[1] == "    0.100 s  red  tracked     +1.000  -2.000  +0.060 m  ± 4.0 mm"
