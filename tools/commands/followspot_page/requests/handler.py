"""Handles the requests that one browser may make, and remembers those it has made."""

from __future__ import annotations

import asyncio
import time
from contextlib import suppress
from pathlib import Path

from followspot.errors import FollowspotError
from followspot.files import unused_path
from followspot.frame_times import to_seconds
from followspot.library.handle import RunHandle
from followspot.library.overlay import save_overlay
from followspot_page.allowed_requests import (
    Change,
    Hold,
    Learn,
    MarkRequest,
    OpenPage,
    PageRequest,
    Plot,
    Record,
    Save,
    Seek,
    Still,
    Write,
    request_of,
    sentence,
    words_of,
)
from followspot_page.page import Page
from followspot_page.requests.learning import Learning
from followspot_page.requests.reply import Reply
from followspot_page.taps.live_run import plan_of


class Requests:
    """Carries out the requests of one browser. page: what all browsers share."""

    def __init__(self, page: Page) -> None:
        self._page = page
        self._learning = Learning()

    async def do(self, text: str) -> Reply:
        """Carry out a request, in JSON. Raises FollowspotError if that fails."""
        asked = request_of(text)
        if isinstance(asked, Plot):
            return await self._plot(asked)
        scrub, run = self._page.scrub, self._page.ask
        if scrub is not None and isinstance(asked, Seek):
            return Reply(scrub.seek(asked))
        if run is None:
            raise FollowspotError(self._page.shut)
        if isinstance(asked, Still | Learn | Write):
            return await asyncio.to_thread(self._learn, run, asked)
        return Reply(await self._changed(run, asked))

    async def leave(self) -> None:
        """The browser has left."""
        self._page.curves.leave(self)
        with suppress(FollowspotError):  # the run has ended
            await self._page.look_at_curves()

    async def _plot(self, asked: Plot) -> Reply:
        self._page.curves.choose(self, asked.plot, self._page.figures)
        await self._page.look_at_curves()
        return Reply()

    def _learn(self, run: RunHandle, asked: Still | Learn | Write) -> Reply:
        plan = self._page.plan
        if isinstance(asked, Still):
            return self._learning.still(run, plan, asked.still)
        return (
            self._learning.learn(run, plan, asked)
            if isinstance(asked, Learn)
            else self._learning.write(run, plan)
        )

    async def _changed(self, run: RunHandle, asked: PageRequest) -> str:
        """A line about what became of a request that changes the run, or what is made of it."""
        page = self._page
        if isinstance(asked, Change):
            return await self._change(run, words_of(asked, page.plan))
        if isinstance(asked, Record):
            if asked.on:
                return await page.button.start(run, page.plan, asked.ports)
            return await page.button.stop()
        if isinstance(asked, Hold):
            return await _hold(run, asked)
        if isinstance(asked, MarkRequest):
            moment = await asyncio.to_thread(run.mark, note=asked.mark)
            return f"saving the last seconds, and the next, in {Path(moment.file).name}"
        if isinstance(asked, OpenPage):
            if page.runs is None:
                raise FollowspotError("this page tells nothing of other runs")
            return await asyncio.to_thread(page.runs.open, asked.open)
        if isinstance(asked, Save):
            return await asyncio.to_thread(_saved_overlay, run)
        raise FollowspotError("a run goes on by itself; pause and step hold a replay")

    async def _change(self, run: RunHandle, words: list[str]) -> str:
        try:
            answer = await asyncio.to_thread(run.change, words)
        except FollowspotError as error:
            raise FollowspotError(sentence(str(error))) from error
        self._page.show(await plan_of(run))
        lines = dict.fromkeys(
            stage.text.partition(": ")[2] for stage in answer.stages
        )  # once, not once a camera
        return "; ".join(lines) or "it is so already"


async def _hold(run: RunHandle, asked: Hold) -> str:
    if asked.hold == "step":
        reached = await asyncio.to_thread(run.step, asked.count)
        return f"at {to_seconds(reached):.6f} s"
    await asyncio.to_thread(run.pause if asked.hold == "pause" else run.resume)
    return ""


def _saved_overlay(run: RunHandle) -> str:
    """Save what was changed in the run, from the page or elsewhere, as a graph file in its output folder.

    Returns a line with the new file and the stages that it changes. Raises FollowspotError.
    """
    out = run.metadata().out
    if out is None:
        raise FollowspotError("overlays are saved on the operator's host; save it there")
    path = unused_path(out / time.strftime("overlay-%Y%m%d-%H%M%S.yaml"))
    stages = save_overlay(run, path)
    return f"saved {', '.join(stages)} in {path}; followspot run {path} begins so"
