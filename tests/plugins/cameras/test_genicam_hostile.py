"""Cameras with node maps, clocks and pictures that no camera should have: refused, counted, or left out."""

from __future__ import annotations

import threading
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from itertools import islice

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.plugins.cameras.genicam_port import own_port
from tests.plugins.cameras.gev_camera import HEIGHT, WIDTH, GevCamera, node_map
from tests.plugins.cameras.gvcp_camera import URL_AT, XML_AT, serving
from tests.plugins.cameras.recordings import context

from followspot import InputError
from followspot_cameras.genicam.camera_clock import Reading
from followspot_cameras.genicam.capture_times import CaptureTimes
from followspot_cameras.genicam.clock_features import FREQUENCY, clock_features, frequency

pytest.importorskip("viva_genicam", reason="viva-genicam is not installed")
from followspot_cameras.genicam.stage import Genicam

GOOD = node_map()
CLOCK = b'<Integer Name="TimestampLatchValue"><pValue>ClockReg</pValue></Integer>'
TEXT = (
    b'<StringReg Name="TimestampLatchValue"><Address>0xD8</Address><Length>16</Length>'
    b"<AccessMode>RO</AccessMode><pPort>Device</pPort></StringReg>"
)


@contextmanager
def running(camera: GevCamera) -> Iterator[GevCamera]:
    taking = threading.Thread(target=camera.work)
    with own_port(), serving(camera):
        taking.start()
        try:
            yield camera
        finally:
            camera.end()
            taking.join()


def stage(said: list[str], lost: Counter[str] | None = None, **params: object) -> Genicam:
    """One that ends as soon as its camera is gone."""

    def warn(text: str) -> None:
        said.append(text)
        if "connecting again" in text:
            source.close()

    made = context("infrared", (WIDTH, HEIGHT), warn=warn)
    if lost is not None:
        made = replace(made, lost=lambda kind, number: lost.update({kind: number}))
    where = {"camera": "127.0.0.1", "backend": "viva-genicam", "interface": "127.0.0.1"}
    source = Genicam(made, **where, **params)
    return source


def described(xml: bytes) -> GevCamera:
    camera = GevCamera(fps=60)
    camera.xml = xml
    url = f"Local:camera.xml;{XML_AT:x};{len(xml):x}".encode().ljust(64, b"\0")
    camera._boot[URL_AT : URL_AT + 64] = url
    return camera


@pytest.mark.parametrize(
    "xml",
    [
        b"\xff" * 500,
        GOOD[: len(GOOD) // 2],
        b"",
        GOOD.replace(b"<Length>4</Length>", b"<Length>-1</Length>"),
        GOOD.replace(b"64 - OTHER", b"1/0 + ((((OTHER"),
    ],
)
def test_a_node_map_that_cannot_be_used_is_told_or_hinders_nothing(xml: bytes) -> None:
    said: list[str] = []
    with running(described(xml)):
        source = stage(said, features={"Width": WIDTH, "OffsetX": 0})
        try:
            frames = list(islice(source.process(), 1))
        except InputError as error:
            frames, said = [], [str(error)]
        source.close()
    assert frames or "camera 127.0.0.1" in said[0]


@pytest.mark.parametrize(
    "xml",
    [
        GOOD.replace(CLOCK, TEXT),
        GOOD.replace(b"<pFeature>All</pFeature>", b"<pFeature>All</pFeature><pFeature>Root</pFeature>"),
        GOOD.replace(b"<Port", b'<Integer Name="x"><Value>1</Value></Integer>' * 5000 + b"<Port"),
    ],
)
def test_a_strange_node_map_hinders_no_pictures(xml: bytes) -> None:
    said: list[str] = []
    with running(described(xml)):
        source = stage(said, features={"Width": WIDTH})
        frames = list(islice(source.process(), 2))
        source.close()
    assert len(frames) == 2


@pytest.mark.parametrize("size", [(0, 0), (1 << 31, 1 << 31), (WIDTH + 1, HEIGHT)])
def test_a_camera_that_changes_its_format_while_it_runs_is_refused_by_name(size: tuple[int, int]) -> None:
    """Of a picture that claims a size, the packets come as before."""
    said: list[str] = []
    with running(GevCamera(fps=60)) as camera:
        source = stage(said)
        pictures = source.process()
        next(pictures)
        camera.claimed = size
        with pytest.raises(
            InputError, match=rf"{size[0]}x{size[1]} px, but camera cam3 is calibrated for 64x48"
        ):
            list(pictures)


@pytest.mark.parametrize(
    "spoilt",
    [
        lambda packet: packet[:7],
        lambda packet: b"\xff" * len(packet),
        lambda packet: packet[:5] + b"\xff\xff\xff" + packet[8:],
        lambda packet: packet + bytes(9000),
        lambda packet: b"",
    ],
)
def test_spoilt_packets_cost_the_picture_that_they_belong_to(spoilt: Callable[[bytes], bytes]) -> None:
    said: list[str] = []
    lost: Counter[str] = Counter()
    with running(GevCamera(fps=60)) as camera:
        camera.spoil = lambda number, place, packet: (
            spoilt(packet) if number % 5 == 0 and place == 2 else packet
        )
        source = stage(said, lost)
        frames = list(islice(source.process(), 30))
        source.close()
    assert len(frames) == 30
    assert lost["packet_loss"] >= 5
    assert all(frame.pixels.shape == (HEIGHT, WIDTH, 1) for frame in frames)


@pytest.mark.parametrize("told", ["", "many", "nan", "inf", "-5", "1e400"])
def test_a_frequency_that_is_none_is_a_nanosecond(told: str) -> None:
    assert frequency({FREQUENCY}, lambda name: told) == 10**9


@pytest.mark.parametrize("told", ["", "Slave", "1.5e9"])
def test_a_clock_that_tells_no_number_cannot_be_read(told: str) -> None:
    found = clock_features({"TimestampLatch", "TimestampLatchValue"}, lambda name: told)
    assert found is not None
    assert found.read(lambda command: None, lambda name: told) is None


@given(
    st.lists(st.integers(-(1 << 64), 1 << 64), max_size=8),
    st.lists(st.one_of(st.none(), st.integers(0, (1 << 64) - 1)), min_size=1, max_size=30),
)
def test_capture_times_rise_whatever_a_camera_stamps(readings: list[int], stamps: list[int | None]) -> None:
    now, told = 10**12, iter(readings)

    def read() -> Reading | None:
        camera = next(told, None)
        return None if camera is None else Reading(camera, now, now + 1000)

    times = CaptureTimes(read)
    times.update(now)
    times.start(now)
    last = None
    for number, stamp in enumerate(stamps):
        arrival = now + number * 10_000_000
        found = times.capture_time(stamp, arrival)
        assert last is None or found > last
        last = found
