"""All cameras of a room triggered at once: by software, by action commands, by a line."""

from __future__ import annotations

import socket
import struct
import threading
import time
from collections.abc import Callable
from contextlib import ExitStack
from itertools import islice
from typing import Any

import numpy as np
import pytest
from tests.plugins.cameras.attempts import one_of
from tests.plugins.cameras.genicam_port import own_port
from tests.plugins.cameras.recordings import context

from followspot import Context, InputError, Room
from followspot.room import Sync, Trigger
from followspot_cameras.genicam import broadcast
from followspot_cameras.genicam.action_command import PORT, _acknowledgements, send_action
from followspot_cameras.genicam.broadcast import SIOCGIFADDR, SIOCGIFNETMASK, broadcast_address
from followspot_cameras.genicam.triggers import (
    ActionCommands,
    firing,
    next_moment,
    trigger_features,
)

testing = pytest.importorskip("viva_genicam.testing", reason="viva-genicam is not installed")
from followspot_cameras.genicam.stage import Genicam  # noqa: E402

SIZE = (160, 120)
NAMES = ("TriggerSelector", "TriggerMode", "TriggerSource", "ActionSelector")
WAITS = {"TriggerSelector": "FrameStart", "TriggerSource": "Line1", "TriggerMode": "On"}
MOMENT = 1_700_000_000_000_000_000


def stage(sync: Sync, warn: Callable[[str], None] = print, **params: Any) -> Genicam:
    camera = context("color", SIZE).room.cameras["cam3"]
    found = Context.serving(camera, Room(cameras={"cam3": camera}, sync=sync), name="camera/cam3", warn=warn)
    where = {"camera": "127.0.0.1", "backend": "viva-genicam", "interface": "127.0.0.1"}
    return Genicam(found, **where, **params)


def test_a_camera_is_triggered_by_software_at_the_moments_of_all_hosts() -> None:
    with own_port(), testing.FakeGigeCamera(width=SIZE[0], height=SIZE[1], fps=60) as fake:
        source = stage(Sync("software", rate=20))
        frames = list(islice(source.process(), 5))
        source.close()
        triggers = fake.software_triggers()
    times = np.array([frame.header.time for frame in frames])
    numbers = [frame.header.seq for frame in frames]
    assert numbers == sorted(set(numbers))
    assert triggers >= 5
    assert times[-1] - times[0] > 120e6  # by itself the camera takes five pictures in 67 ms


@pytest.mark.parametrize(("key", "acts"), [(testing.FakeGigeCamera.DEVICE_KEY, True), (7, False)])
def test_the_leading_camera_sends_action_commands(key: int, acts: bool) -> None:
    warnings: list[str] = []
    known = testing.FakeGigeCamera
    sync = Sync("action", "cam3", 50.0, key, known.GROUP_KEY, known.GROUP_MASK)

    with own_port(), testing.FakeGigeCamera(width=SIZE[0], height=SIZE[1], fps=60) as fake:
        with firing(ActionCommands(sync, "127.0.0.1", warnings.append), sync.rate):
            until = time.monotonic() + 60
            while not (fake.actions() if acts else warnings) and time.monotonic() < until:
                time.sleep(0.02)
        assert bool(fake.actions()) is acts
    assert any("no camera acknowledges its action commands" in text for text in warnings) is not acts


def test_a_camera_that_knows_no_action_commands_is_refused() -> None:
    wrong = r'has no feature "ActionDeviceKey"(.|\n)*cannot be "Action1"'
    with (
        own_port(),
        testing.FakeGigeCamera(width=SIZE[0], height=SIZE[1], fps=60),
        pytest.raises(InputError, match=wrong),
    ):
        next(iter(stage(Sync("action", "cam3", 20.0)).process()))


def test_action_commands_go_to_all_cameras_of_the_network_each_with_a_number() -> None:
    sent: list[tuple[Any, ...]] = []
    sync = Sync("action", "a", 20.0, 5, 6, 7)
    command = ActionCommands(sync, "", print, lambda *given: sent.append(given) or 1)
    for _ in range(65_536):
        command()
    keys, everywhere = (5, 6, 7), "255.255.255.255"
    assert sent[:2] == [(keys, everywhere, 1, 0.2), (keys, everywhere, 2, 0.0)]
    assert [number for _, _, number, _ in sent[-2:]] == [65_535, 1]


def test_action_commands_that_cannot_be_sent_are_told_once_and_go_on() -> None:
    said: list[str] = []

    def unreachable(*given: Any) -> int:
        raise OSError("Network is unreachable")

    command = ActionCommands(Sync("action", "a", 20.0), "", said.append, unreachable)
    command()
    command()
    (text,) = said
    assert "cannot be sent to 255.255.255.255 (Network is unreachable)" in text
    assert "`interface`" in text


def test_an_action_command_has_the_form_of_gige_vision() -> None:
    with own_port(), socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as camera:
        camera.bind(("127.0.0.1", PORT))
        assert send_action((5, 6, 7), "127.0.0.1", 9, 0.0) == 0
        send_action((5, 6, 7), "127.0.0.1", 10, 1e-3)
        found = [camera.recv(100) for _ in range(2)]
    assert found[0] == struct.pack(">BBHHHIII", 0x42, 0, 0x100, 12, 9, 5, 6, 7)
    assert found[1] == struct.pack(">BBHHHIII", 0x42, 1, 0x100, 12, 10, 5, 6, 7)


def test_cameras_that_acknowledge_the_command_are_counted_once() -> None:
    def attempt() -> bool:
        with ExitStack() as open_sockets:
            here, left, right = (
                open_sockets.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) for _ in range(3)
            )
            here.bind(("127.0.0.1", 0))
            answers = [(left, 0, 9), (left, 0, 9), (right, 0, 8), (right, 0x8001, 9), (right, 0, 9)]
            for camera, status, number in answers:
                camera.sendto(struct.pack(">HHHH", status, 0x101, 0, number), here.getsockname())
            return _acknowledgements(here, 9, 0.1) == 2

    assert one_of(4, attempt)


def test_commands_for_a_network_go_to_its_broadcast_address(monkeypatch: pytest.MonkeyPatch) -> None:
    told = {("eth1", SIOCGIFADDR): "192.168.4.9", ("eth1", SIOCGIFNETMASK): "255.255.252.0"}
    monkeypatch.setattr(broadcast.socket, "if_nameindex", lambda: [(1, "lo"), (2, "eth1")])
    monkeypatch.setattr(broadcast, "_asked", lambda *question: told.get(question, ""))
    assert broadcast_address("192.168.4.9") == "192.168.7.255"
    assert broadcast_address("192.168.4.8") == "255.255.255.255"
    assert broadcast_address("127.0.0.1") == "127.0.0.1"


@pytest.mark.parametrize(
    ("trigger", "camera", "expected"),
    [
        ("line", "lead", {}),
        ("line", "other", WAITS),
        (
            "software",
            "lead",
            {"TriggerSelector": "FrameStart", "TriggerSource": "Software", "TriggerMode": "On"},
        ),
        (
            "action",
            "lead",
            {
                "TriggerSelector": "FrameStart",
                "ActionSelector": 1,
                "ActionDeviceKey": 5,
                "ActionGroupKey": 6,
                "ActionGroupMask": 7,
                "TriggerSource": "Action1",
                "TriggerMode": "On",
            },
        ),
    ],
)
def test_features_that_wait_for_the_trigger(trigger: Trigger, camera: str, expected: dict[str, Any]) -> None:
    sync = Sync(trigger, "lead", 20.0, 5, 6, 7)
    found = trigger_features(sync, camera, NAMES)
    assert list(found.items()) == list(expected.items())
    assert trigger_features(None, camera, NAMES) == {}
    assert not {"TriggerSelector", "ActionSelector"} & set(trigger_features(sync, camera, ()))


def test_moments_are_whole_periods_since_1970() -> None:
    assert next_moment(MOMENT, 20.0) == MOMENT + 50_000_000
    assert next_moment(MOMENT + 1, 20.0) == MOMENT + 50_000_000
    assert next_moment(MOMENT + 49_999_999, 20.0) == MOMENT + 50_000_000
    thirds = [next_moment(MOMENT + k * 33_333_334, 30.0) - MOMENT for k in range(3)]
    assert thirds == [33_333_333, 66_666_666, 100_000_000]


def test_a_camera_that_is_gone_ends_the_triggers() -> None:
    calls: list[int] = []
    called = threading.Event()

    def fire() -> None:
        calls.append(1)
        called.set()
        raise ConnectionError("gone")

    with firing(fire, 1000.0):
        assert called.wait(60)
        called.clear()
        assert not called.wait(0.05)
    assert len(calls) == 1
