"""Cameras of this host through V4L2: numbers and times of the driver, and cameras that vanish."""

from __future__ import annotations

import ctypes
import mmap
import os
import time
from pathlib import Path

import numpy as np
import pytest
from tests.plugins.cameras import v4l2_kernel
from tests.plugins.cameras.recordings import numbers, picture
from tests.plugins.cameras.v4l2_devices import JPEG, YUYV, Taken

from followspot.frame_times import SECOND
from followspot_cameras import reconnection
from followspot_cameras.v4l2 import layout
from followspot_cameras.v4l2.kernel import Linux
from followspot_cameras.v4l2.video_device import driver_time


@pytest.fixture(autouse=True)
def _short_waits(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reconnection, "FIRST_WAIT", 0.001)


def test_structures_and_requests_are_those_of_the_header() -> None:
    """Numbers that gcc prints for videodev2.h on x86-64 and arm64."""
    sizes = {
        layout.Capability: 104,
        layout.FormatDescription: 64,
        layout.Format: 208,
        layout.BufferRequest: 20,
        layout.Buffer: 88,
        layout.StreamParameters: 204,
        layout.ControlQuery: 68,
        layout.MenuQuery: 44,
        layout.Control: 8,
    }
    assert {form: ctypes.sizeof(form) for form in sizes} == sizes
    places = {
        "bytesused": 8,
        "flags": 12,
        "timestamp": 24,
        "sequence": 56,
        "memory": 60,
        "m": 64,
        "length": 72,
    }
    assert {name: getattr(layout.Buffer, name).offset for name in places} == places
    assert layout.Format.fmt.offset == 8
    assert layout.Capability.device_caps.offset == 88
    assert layout.FormatDescription.pixelformat.offset == 44
    assert layout.ControlQuery.minimum.offset == 40
    assert layout.ControlQuery.flags.offset == 56
    assert layout.MenuQuery.entry.offset == 8
    assert layout.StreamParameters.numerator.offset == 12
    assert layout._PixelFormat.bytesperline.offset == 16
    requests = {
        *(layout.QUERYCAP, layout.ENUM_FMT, layout.G_FMT, layout.S_FMT, layout.REQBUFS, layout.QUERYBUF),
        *(layout.QBUF, layout.DQBUF, layout.STREAMON, layout.STREAMOFF, layout.G_PARM, layout.S_PARM),
        *(layout.QUERYCTRL, layout.QUERYMENU, layout.S_CTRL),
    }
    assert requests == {
        *(0x80685600, 0xC0405602, 0xC0D05604, 0xC0D05605, 0xC0145608, 0xC0585609, 0xC058560F, 0xC0585611),
        *(0x40045612, 0x40045613, 0xC0CC5615, 0xC0CC5616, 0xC0445624, 0xC02C5625, 0xC008561C),
    }


def test_pictures_have_the_numbers_and_times_of_the_driver() -> None:
    before = time.time_ns()
    taken = Taken(v4l2_kernel.Camera([1, 1, 1], ["BGR3"], data=picture(9).tobytes()), device=2)
    assert taken.camera.opened[0] == "/dev/video2"
    assert [frame.header.seq for frame in taken.frames] == [0, 1, 2]
    times = [frame.header.time for frame in taken.frames]
    assert before - v4l2_kernel.AGE - 100_000 <= times[0] < times[1] < times[2]
    assert times[2] <= time.time_ns() - v4l2_kernel.AGE
    assert [numbers(frame.pixels) for frame in taken.frames] == [9, 9, 9]
    assert taken.losses == {}
    assert taken.camera.closed == 1


def test_a_driver_with_another_clock_is_not_believed() -> None:
    before = time.time_ns()
    taken = Taken(v4l2_kernel.Camera([1], data=YUYV, clock=0x4000))
    assert before <= taken.frames[0].header.time <= time.time_ns()


def test_the_driver_says_when_a_picture_was_captured() -> None:
    steady, now = 5_000_000_000_000, 1_700_000_000_000_000_000
    assert driver_time(4_999_960_250_000, steady, now, SECOND) == now - 39_750_000
    assert driver_time(4_998_000_000_000, steady, now, steady) == now - 2 * SECOND
    for other in (0, 5_000_001_000_000, 1_700_000_000_000_000_000):  # none, one to come, of another clock
        for oldest in (SECOND, steady):
            assert driver_time(other, steady, now, oldest) == now


def test_numbers_that_the_driver_leaves_out_are_a_gap() -> None:
    taken = Taken(v4l2_kernel.Camera([1, -3, 1, -1, 1], data=YUYV))
    assert [frame.header.seq for frame in taken.frames] == [0, 4, 5, 7, 8]
    assert taken.losses == {"gap": 4}


def test_pictures_that_came_while_all_buffers_were_full_are_an_overrun() -> None:
    """Nine come at once: four have a buffer. A gap long after that is none."""
    taken = Taken(v4l2_kernel.Camera([9, 1, 1, 1, 1, 1, -2], data=YUYV))
    assert [frame.header.seq for frame in taken.frames] == [0, 1, 2, 3, 9, 10, 11, 12, 13, 16]
    assert taken.losses == {"device_overrun": 5, "gap": 2}


def test_damaged_pictures_are_lost_packets() -> None:
    taken = Taken(v4l2_kernel.Camera([1, "damaged", YUYV[:-2], 1], data=YUYV))
    assert [frame.header.seq for frame in taken.frames] == [0, 3]
    assert taken.losses == {"packet_loss": 2}
    compressed = Taken(v4l2_kernel.Camera([JPEG, b"", b"no picture", JPEG], ["MJPG"]))
    assert [frame.header.seq for frame in compressed.frames] == [0, 3]
    assert compressed.losses == {"packet_loss": 2}


def test_a_driver_that_does_not_count_loses_nothing() -> None:
    taken = Taken(v4l2_kernel.Camera([1, 1, 1], data=YUYV, counts=False))
    assert [frame.header.seq for frame in taken.frames] == [0, 1, 2]
    assert taken.losses == {}


def test_a_camera_that_is_unplugged_takes_part_again() -> None:
    taken = Taken(v4l2_kernel.Camera([1, 1, "gone", 1, 1], data=YUYV))
    assert [frame.header.seq for frame in taken.frames] == [0, 1, 2, 3]
    gone, back, *_ = taken.warnings
    assert gone == "camera 0: No such device; connecting again until it answers"
    assert back.startswith("camera 0: is back after ")
    assert taken.losses == {}


def test_a_camera_that_stays_still_is_gone() -> None:
    taken = Taken(v4l2_kernel.Camera([1, *["still"] * 3, 1], data=YUYV), read_timeout=1e-9)
    assert len(taken.frames) == 2
    assert "no picture came for 1e-09 s" in taken.warnings[0]


def test_a_camera_that_is_not_there_is_tried_again() -> None:
    taken = Taken(v4l2_kernel.Camera([]), device="/dev/v4l/by-id/usb-cam")
    assert taken.frames == []
    assert taken.warnings == [
        "camera /dev/v4l/by-id/usb-cam: No such file or directory; connecting again until it answers"
    ]


def test_the_kernel_of_this_computer_maps_and_waits(tmp_path: Path) -> None:
    path = tmp_path / "memory"
    path.write_bytes(bytes(range(256)) * 32)
    kernel = Linux()
    file = kernel.open(str(path))
    np.testing.assert_array_equal(kernel.map(file, 100, mmap.ALLOCATIONGRANULARITY)[:4], [0, 1, 2, 3])
    kernel.close(file)
    reader, writer = os.pipe()
    assert not kernel.wait(reader, 0.0)
    os.write(writer, b"picture")
    assert kernel.wait(reader, 60.0)
    os.close(writer)
    kernel.close(reader)
