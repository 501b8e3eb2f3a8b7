"""The Lab Streaming Layer between two processes, with liblsl itself, discovery on this host alone."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from types import SimpleNamespace
from typing import Any

import pytest

from followspot import Context, InputError
from followspot.errors import FollowspotError
from followspot_lsl import library
from followspot_lsl.library import LslParams, configuration, load
from followspot_lsl.outlet import Outlet
from followspot_lsl.stream import Stream, checked

pytestmark = pytest.mark.skipif(find_spec("pylsl") is None, reason="needs pylsl")
TARGETS = """
import sys, threading, time
import numpy as np
from followspot import Context, Room, Target
from followspot.messages import Header, stamped
from followspot.message_checks.sealing import seal
from followspot.tracking import Tracks
from followspot_lsl.outlet import Outlet

room = Room(targets={name: Target(name, 0.1, {}, {}, {}) for name in ("red", "blue")})
stage = Outlet(Context("save", room), host="0.0.0.0", name=sys.argv[1])
stage.setup()
over = threading.Event()
threading.Thread(target=lambda: (sys.stdin.read(), over.set()), daemon=True).start()
number = 0
while not over.wait(0.01):
    now = time.time_ns()
    xyz, velocity = np.array([[number, 2.0, 3.0]]), np.array([[now / 1e9 % 1e6, 5.0, 6.0]])
    tracks = Tracks(np.array([1], "i4"), np.array([3], "u1"), xyz, velocity, np.zeros((1, 3)))
    stage.process(stamped(seal(tracks), Header("camera", number, now)))
    number += 1
"""
REGULAR = """
import sys, threading
from followspot_lsl.library import LslParams, load

pylsl = load(LslParams(host="0.0.0.0"))
outlet = pylsl.StreamOutlet(pylsl.StreamInfo(sys.argv[1], "EEG", 2, 100.0, pylsl.cf_float32, "device"))
over = threading.Event()
threading.Thread(target=lambda: (sys.stdin.read(), over.set()), daemon=True).start()
begun, number = pylsl.local_clock(), 0
while not over.wait(0.01):
    if number % 10 < 7:  # three of ten are left out
        outlet.push_sample([number, -number], begun + number / 100)
    number += 1
"""
RECEIVE = """
import json, sys
from followspot import Context
from followspot_lsl.stream import Stream

name, most = sys.argv[1], int(sys.argv[2])
lost, rows = [], []
stage = Stream(Context(lost=lambda why, count: lost.append((why, count))), host="0.0.0.0", name=name)
stage.setup()
for message in stage.process():
    rows += zip(message.time.tolist(), message.channel.tolist(), message.value.tolist())
    assert message.header.time == message.time[-1]
    if len(rows) >= most * len(message.channels):
        break
print(json.dumps({"stream": message.stream, "channels": message.channels, "rows": rows, "lost": lost}))
"""


@contextmanager
def sending(script: str, name: str) -> Iterator[None]:
    """Another process that sends until it is told to end."""
    with subprocess.Popen([sys.executable, "-c", script, name], stdin=subprocess.PIPE) as process:
        try:
            yield
        finally:
            assert process.stdin is not None
            process.stdin.close()


def received(script: str, name: str, samples: int) -> Any:
    with sending(script, name):
        words = [sys.executable, "-c", RECEIVE, name, str(samples)]
        done = subprocess.run(words, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1].replace("NaN", "null"))


def test_targets_reach_another_process_with_names_and_capture_times() -> None:
    told = received(TARGETS, "followspot test targets", 30)
    names = ("state", "x", "y", "z", "vx", "vy", "vz")
    assert told["channels"] == [f"{target}.{name}" for target in ("red", "blue") for name in names]
    samples = [told["rows"][i : i + 14] for i in range(0, len(told["rows"]), 14)]
    for sample in samples:
        assert [channel for _, channel, _ in sample] == list(range(14))
        values = [value for _, _, value in sample]
        assert values[:7] == [0, *[None] * 6]
        assert [*values[7:8], *values[9:11], *values[12:]] == [3, 2, 3, 5, 6]
        assert sample[0][0] / 1e9 % 1e6 == pytest.approx(values[11], abs=0.5), "a clock of the same zero"
    numbers = [sample[8][2] for sample in samples]
    assert numbers == [numbers[0] + i for i in range(len(numbers))], "each sample once, in order"


def test_what_a_regular_stream_leaves_out_is_counted() -> None:
    told = received(REGULAR, "followspot test regular", 40)
    assert told["channels"] == ["0", "1"]
    numbers = [int(value) for _, channel, value in told["rows"] if channel == 0]
    missing = numbers[-1] - numbers[0] + 1 - len(numbers)
    assert missing >= 12
    assert {why for why, _ in told["lost"]} == {"gap"}
    assert sum(count for _, count in told["lost"]) == missing
    times = [time for time, channel, _ in told["rows"] if channel == 0]
    expected = [(number - numbers[0]) * 10_000_000 for number in numbers]
    assert [time - times[0] for time in times] == pytest.approx(expected, abs=5_000_000)


@pytest.mark.parametrize("stage", [Stream, Outlet])
def test_it_is_refused_unless_all_networks_are_permitted(stage: type[Stream | Outlet]) -> None:
    with pytest.raises(
        InputError, match=r"liblsl listens on all networks of this host, not on 127\.0\.0\.1"
    ) as told:
        stage(Context()).setup()
    assert "host: 0.0.0.0" in str(told.value)


def test_another_configuration_in_the_same_process_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(library, "_loaded", configuration("site"))
    with pytest.raises(InputError, match="another configuration"):
        load(LslParams(host="0.0.0.0"))


def test_a_library_that_other_code_has_loaded_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(library, "_loaded", "")
    monkeypatch.setitem(sys.modules, "pylsl", SimpleNamespace())
    with pytest.raises(InputError, match="another configuration"):
        load(LslParams(host="0.0.0.0"))


def test_a_machine_s_streams_are_not_announced_elsewhere() -> None:
    text = configuration("machine")
    assert "ResolveScope = machine" in text
    assert "ListenAddress = 127.0.0.1" in text
    assert "ListenAddress" not in configuration("link")


@pytest.mark.parametrize(("kind", "count"), [(3, 1), (1, 1001), (1, 0)])
def test_texts_and_too_many_channels_are_refused(kind: int, count: int) -> None:
    info = SimpleNamespace(channel_format=lambda: kind, channel_count=lambda: count, name=lambda: "markers")
    with pytest.raises(FollowspotError, match="the stream 'markers' has"):
        checked(info)
