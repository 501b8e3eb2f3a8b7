"""The page's buttons pause, step and resume a replay."""

from __future__ import annotations

import asyncio
from typing import Any

import pytest

from followspot.errors import FollowspotError
from followspot_page.allowed_requests import Hold, request_of
from followspot_page.page import Page
from followspot_page.requests.handler import Requests


class Replay:
    """Notes what is asked of it."""

    def __init__(self) -> None:
        self.asked: list[Any] = []

    def pause(self) -> None:
        self.asked.append("pause")

    def resume(self) -> None:
        self.asked.append("resume")

    def step(self, count: int) -> int:
        self.asked.append(count)
        return 1_500_000_000


def test_each_button_asks_the_run_for_what_it_says() -> None:
    page, run = Page.__new__(Page), Replay()
    page.ask, page.scrub = run, None  # type: ignore[assignment]
    wishes = ('{"hold": "pause"}', '{"hold": "step", "count": 3}', '{"hold": "resume"}')
    requests = Requests(page)
    assert [asyncio.run(requests.do(wish)).text for wish in wishes] == ["", "at 1.500000 s", ""]
    assert run.asked == ["pause", 3, "resume"]


@pytest.mark.parametrize("text", ['{"hold": "stop"}', '{"hold": "step", "count": 0}', '{"hold": 5}'])
def test_what_no_button_says_is_refused(text: str) -> None:
    assert request_of('{"hold": "step"}') == Hold("step", 1)
    with pytest.raises(FollowspotError, match="nothing that can be asked for"):
        request_of(text)
