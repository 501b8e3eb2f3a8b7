"""A GigE Vision camera on loopback (of viva-genicam) that loses packets to order, vanishes and comes back."""

from __future__ import annotations

import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
from tests.plugins.cameras.attempts import one_of
from tests.plugins.cameras.genicam_port import own_port
from tests.plugins.cameras.recordings import context

import followspot as fs
from followspot import Context, InputError
from followspot.tracking import Frame

testing = pytest.importorskip("viva_genicam.testing", reason="viva-genicam is not installed")
from followspot_cameras.genicam import backends  # noqa: E402
from followspot_cameras.genicam.stage import Genicam  # noqa: E402

SIZE = (160, 120)


@pytest.fixture
def fake_camera() -> Iterator[Callable[..., Any]]:
    """Starts cameras on the one port that they have, which other test processes use, too."""
    with own_port():
        yield lambda **rest: testing.FakeGigeCamera(width=SIZE[0], height=SIZE[1], fps=60, **rest)


def stage(kind: str = "color", found: Context | None = None, **params: Any) -> Genicam:
    return Genicam(
        found or context(kind, SIZE),
        camera="127.0.0.1",
        backend="viva-genicam",
        interface="127.0.0.1",
        **params,
    )


def frames(source: Genicam, count: int) -> list[Frame]:
    found = list(islice(source.process(), count))
    source.close()
    return found


def taken_apart(source: Iterator[Frame]) -> list[Frame]:
    """Pictures that waited together for their reader, and all those before them.

    On a busy machine the fake stands still now and then, and takes some at once itself: not all of the time.
    """
    found = [next(source)]
    for _ in range(40):
        time.sleep(0.1)
        found += islice(source, 9)
        if (np.diff([frame.header.time for frame in found[-9:]]) > 10e6).all():
            return found
    pytest.fail("pictures have the times at which they were read")


def test_pictures_have_the_numbers_and_the_intervals_of_the_camera(fake_camera: Callable[..., Any]) -> None:
    lost: list[int] = []
    counting = replace(context("color", SIZE), lost=lambda kind, number: lost.append(number))
    with fake_camera():
        before = time.time_ns()
        source = stage(found=counting)
        found = taken_apart(source.process())
        source.close()
    times = [frame.header.time for frame in found]
    numbers = [frame.header.seq for frame in found]
    assert numbers == sorted(set(numbers))
    assert numbers[-1] + 1 == len(found) + sum(lost)  # a busy machine may lose some, and counts them
    assert before < times[0]
    assert times[-1] < time.time_ns()
    assert found[0].pixels.shape == (120, 160, 3)
    assert found[0].pixels.std() > 10


def test_ordered_losses_stand_in_the_ledger_to_the_number(fake_camera: Callable[..., Any]) -> None:
    def attempt() -> bool:
        lost: Counter[str] = Counter()
        counting = replace(context("color", SIZE), lost=lambda kind, number: lost.update({kind: number}))
        with fake_camera(packet_resend=False, drop_packets=[(3, 1), (5, 0), (5, 2)]):
            numbers = [frame.header.seq for frame in frames(stage(found=counting), 6)]
        lost_as_ordered = dict(lost) == {"packet_loss": 2, "gap": 0, "device_overrun": 0}
        return lost_as_ordered and numbers == [0, 1, 3, 5, 6, 7]

    assert one_of(4, attempt)


def test_packets_that_are_sent_again_lose_nothing(fake_camera: Callable[..., Any]) -> None:
    def attempt() -> bool:
        with fake_camera(packet_resend=True, drop_packets=[(2, 1)]):
            return [frame.header.seq for frame in frames(stage(), 4)] == [0, 1, 2, 3]

    assert one_of(4, attempt)


def test_features_are_set_in_the_camera(fake_camera: Callable[..., Any]) -> None:
    with fake_camera() as camera:
        found = frames(stage("infrared", features={"PixelFormat": "Mono16", "ExposureTime": 750}), 1)
        exposure = camera.peek(camera.REGISTERS["ExposureTime"], 8)
    assert np.frombuffer(exposure, ">f8")[0] == 750.0
    assert found[0].pixels.shape == (120, 160, 1)


@pytest.mark.parametrize("backend", ["viva-genicam", "aravis"])
def test_chunks_behind_a_picture_are_no_pixels(fake_camera: Callable[..., Any], backend: str) -> None:
    if not backends.backends(cast(backends.BackendName, backend)):
        pytest.skip(f"{backend} is not installed")
    chunks = {"ChunkModeActive": True, "ChunkSelector": "FrameID", "ChunkEnable": True}
    where = {"camera": "127.0.0.1", "backend": backend, "interface": "127.0.0.1"}
    with fake_camera():
        found = frames(Genicam(context("infrared", SIZE), features=chunks, **where), 2)
    assert found[0].pixels.shape == (120, 160, 1)
    assert found[0].header.time < found[1].header.time


def test_features_that_the_camera_has_not_are_refused_with_a_guess(fake_camera: Callable[..., Any]) -> None:
    with fake_camera(), pytest.raises(InputError) as caught:
        frames(stage(features={"ExposureTim": 5, "PixelFormat": "Mono9", "Width": 9}), 1)
    text = " ".join(f"{mistake.text} {mistake.help}" for mistake in caught.value.mistakes)
    assert len(caught.value.mistakes) == 3
    assert 'did you mean "ExposureTime"?' in text
    assert 'did you mean "Mono8"?' in text
    assert "write a number from 16 to 4096" in text


@pytest.mark.parametrize("name", ["BayerRG8", "Mono12p", "RGB8"])
def test_other_formats_become_the_same_picture(fake_camera: Callable[..., Any], name: str) -> None:
    with fake_camera(pixel_format=name):
        (found,) = frames(stage(), 1)
    assert found.pixels.shape == (120, 160, 3)
    assert found.pixels.std() > 10


def test_a_camera_that_vanishes_takes_part_again_within_three_seconds(
    fake_camera: Callable[..., Any],
) -> None:
    def attempt() -> bool:
        warnings: list[str] = []
        source = stage(found=context("color", SIZE, warn=warnings.append), read_timeout=0.3)
        pictures = source.process()
        with fake_camera():
            first = list(islice(pictures, 3))
        with fake_camera():
            back = time.monotonic()
            again = next(pictures)
            took = time.monotonic() - back
        source.close()
        assert again.header.time > first[-1].header.time
        assert again.header.seq > first[-1].header.seq
        assert "connecting again until it answers" in warnings[0]
        assert warnings[-1].startswith("camera 127.0.0.1: is back after ")
        return took < 3.0

    assert one_of(4, attempt)


def test_a_serial_number_names_the_camera_and_another_is_not_in_sight(
    fake_camera: Callable[..., Any],
) -> None:
    told = "not in sight; cameras in sight: viva-genicam FakeGigE VIVA-FAKE-001 at 127.0.0.1"

    def attempt() -> bool:
        warnings: list[str] = []
        other = Genicam(context("color", SIZE), camera="77", interface="127.0.0.1")
        other.context = replace(other.context, warn=lambda text: (warnings.append(text), other.close()))
        assert frames(other, 1) == []
        return told in warnings[0]

    with fake_camera():
        found = Genicam(context("color", SIZE), camera="VIVA-FAKE-001", interface="127.0.0.1")
        assert len(frames(found, 1)) == 1
        assert one_of(10, attempt)


def test_a_camera_that_another_program_controls_is_waited_for(fake_camera: Callable[..., Any]) -> None:
    warnings: list[str] = []
    with fake_camera():
        first, second = stage(), stage(found=context("color", SIZE, warn=warnings.append))
        pictures = first.process()
        next(pictures)
        waiting = second.process()
        taken = threading.Thread(target=lambda: next(waiting), daemon=True)
        taken.start()
        while not warnings:
            next(pictures)
        pictures.close()
        taken.join(60)
        waiting.close()
    assert "another program controls it" in warnings[0]
    assert "is back" in warnings[-1]


class Seen(fs.Stage):
    """Takes the pictures."""

    def process(self, frame: Frame) -> None: ...


ROOM = """
room: one
cameras:
  left:
    kind: color
    size: [160, 120]
    matrix: [[100, 0, 80], [0, 100, 60], [0, 0, 1]]
    distortion: [0, 0, 0, 0, 0]
    rotation: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
    translation: [0, 0, 0]
    source: {uses: cameras.genicam, with: {camera: 127.0.0.1, interface: 127.0.0.1, backend: viva-genicam}}
"""


def test_a_run_says_which_frames_were_lost_at_the_source(
    fake_camera: Callable[..., Any], tmp_path: Path
) -> None:
    (tmp_path / "room.yaml").write_text(ROOM)
    graph = fs.Graph("seen", room=tmp_path / "room.yaml")
    graph.add("seen", Seen, each="cameras", frame=graph.add("camera", "room.source", each="cameras"))

    def attempt() -> bool:
        camera = fake_camera(packet_resend=False, drop_packets=[(2, 1), (4, 1), (6, 1)])
        with camera, fs.run(graph, out=tmp_path / str(time.monotonic_ns()), frames=7) as run:
            report = run.wait()
        (edge,) = report.ledger
        assert edge["produced"] == 7
        return (edge["packet_loss"], edge["device_overrun"], edge["gap"]) == (3, 0, 0)

    assert one_of(4, attempt)


def test_a_camera_that_ended_the_control_takes_part_again(fake_camera: Callable[..., Any]) -> None:
    """As cameras do when their computer was too busy for the heartbeat."""
    warnings: list[str] = []
    source = stage(found=context("color", SIZE, warn=warnings.append))
    pictures = source.process()
    with fake_camera() as camera:
        next(pictures)
        camera.revoke_control()
        for _ in pictures:
            if any("is back" in text for text in warnings):
                break
        source.close()
        assert camera.controller()
    assert "control of the camera was lost" in warnings[0]
