"""What a camera says of PTP, by the features that SFNC 2 and GigE Vision cameras before it document."""

from __future__ import annotations

import pytest

from followspot_cameras.genicam.facts import Facts
from followspot_cameras.genicam.ptp import ptp_problem, ptp_state

SFNC = {"PtpEnable": "true", "PtpDataSetLatch": "", "PtpStatus": "Slave", "PtpOffsetFromMaster": "-120"}
BASLER = {
    "GevIEEE1588": "1",
    "GevIEEE1588DataSetLatch": "",
    "GevIEEE1588Status": "Initializing",
    "GevIEEE1588StatusLatched": "Slave",
    "GevIEEE1588OffsetFromMaster": "35",
    "GevTimestampTickFrequency": "1000000000",
}


class NodeMap:
    """Features of a camera, and the commands that were run."""

    def __init__(self, values: dict[str, str]) -> None:
        self.values, self.executed = values, list[str]()

    def read(self, name: str) -> str:
        return self.values[name]


def told(values: dict[str, str]) -> tuple[str, list[str]]:
    nodes = NodeMap(values)
    return ptp_state(values, nodes.read, nodes.executed.append), nodes.executed


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        (SFNC, "Slave, -120 ns from its master"),
        (BASLER, "Slave, 35 ns from its master"),
        (SFNC | {"PtpStatus": "Master"}, "Master"),
        (SFNC | {"PtpEnable": "false"}, "off"),
        (BASLER | {"GevIEEE1588": "0"}, "off"),
        ({"GevIEEE1588": "true"}, "on"),
        ({"GevIEEE1588": "true", "GevIEEE1588Status": "Listening"}, "Listening"),
        ({"GevTimestampTickFrequency": "1"}, ""),
    ],
)
def test_the_state_of_ptp_is_what_the_node_map_says(values: dict[str, str], expected: str) -> None:
    assert told(values)[0] == expected


def test_the_data_are_latched_before_they_are_read() -> None:
    assert told(SFNC)[1] == ["PtpDataSetLatch"]
    assert told(BASLER)[1] == ["GevIEEE1588DataSetLatch"]
    assert told(SFNC | {"PtpEnable": "false"})[1] == []


def test_a_camera_that_takes_no_commands_tells_what_it_says_without() -> None:
    def refuse(command: str) -> None:
        raise ConnectionError(command)

    assert ptp_state(BASLER, BASLER.__getitem__, refuse) == "Initializing"
    assert ptp_state(SFNC, SFNC.__getitem__, refuse) == "Slave, -120 ns from its master"


def test_the_list_shows_it_beside_the_clock() -> None:
    assert Facts(clock="readable", ptp=told(SFNC)[0]).time == "readable, PTP Slave, -120 ns from its master"


@pytest.mark.parametrize(
    ("values", "problem"),
    [
        (SFNC, ""),
        (SFNC | {"PtpStatus": "Master"}, ""),
        (SFNC | {"PtpEnable": "false", "PtpStatus": "Disabled"}, ""),
        (SFNC | {"PtpStatus": "Listening"}, "its PTP is Listening: its clock follows no master"),
        (BASLER | {"GevIEEE1588StatusLatched": "Faulty"}, "its PTP is Faulty: its clock follows no master"),
        ({"PtpEnable": "true", "PtpStatus": "Slave", "PtpOffsetFromMaster": "none"}, ""),
        ({}, ""),
    ],
)
def test_a_camera_whose_ptp_is_on_and_follows_no_master_is_told(values: dict[str, str], problem: str) -> None:
    assert ptp_problem(values, values.__getitem__, lambda command: None) == problem
