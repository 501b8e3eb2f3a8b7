"""Devices and network streams: capture at grab, loss, recovery, prompt stop."""

import os
import re
import threading
import time
from collections.abc import Iterator
from dataclasses import replace
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from itertools import islice
from pathlib import Path

import cv2
import pytest
from pydantic import ValidationError
from tests.plugins.cameras.recordings import context, numbers, picture, record

from followspot import InputError, Room
from followspot_cameras import reconnection
from followspot_cameras.live import Capture, CaptureCamera
from followspot_cameras.stream import Stream, public_address
from followspot_cameras.v4l2.stage import Device


class Unplugged:
    """A device that is not there."""

    def isOpened(self) -> bool:  # noqa: N802
        return False

    def grab(self) -> bool:
        raise AssertionError("a device that is not open is never grabbed")

    def retrieve(self, image=None, /):
        raise AssertionError

    def release(self) -> None:
        """Nothing to release."""


class Replugged(CaptureCamera):
    """A camera that plays a video, is then gone for two attempts, and plays again."""

    origin = "camera 7"

    def __init__(self, *args: object, path: Path) -> None:
        super().__init__(*args)
        video = str(path)
        self.attempts: Iterator[Capture] = iter(
            [cv2.VideoCapture(video), Unplugged(), Unplugged(), cv2.VideoCapture(video)]
        )

    def connect(self) -> Capture:
        return next(self.attempts, Unplugged())


@pytest.fixture(autouse=True)
def _short_waits(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reconnection, "FIRST_WAIT", 0.001)


def test_lost_camera_comes_back_and_both_are_reported_once(tmp_path: Path) -> None:
    warnings: list[str] = []
    camera = Replugged(context(warn=warnings.append), path=record(tmp_path / "a.mkv", frames=3))
    frames = camera.process()
    assert [numbers(next(frames).pixels) for _ in range(6)] == [0, 1, 2, 0, 1, 2]
    frames.close()
    gone, back = warnings
    assert gone == "camera 7: no picture came; connecting again until it answers"
    assert re.fullmatch(r"camera 7: is back after \d+\.\d s", back)


def test_a_camera_that_vanishes_again_and_again_tells_how_often() -> None:
    said: list[str] = []

    def session() -> Iterator[int]:
        yield 1
        raise ConnectionError("gone")

    assert list(islice(reconnection.sessions(session, threading.Event(), said.append), 4)) == [1] * 4
    often = [re.sub(r"is back after \d+\.\d s", "", text) for text in said[1::2]]
    assert often == ["", "; it was away 2 times", "; it was away 3 times"]


def test_capture_time_is_that_of_the_grab(tmp_path: Path) -> None:
    camera = Replugged(context(), path=record(tmp_path / "a.mkv", frames=3))
    before = time.time_ns()
    frames = camera.process()
    times = [next(frames).header.time for _ in range(3)]
    assert before <= times[0] <= times[1] <= times[2] <= time.time_ns()
    frames.close()


def test_waits_double_up_to_a_limit_and_start_anew_after_a_picture(tmp_path: Path) -> None:
    class Clock(threading.Event):
        def __init__(self) -> None:
            super().__init__()
            self.waits: list[float] = []

        def wait(self, timeout: float | None = None) -> bool:
            self.waits.append(timeout or 0.0)
            if len(self.waits) == 6:
                self.set()
            return self.is_set()

    camera = Replugged(context(), path=record(tmp_path / "a.mkv", frames=1))
    camera.attempts = iter([Unplugged(), Unplugged(), next(camera.attempts)])
    camera.stopped = clock = Clock()
    assert len(list(camera.process())) == 1
    assert clock.waits == [0.001, 0.002, 0.001, 0.002, 0.004, 0.008]


def test_close_from_another_thread_ends_the_wait_for_a_lost_camera(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reconnection, "FIRST_WAIT", 600.0)
    lost = threading.Event()

    class Gone(CaptureCamera):
        origin = "camera 7"

        def connect(self) -> Capture:
            return Unplugged()

    camera = Gone(context(warn=lambda text: lost.set()))
    thread = threading.Thread(target=lambda: list(camera.process()), daemon=True)
    thread.start()
    assert lost.wait(60)
    camera.close()
    thread.join(60)
    assert not thread.is_alive()


@pytest.mark.parametrize("device", ["rtsp://a/b", "video.mkv", "file:///dev/video0", -1, 700])
def test_what_cannot_be_a_device_is_refused(device: int | str) -> None:
    with pytest.raises(ValidationError):
        Device(context(), device=device)


@pytest.mark.parametrize(("make", "what"), [("touch", "a file"), ("mkdir", "a folder"), ("mkfifo", "a pipe")])
def test_a_path_to_something_else_is_refused_before_and_in_a_run(
    tmp_path: Path, make: str, what: str
) -> None:
    path = tmp_path / "camera"
    os.mkfifo(path) if make == "mkfifo" else getattr(path, make)()
    device = Device(context(), device=str(path))
    (mistake,) = Device.check_files(device.params, device.room, None)
    assert mistake.text == f"device: {path} is {what}, no camera"
    with pytest.raises(InputError, match=f"{path} is {what}, no camera"):
        next(device.process())
    assert not list(Device.check_files(Device.Params(device="/dev/null"), device.room, None))


def test_a_camera_that_is_not_there_is_told_before_a_run_unless_another_host_has_it() -> None:
    params = Device.Params(device="/dev/no-such-camera")
    here = context()
    (mistake,) = Device.check_files(params, here.room, here.member)
    assert mistake.warning
    assert mistake.text == "device: /dev/no-such-camera is not there; the run waits for it"
    elsewhere = Room(cameras={"cam3": replace(here.room.cameras["cam3"], host="pc-left")})
    assert not list(Device.check_files(params, elsewhere, here.member))


class Mjpeg(BaseHTTPRequestHandler):
    """Serves three pictures as motion JPEG, then hangs up."""

    def do_GET(self) -> None:
        self.send_response(200)
        self.send_header("Content-Type", "multipart/x-mixed-replace; boundary=next")
        self.end_headers()
        for number in (10, 20, 30):
            _, jpeg = cv2.imencode(".jpg", picture(number))
            head = f"--next\r\nContent-Type: image/jpeg\r\nContent-Length: {jpeg.size}\r\n\r\n"
            self.wfile.write(head.encode() + jpeg.tobytes() + b"\r\n")
        self.wfile.write(b"--next--\r\n")

    def log_message(self, *args: object) -> None:
        """Keep the test's output clean."""


@pytest.fixture
def server() -> Iterator[str]:
    with ThreadingHTTPServer(("127.0.0.1", 0), Mjpeg) as http:
        threading.Thread(target=http.serve_forever, daemon=True).start()
        yield f"http://viewer:secret@127.0.0.1:{http.server_port}/video.mjpg"
        http.shutdown()


def test_stream_that_hangs_up_is_opened_again(server: str) -> None:
    warnings: list[str] = []
    stream = Stream(context(warn=warnings.append), url=server, open_timeout=60, read_timeout=60)
    frames = stream.process()
    seen = [numbers(next(frames).pixels) for _ in range(4)]
    stream.close()
    frames.close()
    assert seen == [10, 20, 30, 10]
    assert len(warnings) == 2
    assert not any("secret" in text for text in warnings)


@pytest.mark.parametrize("url", ["/etc/passwd", "file:///a.mkv", "concat:a|b", "rtsp://", "data:,x", "HTTP"])
def test_only_network_addresses_are_streams(url: str) -> None:
    with pytest.raises(ValidationError):
        Stream(context(), url=url)


def test_address_is_shown_without_credentials() -> None:
    assert public_address("rtsp://u:p@[::1]:554/a?token=1") == "rtsp://[::1]:554/a"
