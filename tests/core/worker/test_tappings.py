"""Taps that an operator elsewhere asks for: what an agent takes."""

from __future__ import annotations

from typing import Any

import pytest

from followspot.control.plan_transfer import check_remote_taps
from followspot.control.tapping import Tapping
from followspot.errors import FollowspotError


def asked(uses: str, **params: Any) -> list[Tapping]:
    return [Tapping("camera/cam0.out", uses, params)]


def test_a_sink_without_files_is_taken() -> None:
    check_remote_taps(asked("dashboard.tap", rate=5.0))


@pytest.mark.parametrize(
    ("taps", "why"),
    [
        (asked("dashboard.tap", folder="/etc"), "no files"),
        (asked("recording.tap", socket="/run/anything"), "no files"),
        (asked("sinks.csv", path="../tracks.csv"), "no tap"),
        (asked("sinks.udp_json", host="203.0.113.9"), "no tap"),
        (asked("balls.kalman"), "no tap"),
        (asked("nobody.knows"), "nobody.knows"),
    ],
)
def test_what_has_files_or_is_no_tap_is_refused(taps: list[Tapping], why: str) -> None:
    with pytest.raises(FollowspotError, match=why):
        check_remote_taps(taps)
