"""PTP of a camera with a node map of its own, asked over GigE Vision: what the list shows of it."""

from __future__ import annotations

import json
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from tests.plugins.cameras.genicam_port import own_port
from tests.plugins.cameras.gev_camera import HEIGHT, PTP, WIDTH, GevCamera
from tests.plugins.cameras.gvcp_camera import Camera, serving
from tests.plugins.cameras.recordings import context

pytest.importorskip("viva_genicam", reason="viva-genicam is not installed")
from followspot_cameras.genicam import viva
from followspot_cameras.genicam.facts import facts_of
from followspot_cameras.genicam.listing import cameras
from followspot_cameras.genicam.stage import Genicam

NODE_MAP = Path(__file__).with_name("ptp_camera.xml")
ENABLED, LATCH, STATUS, OFFSET = 0x2100, 0x2104, 0x2108, 0x2110
CLOCK_LATCH = 0x2000
STATES = {"Disabled": 3, "Listening": 4, "Master": 6, "Uncalibrated": 8, "Slave": 9}


@contextmanager
def camera(state: str = "Slave", offset: int = -120, enabled: int = 1) -> Iterator[Camera]:
    """640 x 480 px, Mono8; offset from its master, ns."""
    high, low = divmod(offset & (1 << 64) - 1, 1 << 32)
    registers = {0x2010: 640, 0x2014: 480, 0x2018: 0x0108_0001, CLOCK_LATCH: 0, 0x2008: 0, 0x200C: 5}
    registers |= {ENABLED: enabled, LATCH: 0, STATUS: STATES[state], OFFSET: high, OFFSET + 4: low}
    with own_port(), serving(Camera(NODE_MAP.read_bytes(), registers)) as found:
        yield found


def listed(capsys: pytest.CaptureFixture[str]) -> dict[str, object]:
    """The camera as it is listed; on a busy host its answer may come too late for one search."""
    for _ in range(100):
        if cameras("viva-genicam", "127.0.0.1", 0.3, None, as_json=True) == 0:
            break
        capsys.readouterr()
    (told,) = json.loads(capsys.readouterr().out)["cameras"]
    return told


@pytest.mark.parametrize(
    ("state", "enabled", "expected"),
    [
        ("Slave", 1, "Slave, -120 ns from its master"),
        ("Master", 1, "Master"),
        ("Uncalibrated", 1, "Uncalibrated"),
        ("Disabled", 0, "off"),
    ],
)
def test_the_list_shows_the_state_that_the_node_map_tells(
    capsys: pytest.CaptureFixture[str], state: str, enabled: int, expected: str
) -> None:
    with camera(state, enabled=enabled) as device:
        told = listed(capsys)
    assert told["ptp"] == expected
    assert (told["serial"], told["size"], told["clock"]) == ("SN-PTP-1", [640, 480], "readable")
    assert LATCH not in [at for at, _ in device.written]  # who only looks sets nothing


@pytest.mark.parametrize(
    ("state", "said"), [(4, ["its PTP is Listening: its clock follows no master"]), (9, [])]
)
def test_a_run_is_told_of_a_camera_that_follows_no_master(state: int, said: list[str]) -> None:
    device, told = GevCamera(), list[str]()
    device.registers |= {PTP: 1, PTP + 4: state}
    taking = threading.Thread(target=device.work)
    where = {"camera": "127.0.0.1", "backend": "viva-genicam", "interface": "127.0.0.1"}
    with own_port(), serving(device):
        taking.start()
        source = Genicam(context("infrared", (WIDTH, HEIGHT), warn=told.append), **where)
        next(source.process())
        source.close()
        device.end()
        taking.join()
    assert [text.removeprefix("camera 127.0.0.1: ") for text in told] == said


def test_a_camera_that_is_controlled_is_latched_before_it_is_read() -> None:
    with camera(offset=3_000_000_000) as device:
        info = next(info for _ in range(100) for info in viva.discover("127.0.0.1", 0.3))
        vision = viva.connect(info, "127.0.0.1", 0)
        try:
            told = facts_of(vision)
            reading = vision.read_clock()
        finally:
            vision.close()
    assert told.ptp == "Slave, 3000000000 ns from its master"
    assert (LATCH, 1) in device.written
    assert (CLOCK_LATCH, 1) in device.written
    assert reading is not None
    assert reading.camera == 5
