"""Messages for the eye."""

import numpy as np
import pytest

from followspot import Context, Header, Room, Target
from followspot.messages import stamped
from followspot.tracking import Tracks
from followspot_sinks.console import Console


def test_rate_of_printing_follows_capture_time(capsys: pytest.CaptureFixture[str]) -> None:
    sink = Console(
        Context(room=Room(targets={"red": Target("red", 0.1)})),
        maximum_rate=10,
        columns=["object", "state", "x", "y", "z"],
    )
    sink.setup()
    for frame in range(60):
        message = Tracks(
            target=np.array([0], "i4"),
            state=np.array([1], "u1"),
            xyz=np.array([[1.0, -2.0, frame / 100]]),
            velocity=np.zeros((1, 3)),
            sigma=np.full((1, 3), 0.004),
        )
        sink.process((stamped(message, Header("track", frame, frame * 10**9 // 60)),))
    printed = capsys.readouterr().out.splitlines()
    assert len(printed) == 10
    assert printed[1] == "    0.100 s  red  tracked  x +1.000  y -2.000  z +0.060"
