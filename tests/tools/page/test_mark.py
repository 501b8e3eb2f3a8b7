"""The page's button saves the last seconds of a run that keeps them."""

from __future__ import annotations

import asyncio
import json
from typing import Any

import pytest

from followspot.errors import FollowspotError
from followspot.library.handle import Moment, RecorderState
from followspot_page.allowed_requests import MarkRequest, request_of
from followspot_page.display.feed import Feed
from followspot_page.page import Page
from followspot_page.requests.handler import Requests

MOMENTS = tuple(Moment(f"/runs/{name}.mcap", (), ("",), "complete", 35.0, 9, 0, 100) for name in "ab")
KEPT = RecorderState(30.0, 18, 29.5, 45_000_000, 1 << 29, 900, 2, MOMENTS)


class Run:
    """Notes the marks that are asked of it."""

    def __init__(self) -> None:
        self.notes: list[str] = []

    def mark(self, *, note: str) -> Moment:
        self.notes.append(note)
        return MOMENTS[0]


def page(run: Any) -> Page:
    made = Page.__new__(Page)
    made.ask, made.scrub, made.feed, made.shut = run, None, Feed(), "this page only shows"
    return made


def test_the_button_marks_and_names_the_file() -> None:
    run = Run()
    assert asyncio.run(Requests(page(run)).do('{"mark": "jump"}')).text == (
        "saving the last seconds, and the next, in a.mcap"
    )
    assert run.notes == ["jump"]


def test_a_page_that_only_shows_does_not_mark() -> None:
    with pytest.raises(FollowspotError, match="only shows"):
        asyncio.run(Requests(page(None)).do('{"mark": ""}'))
    with pytest.raises(FollowspotError, match="nothing that can be asked for"):
        request_of(json.dumps({"mark": "x" * 201}))
    assert request_of('{"mark": ""}') == MarkRequest("")


def test_browsers_are_told_what_is_held_and_the_newest_file() -> None:
    shown, closed = page(Run()), page(None)
    for made in (shown, closed):
        made.take_kept(None)
        assert made.feed.newest("kept") is None
        made.take_kept(KEPT)
    told = json.loads(str(shown.feed.newest("kept")))
    assert (told["type"], told["held"], told["bytes"], told["lost"]) == ("kept", 29.5, 45_000_000, 2)
    assert [moment["file"] for moment in told["moments"]] == ["/runs/b.mcap"]
    assert closed.feed.newest("kept") is None
