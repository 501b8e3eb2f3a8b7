"""The cameras of Aravis and of viva-genicam, two at once, each in a network namespace of its own."""

from __future__ import annotations

import json
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.integration.hosts import Hosts, namespaces_are_permitted
from tests.plugins.cameras import apart
from tests.plugins.cameras.apart import DESK, client, running, told_by
from tests.plugins.cameras.attempts import one_of

CAMERAS = ["left", "right"]
WHOLE = [[60, packet] for packet in range(8)]
"""More packets than a picture has."""
DROPPED: dict[str, list[list[int]]] = {"left": [[20, 1], [40, 2], *WHOLE], "right": [[30, 1]]}
LOST = {"left": {"packet_loss": 2, "gap": 1}, "right": {"packet_loss": 1}}
SIZE = {"Width": 64, "Height": 48}
MS, S = 1_000_000, 1_000_000_000
COUNT, LAST = 300, 120

pytestmark = [
    pytest.mark.thorough,
    pytest.mark.skipif(not namespaces_are_permitted(), reason="this user may not make network namespaces"),
]


@pytest.fixture
def environment(tmp_path: Path) -> dict[str, str]:
    return apart.environment(tmp_path)


@pytest.fixture
def hosts(tmp_path: Path) -> Iterator[Hosts]:
    with Hosts(tmp_path, (DESK, *CAMERAS)) as made:
        yield made


def fake(
    hosts: Hosts, env: dict[str, str], kind: str, name: str, drop: list[list[int]]
) -> subprocess.Popen[str]:
    """Runs a camera at 60 pictures a second."""
    options = json.dumps({"fps": 60, "drop": drop})
    return running(hosts, name, "fake_camera.py", kind, hosts.address(name), options, env=env)


def trial(
    hosts: Hosts, env: dict[str, str], camera: str, dropped: dict[str, list[list[int]]], **asked: Any
) -> tuple[dict[str, Any], dict[str, Any]]:
    """What the client tells of each camera, and what each camera tells."""
    there = {name: fake(hosts, env, camera, name, dropped.get(name, [])) for name in CAMERAS}
    found = told_by(client(hosts, env, CAMERAS, **asked))
    return found, {name: told_by(process) for name, process in there.items()}


@pytest.mark.parametrize("backend", ["aravis", "viva-genicam"])
@pytest.mark.parametrize("camera", ["aravis", "viva-genicam"])
def test_capture_times_are_those_of_the_camera_and_losses_are_told_to_the_number(
    hosts: Hosts, environment: dict[str, str], camera: str, backend: str
) -> None:
    """Aravis' camera stamps by its computer's clock, and loses nothing to order (a busy host may).
    viva-genicam's stamps by a clock that begins with the pictures and that nobody can ask, so all of its
    times may be off by the same.
    """
    if absent := apart.missing(environment, camera, backend):
        pytest.skip(absent)
    features = SIZE if camera == "aravis" else {}

    def attempt() -> bool:
        found, _ = trial(hosts, environment, camera, DROPPED, backend=backend, count=COUNT, features=features)
        for name, one in found.items():
            off = np.array(one["frames"])[-LAST:, 1] - np.array(one["stamps"][-LAST:])
            wrong = off if camera == "aravis" else off - np.median(off)
            assert one["frames"][-1][0] == COUNT - 1 + sum(one["lost"].values())
            lost_as_ordered = camera == "aravis" or one["lost"] == LOST[name]
            if np.abs(wrong).max() > MS / 10 or not lost_as_ordered:
                return False
        return True

    assert one_of(4, attempt)


@pytest.mark.parametrize(("trigger", "backend"), [("software", "viva-genicam"), ("software", "aravis")])
def test_a_software_trigger_reaches_both(
    hosts: Hosts, environment: dict[str, str], trigger: str, backend: str
) -> None:
    """viva-genicam's camera counts the triggers; it takes its pictures when its own loop gets there."""
    if absent := apart.missing(environment, "viva-genicam", backend):
        pytest.skip(absent)
    sync = {"trigger": trigger, "rate": 20, "camera": ""}
    found, heard = trial(hosts, environment, "viva-genicam", {}, backend=backend, count=40, sync=sync)
    for name in CAMERAS:
        assert len(found[name]["frames"]) == 40
        assert heard[name]["software"] >= 40


def test_an_action_command_reaches_both(hosts: Hosts, environment: dict[str, str]) -> None:
    """viva-genicam's camera counts those with its keys; it has no features to be told others."""
    if absent := apart.missing(environment, "viva-genicam"):
        pytest.skip(absent)
    there = {name: fake(hosts, environment, "viva-genicam", name, []) for name in CAMERAS}
    sender = running(hosts, DESK, "action_sender.py", hosts.address(DESK), "5", env=environment, says="sent")
    sender.communicate()
    assert {name: told_by(camera)["action"] for name, camera in there.items()} == dict.fromkeys(CAMERAS, 5)


@pytest.mark.parametrize("away", ["unplugged", "switched off"])
@pytest.mark.parametrize("backend", ["aravis", "viva-genicam"])
def test_a_camera_that_vanishes_and_returns_takes_part_again_within_three_seconds(
    hosts: Hosts, environment: dict[str, str], backend: str, away: str
) -> None:
    if absent := apart.missing(environment, "viva-genicam", backend):
        pytest.skip(absent)

    def attempt() -> bool:
        there = {name: fake(hosts, environment, "viva-genicam", name, []) for name in CAMERAS}
        taking = client(hosts, environment, CAMERAS, backend=backend, count=400, read_timeout=1.0)
        if away == "unplugged":
            hosts.link("left", "down")
            time.sleep(3.0)
            hosts.link("left", "up")
        else:
            there["left"].kill()
            there["left"].communicate()
            time.sleep(2.0)
            there["left"] = fake(hosts, environment, "viva-genicam", "left", [])
        back = time.time_ns()
        found = told_by(taking)
        for camera in there.values():
            camera.communicate()
        numbers, times = np.array(found["left"]["frames"]).T
        said = [text for _, text in found["left"]["said"]]
        assert (np.diff(numbers) > 0).all()
        assert (np.diff(times) > 0).all()
        if away == "switched off" or said:  # else its stream outlasted the time without a link
            assert sum("connecting again" in text for text in said) == 1
            assert sum("is back" in text for text in said) == 1
        other_goes_on = found["right"]["said"] == []
        return other_goes_on and bool(times[times > back][0] - back < 3 * S)

    assert one_of(4, attempt)
