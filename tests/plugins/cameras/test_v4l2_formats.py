"""Pixel formats, rates and controls of V4L2 devices."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from tests.plugins.cameras import v4l2_kernel
from tests.plugins.cameras.recordings import SIZE, context
from tests.plugins.cameras.v4l2_devices import GRAY, JPEG, YUYV, Taken

from followspot import InputError
from followspot_cameras import reconnection
from followspot_cameras.v4l2.stage import Device

GREEN = (60, 200, 40)


@pytest.fixture(autouse=True)
def _short_waits(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reconnection, "FIRST_WAIT", 0.001)


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
