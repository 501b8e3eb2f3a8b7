"""All cameras of a room triggered at once: by software, by action commands, by a line."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from itertools import islice
from typing import Any

import numpy as np
import pytest
from tests.plugins.cameras.genicam_port import own_port
from tests.plugins.cameras.recordings import context

from followspot import Context, InputError, Room
from followspot.room import Sync, Trigger
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
    assert [frame.header.seq for frame in frames] == list(range(5))
    assert triggers >= 5
    assert times[-1] - times[0] > 120e6  # by itself the camera takes five pictures in 67 ms


@pytest.mark.parametrize(("key", "acts"), [(testing.FakeGigeCamera.DEVICE_KEY, True), (7, False)])
def test_the_leading_camera_sends_action_commands(key: int, acts: bool) -> None:
    warnings: list[str] = []
    known = testing.FakeGigeCamera
    sync = Sync("action", "cam3", 50.0, key, known.GROUP_KEY, known.GROUP_MASK)

    with own_port(), testing.FakeGigeCamera(width=SIZE[0], height=SIZE[1], fps=60) as fake:
        with firing(action_commands(sync, warnings.append), sync.rate):
            until = time.monotonic() + 3
            while not (fake.actions() if acts else warnings) and time.monotonic() < until:
                time.sleep(0.02)
        assert bool(fake.actions()) is acts
    assert any("no camera acknowledges its action commands" in text for text in warnings) is not acts


def action_commands(sync: Sync, say: Callable[[str], None]) -> ActionCommands:
    from followspot_cameras.genicam.viva import send_action

    return ActionCommands(sync, send_action, "127.0.0.1", say)


def test_a_camera_that_knows_no_action_commands_is_refused() -> None:
    wrong = r'has no feature "ActionDeviceKey"(.|\n)*cannot be "Action1"'
    with (
        own_port(),
        testing.FakeGigeCamera(width=SIZE[0], height=SIZE[1], fps=60),
        pytest.raises(InputError, match=wrong),
    ):
        next(iter(stage(Sync("action", "cam3", 20.0)).process()))


def test_action_commands_need_the_program_that_sends_them() -> None:
    with pytest.raises(InputError, match=r"not installed(.|\n)*pip install 'followspot\[genicam\]'"):
        ActionCommands(Sync("action", "cam3", 20.0), None, "", print)


def test_action_commands_go_to_all_cameras_of_the_network() -> None:
    sent: list[tuple[Any, ...]] = []
    sync = Sync("action", "a", 20.0, 5, 6, 7)
    command = ActionCommands(sync, lambda *given: sent.append(given) or 1, "10.0.0.2", print)

    command()
    command()
    assert sent == [(5, 6, 7, "255.255.255.255", 200), (5, 6, 7, "255.255.255.255", 1)]


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
        assert called.wait(2)
        called.clear()
        assert not called.wait(0.05)
    assert len(calls) == 1
