"""Taps that an operator elsewhere asks for: what an agent takes."""

from __future__ import annotations

from typing import Any

import pytest

from followspot.control.tapping import PlaceTaps, Tapping
from followspot.errors import FollowspotError
from followspot.graph.plan import Plan
from followspot.room import Room

PLAN = Plan("g", Room("room"), (), (), ())


def asked(uses: str, **params: Any) -> PlaceTaps:
    return PlaceTaps(taps=(Tapping("camera/cam0.out", uses, params),))


def test_a_sink_without_files_is_taken() -> None:
    asked("dashboard.tap", picture_rate=5.0).check(PLAN, remote=True)


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
def test_what_has_files_or_is_no_tap_is_refused(taps: PlaceTaps, why: str) -> None:
    with pytest.raises(FollowspotError, match=why):
        taps.check(PLAN, remote=True)


def test_an_operator_of_this_host_may_use_files() -> None:
    asked("dashboard.tap", folder="/tmp").check(PLAN, remote=False)
    with pytest.raises(FollowspotError, match="no tap"):
        asked("sinks.csv").check(PLAN, remote=False)
