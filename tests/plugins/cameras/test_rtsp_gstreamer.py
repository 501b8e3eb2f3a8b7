"""Network cameras that GStreamer plays: H.264, H.265, TCP, UDP; a server that ends and comes back."""

from __future__ import annotations

import subprocess
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from itertools import islice
from pathlib import Path

import numpy as np
import pytest
from tests.integration.hosts import free_port
from tests.plugins.cameras.recordings import context

pytest.importorskip("av", reason="av is not installed")
from followspot_cameras.rtsp.stage import Rtsp

PYTHON = "/usr/bin/python3"
SERVER = Path(__file__).with_name("gstreamer_server.py")
SIZE, RATE = (320, 240), 30
PICTURES = f"videotestsrc is-live=true ! video/x-raw,format=I420,width=320,height=240,framerate={RATE}/1"
ENCODERS = {
    "h264": "openh264enc gop-size=30 ! h264parse ! rtph264pay name=pay0 pt=96 config-interval=1",
    "h265": "x265enc tune=zerolatency speed-preset=ultrafast key-int-max=30 ! h265parse "
    "! rtph265pay name=pay0 pt=96 config-interval=1",
}
NEEDED = f"""
import gi
gi.require_version("Gst", "1.0"); gi.require_version("GstRtspServer", "1.0")
from gi.repository import Gst, GstRtspServer
Gst.init(None)
names = [word.split()[0] for text in {list(ENCODERS.values())} for word in text.split("!")]
raise SystemExit(not all(map(Gst.ElementFactory.find, names)))
"""

pytestmark = pytest.mark.thorough


@pytest.fixture(scope="module", autouse=True)
def _gstreamer() -> None:
    if not Path(PYTHON).exists() or subprocess.run([PYTHON, "-c", NEEDED], capture_output=True).returncode:
        pytest.skip("gir1.2-gst-rtsp-server-1.0 and GStreamer's plugins are not installed")


@contextmanager
def serving(codec: str, port: int) -> Iterator[None]:
    command = [PYTHON, str(SERVER), str(port), f"( {PICTURES} ! {ENCODERS[codec]} )"]
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen(command, text=True, **pipes) as process:
        assert process.stdout.readline() == "running\n", process.stderr.read()
        yield
        process.communicate()


@pytest.mark.parametrize("transport", ["tcp", "udp"])
@pytest.mark.parametrize("codec", list(ENCODERS))
def test_pictures_come_at_the_intervals_of_their_clock(codec: str, transport: str) -> None:
    port, lost, said = free_port(), Counter[str](), []
    found = context("color", SIZE, warn=said.append)
    found = replace(found, lost=lambda kind, number: lost.update({kind: number}))
    source = Rtsp(found, url=f"rtsp://127.0.0.1:{port}/cam", transport=transport)
    with serving(codec, port):
        frames = list(islice(source.process(), 60))
        source.close()
    apart = np.diff([frame.header.time for frame in frames]) * RATE / 1e9
    assert np.median(np.abs(apart - 1)) < 1e-3
    assert np.array(frames[-1].pixels).std() > 20
    assert +lost == {}
    assert [text for text in said if "clock" not in text] == []  # a busy machine makes the clock look late


def test_a_server_that_ends_and_comes_back_takes_part_again() -> None:
    port, said = free_port(), []
    source = Rtsp(
        context("color", SIZE, warn=said.append), url=f"rtsp://127.0.0.1:{port}/cam", transport="udp"
    )
    frames = source.process()
    with serving("h264", port):
        first = list(islice(frames, 5))
    with serving("h264", port):
        second = list(islice(frames, 5))
        source.close()
    assert second[0].header.time > first[-1].header.time
    assert any("is back after" in text for text in said)
