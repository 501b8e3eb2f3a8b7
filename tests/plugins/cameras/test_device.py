"""Cameras of this host through V4L2: numbers and times of the driver, formats and controls by name."""

from __future__ import annotations

import ctypes
import mmap
import os
import time
from collections import Counter
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from tests.plugins.cameras import v4l2_kernel
from tests.plugins.cameras.recordings import SIZE, context, numbers, picture

from followspot import InputError
from followspot.frame_times import SECOND
from followspot.tracking import Frame
from followspot_cameras import reconnection
from followspot_cameras.v4l2 import layout
from followspot_cameras.v4l2.kernel import Linux
from followspot_cameras.v4l2.stage import Device
from followspot_cameras.v4l2.video_device import driver_time

GRAY = picture(9)[..., 0]
YUYV = np.stack([GRAY, np.full_like(GRAY, 128)], axis=-1).tobytes()
JPEG = cv2.imencode(".jpg", picture(9))[1].tobytes()


@pytest.fixture(autouse=True)
def _short_waits(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reconnection, "FIRST_WAIT", 0.001)


class Taken:
    """What a device gives until its camera is gone for good."""

    def __init__(
        self, camera: v4l2_kernel.Camera, kind: str = "color", count: int = 99, **params: Any
    ) -> None:
        self.lost: Counter[str] = Counter()
        self.warnings: list[str] = []
        self.camera = camera
        base = context(kind, warn=self._warned)
        self.device = Device(replace(base, lost=lambda kind, n: self.lost.update({kind: n})), **params)
        self.device.kernel = camera  # type: ignore[misc]
        self.frames: list[Frame] = list(islice(self.device.process(), count))

    def _warned(self, text: str) -> None:
        self.warnings.append(text)
        if not self.camera.steps:
            self.device.close()

    @property
    def losses(self) -> dict[str, int]:
        return {kind: number for kind, number in self.lost.items() if number}


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


GREEN = (60, 200, 40)


def of(fourcc: str) -> bytes:
    """A green picture in a format."""
    bgr = np.full((SIZE[1], SIZE[0], 3), GREEN, "u1")
    conversions = {"RGB3": cv2.COLOR_BGR2RGB, "YU12": cv2.COLOR_BGR2YUV_I420, "YV12": cv2.COLOR_BGR2YUV_YV12}
    if fourcc in conversions:
        return cv2.cvtColor(bgr, conversions[fourcc]).tobytes()
    if fourcc == "MJPG":
        return cv2.imencode(".jpg", bgr)[1].tobytes()
    if fourcc in ("NV12", "NV21"):
        planes = cv2.cvtColor(bgr, cv2.COLOR_BGR2YUV_I420).reshape(-1)
        luma, colors = planes[: SIZE[0] * SIZE[1]], planes[SIZE[0] * SIZE[1] :].reshape(2, -1)
        return luma.tobytes() + (colors if fourcc == "NV12" else colors[::-1]).T.tobytes()
    luma, blue, red = cv2.cvtColor(bgr, cv2.COLOR_BGR2YUV_I420).reshape(-1)[[0, -800, -1]]
    pairs = {"YUYV": (luma, blue, luma, red), "UYVY": (blue, luma, red, luma)}
    if fourcc in pairs:
        return np.tile(np.array(pairs[fourcc], "u1"), SIZE[0] * SIZE[1] // 2).tobytes()
    colors = dict(zip("BGR", GREEN, strict=True))
    rows = {"RGGB": "RGGB", "GRBG": "GRBG", "GBRG": "GBRG", "BA81": "BGGR"}
    if fourcc in rows:
        tile = np.array([colors[letter] for letter in rows[fourcc]], "u1").reshape(2, 2)
        return np.tile(tile, (SIZE[1] // 2, SIZE[0] // 2)).tobytes()
    return bgr.tobytes()


@pytest.mark.parametrize(
    "fourcc",
    ["YUYV", "UYVY", "BGR3", "RGB3", "NV12", "NV21", "YU12", "YV12", "MJPG", "RGGB", "GRBG", "GBRG", "BA81"],
)
def test_formats_become_the_same_picture(fourcc: str) -> None:
    taken = Taken(v4l2_kernel.Camera([of(fourcc)], formats=["H264", fourcc]), fourcc=fourcc)
    assert taken.frames[0].pixels.shape == (SIZE[1], SIZE[0], 3)
    np.testing.assert_allclose(taken.frames[0].pixels[4:-4, 4:-4].mean((0, 1)), GREEN, atol=3)


@pytest.mark.parametrize(
    ("fourcc", "scale", "form"), [("GREY", 1, "u1"), ("Y10 ", 4, "<u2"), ("Y16 ", 256, "<u2")]
)
def test_grey_pictures_keep_their_highest_bits(fourcc: str, scale: int, form: str) -> None:
    data = (GRAY.astype("u4") * scale).astype(form).tobytes()
    taken = Taken(v4l2_kernel.Camera([data], formats=[fourcc]), kind="infrared")
    np.testing.assert_array_equal(taken.frames[0].pixels[..., 0], GRAY)


def test_bytes_that_fill_up_lines_are_left_out() -> None:
    lines = np.pad(GRAY, ((0, 0), (0, 32)), constant_values=255)
    taken = Taken(v4l2_kernel.Camera([lines.tobytes()], formats=["GREY"], line=96), kind="infrared")
    np.testing.assert_array_equal(taken.frames[0].pixels[..., 0], GRAY)


def test_the_format_is_the_one_asked_for_the_present_one_or_one_that_can_be_read() -> None:
    for formats, asked, expected in (
        (["YUYV", "MJPG"], "MJPG", "MJPG"),
        (["MJPG", "YUYV"], "", "MJPG"),
        (["H264", "MJPG", "YUYV"], "", "YUYV"),
    ):
        camera = v4l2_kernel.Camera([JPEG if expected == "MJPG" else YUYV], formats=formats)
        assert len(Taken(camera, fourcc=asked).frames) == 1
        assert camera.fourcc == expected


@pytest.mark.parametrize(
    ("formats", "asked", "text"),
    [
        (["YUYV", "MJPG"], "MJPEG"[:4], r'cannot send "MJPE"(.|\n)*did you mean "MJPG"'),
        (["H264"], "", r"sends H264"),
        (["H264"], "H264", r'cannot send "H264"'),
    ],
)
def test_formats_that_are_not_offered_or_not_read_are_refused(
    formats: list[str], asked: str, text: str
) -> None:
    with pytest.raises(InputError, match=text):
        Taken(v4l2_kernel.Camera([1], formats=formats), fourcc=asked)


def test_a_camera_that_gives_another_size_is_refused() -> None:
    with pytest.raises(InputError, match=r"pictures of 80x60 px(.|\n)*calibrated for 64x48"):
        Taken(v4l2_kernel.Camera([1], size=(80, 60)))


def test_a_device_that_captures_no_pictures_is_refused() -> None:
    with pytest.raises(InputError, match="sends no pictures"):
        Taken(v4l2_kernel.Camera([1], capabilities=0x0480_0000))
    with pytest.raises(InputError, match="/dev/null sends no pictures"):
        next(Device(context(), device="/dev/null").process())


def test_rate_and_controls_are_set_in_order() -> None:
    camera = v4l2_kernel.Camera([1], data=YUYV)
    wanted = {
        "auto_exposure": "Manual Mode",
        "exposure_time_absolute": 100,
        "power_line_frequency": "60",
        "white_balance_automatic": False,
    }
    Taken(camera, fps=29.97, controls=wanted)
    assert camera.rate == (1001, 30000) or camera.rate[1] / camera.rate[0] == pytest.approx(29.97, abs=1e-4)
    assert camera.set == [(0x009A0901, 1), (0x009A0902, 100), (0x00980918, 1), (0x0098090C, 0)]


def test_controls_that_the_camera_has_not_are_refused_with_a_guess() -> None:
    camera = v4l2_kernel.Camera([1], data=YUYV)
    wanted = {
        "auto_exposur": 1,
        "auto_exposure": "Manual",
        "exposure_time_absolute": 9999,
        "gain": 3,
        "old": 1,
    }
    with pytest.raises(InputError) as caught:
        Taken(camera, controls=wanted)
    texts = [f"{mistake.text} {mistake.help}" for mistake in caught.value.mistakes]
    assert len(texts) == 5
    assert 'has no control "auto_exposur" did you mean "auto_exposure"?  its controls: ' in texts[0]
    assert 'did you mean "Manual Mode"?' in texts[1]
    assert "write a number from 3 to 2047" in texts[2]
    assert "gain of camera 0 cannot be set" in texts[3]
    assert 'no control "old"' in texts[4]
    assert camera.set == []


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
