"""Grants of a host: cameras by number and local receivers always, all others if the owner grants them."""

from __future__ import annotations

from typing import Any

import pytest

from followspot.errors import FollowspotError
from followspot.graph.plan import PlannedStage
from followspot.security.grants import Grants


def stage(uses: str, **params: Any) -> PlannedStage:
    return PlannedStage("it", "it", uses, params, None, "main", live=True)


def granted(asked: PlannedStage, **grants: tuple[str, ...]) -> bool:
    """True if the stage is granted; a refusal must name the option that grants it."""
    told = ""
    try:
        Grants(**grants).check(asked)  # type: ignore[arg-type]
    except FollowspotError as error:
        told = str(error)
    assert not told or ("stage it would" in told and "followspot agent --" in told)
    return not told


@pytest.mark.parametrize("host", ["127.0.0.1", "127.9.9.9", "localhost", "LocalHost", "::1"])
@pytest.mark.parametrize("uses", ["sinks.udp_json", "sinks.osc", "sinks.osc_poses"])
def test_sending_to_this_host_is_granted(uses: str, host: str) -> None:
    assert granted(stage(uses, host=host))


@pytest.mark.parametrize(
    "host",
    ["203.0.113.9", "0.0.0.0", "255.255.255.255", "evil.example", "127.1", "2130706433", "236.10.10.10"],
)
@pytest.mark.parametrize("uses", ["sinks.udp_json", "sinks.osc", "sinks.psn", "sinks.psn_poses"])
def test_sending_elsewhere_needs_a_grant(uses: str, host: str) -> None:
    assert not granted(stage(uses, host=host))
    assert not granted(stage(uses, host=host), send_to=("10.0.0.7",), opens=("any",))
    assert granted(stage(uses, host=host), send_to=("10.0.0.7", host))
    assert granted(stage(uses, host=host), send_to=("any",))


@pytest.mark.parametrize(
    ("viewer", "fits"),
    [
        ("", True),
        ("rerun+http://127.0.0.1:9876/proxy", True),
        ("rerun+http://10.0.0.7:9876/proxy", True),
        ("rerun+http://evil.example/10.0.0.7", False),
        ("rerun+http://10.0.0.7@evil.example/", False),
        ("rerun+http://[::1", False),
    ],
)
def test_the_host_of_an_address_counts(viewer: str, fits: bool) -> None:
    assert granted(stage("sinks.rerun", viewer=viewer), send_to=("10.0.0.7",)) == fits


@pytest.mark.parametrize("device", [0, 3, 99])
def test_cameras_by_number_are_granted(device: int) -> None:
    assert granted(stage("cameras.device", device=device))


@pytest.mark.parametrize(
    "device", [100, 1900, -1, True, "0", "/dev/video0", "/etc/shadow", "http://evil.example/", "", [0]]
)
def test_other_devices_need_a_grant(device: Any) -> None:
    assert not granted(stage("cameras.device", device=device))
    assert not granted(stage("cameras.device", device=device), opens=("/dev/snd", "rtsp://10.0.0.9"))
    assert granted(stage("cameras.device", device=device), opens=("any",))


@pytest.mark.parametrize(
    ("device", "fits"),
    [
        ("/dev/v4l/by-id/usb-cam", True),
        ("/dev/v4l", True),
        ("/dev/v4l/../input/event0", False),
        ("/dev/v4lx", False),
        ("/dev//v4l/./a", True),
        ("dev/v4l/a", False),
        ("/dev/v4l/a\0b", False),
    ],
)
def test_a_device_below_a_granted_path_is_granted(device: str, fits: bool) -> None:
    assert granted(stage("cameras.device", device=device), opens=("/dev/v4l/",)) == fits


@pytest.mark.parametrize(
    ("url", "fits"),
    [
        ("rtsp://10.0.0.9/left", True),
        ("rtsp://user:word@10.0.0.9:554/left/sub", True),
        ("rtsp://10.0.0.9/leftover", False),
        ("rtsp://10.0.0.9/left/../admin", False),
        ("rtsp://10.0.0.90/left", False),
        ("rtsp://10.0.0.9@evil.example/left", False),
        ("http://10.0.0.9/left", False),
        ("http://10.0.0.8:8080/any", True),
        ("http://10.0.0.8:22/", False),
        ("http://10.0.0.8/", False),
        ("rtsp://[::1", False),
        ("rtsp://10.0.0.9:99999/left", False),
        ("/left", False),
    ],
)
def test_a_stream_below_a_granted_address_is_granted(url: str, fits: bool) -> None:
    opens = ("rtsp://10.0.0.9/left", "http://10.0.0.8:8080")
    assert granted(stage("cameras.stream", url=url), opens=opens) == fits


@pytest.mark.parametrize(("host", "fits"), [("127.0.0.1", True), ("0.0.0.0", False), ("10.0.0.3", True)])
def test_a_stage_listens_to_networks_that_the_owner_named(host: str, fits: bool) -> None:
    assert granted(stage("imu.osc", host=host), opens=("10.0.0.3",)) == fits
    assert granted(stage("imu.osc", host=host), opens=("any",))
    assert granted(stage("imu.osc", host=host)) == (host == "127.0.0.1")
