"""The state of the page's process: the run, the browsers, and what they may ask for."""

from __future__ import annotations

import asyncio
import json
from collections import Counter
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import Any

from starlette.websockets import WebSocket

from followspot.errors import FollowspotError
from followspot.graph.names import subgraphs
from followspot.graph.plan import Plan, PlannedEdge, PlannedStage
from followspot.library.handle import Kept, RunHandle, RunStatus
from followspot_dashboard.gate import Gate
from followspot_page import metrics
from followspot_page.address import is_loopback
from followspot_page.browser import Browser
from followspot_page.changing import (
    Hold,
    MarkWish,
    OpenPage,
    Record,
    Save,
    Seek,
    forms,
    sentence,
    wish_of,
    words_of,
)
from followspot_page.connections import Connections
from followspot_page.feed import Feed, Previews
from followspot_page.follow import plan_of
from followspot_page.recording import RecordButton, recordable
from followspot_page.remote_previews import RemotePreviews
from followspot_page.run_list import RunList
from followspot_page.saving import saved_overlay
from followspot_page.scene import scene
from followspot_page.scrub import Scrub
from followspot_page.sensors import sensors
from followspot_page.showing import FAREWELL
from followspot_page.taps import sent_kinds, shown_ports
from followspot_watch.run_monitor import RunMonitor

MAX_BROWSERS = 16
MAX_OF_ADDRESS = 12
"""Largest number from one other computer."""


class Page:
    """The state of the page, and its browsers."""

    def __init__(self, plan: Plan, gate: Gate, folder: Path) -> None:
        """folder: of the page, for sockets."""
        self.plan = plan
        self.ask: RunHandle | None = None
        """The run that browsers may change; None if the page only shows it."""
        self.shut = "this page only shows: it is open to other computers"
        """Why browsers may not change the run."""
        self.gate = gate
        self.remote: RemotePreviews | None = None
        """Previews from other hosts; None if the run has none."""
        self.feed = Feed()
        self.run = RunMonitor(plan)
        self.targets = metrics.Targets(plan.room)
        self.previews = Previews(self.feed, plan.room, self.targets.take)
        self.button = RecordButton(folder, self._tell_recording)
        self.connections = Connections()
        self.scrub: Scrub | None = None
        """The recording that is shown instead of a run."""
        self.runs: RunList | None = None
        """The runs in reach; None if this page tells nothing of others."""
        self._browsers: Counter[str] = Counter()
        """Number of browsers by address."""
        self._deserted = asyncio.Event()
        """No browser is here."""
        self._deserted.set()
        self.show(plan)

    def show(self, plan: Plan) -> None:
        """Take the present plan; browsers receive it if it differs."""
        self.plan = self.run.plan = plan
        shown = shown_ports(plan)
        self.previews.kinds = sent_kinds(shown)
        self.readings = [port for port in shown if port.sensor]
        scene = json.dumps({"type": "scene", **self.about()})
        if self.feed.newest("scene") != scene:
            self.feed.put("scene", scene)

    def about(self) -> dict[str, Any]:
        """The parts that stay during a run."""
        return {
            "graph": self.plan.graph,
            "room": scene(self.plan.room),
            "sensors": sensors(self.plan.room, self.readings),
            "stages": [self._stage(stage) for stage in self.plan.stages],
            "edges": [_edge(edge) for edge in self.plan.edges],
            "forms": forms(self.plan) if self.ask else {},
            "ports": recordable(self.plan) if self.ask else [],
            "recorded": None if self.scrub is None else self.scrub.about,
            "others": self.runs is not None,
            "replay": self.ask is not None and not self.plan.live,
        }

    def _stage(self, stage: PlannedStage) -> dict[str, Any]:
        """within: the sub-graphs that hold it, the outermost first; label: its name in the innermost."""
        within = subgraphs(stage.group)
        return {
            "name": stage.name,
            "group": stage.group,
            "label": stage.group.rpartition("/")[2],
            "within": within,
            "uses": stage.uses,
            "params": dict(stage.params),
            "camera": stage.camera,
            "source": stage.name in self.run.sources,
        }

    async def allow_changes(self, run: RunHandle) -> None:
        """Let browsers ask for changes, once the possible ones are known."""
        self.shut = "this page only shows yet: it still reads which changes are possible"
        await asyncio.to_thread(forms, self.plan)  # imports every stage that could be swapped in
        self.ask = run
        self.show(self.plan)

    def show_recording(self, scrub: Scrub) -> None:
        """Show a recording, which browsers may play and go through."""
        self.scrub = scrub
        self.shut = "this page shows a recording"
        self.run.ended = True
        self.show(self.plan)

    def tell_position(self, text: str) -> None:
        """Tell browsers where the recording stands, and that this page lives."""
        self.feed.put("position", text)
        self.take_status(None)

    async def do(self, text: str) -> str:
        """Carry out a browser's request; a line about it. Raises FollowspotError if that fails."""
        asked = wish_of(text) if self.ask is not None or self.scrub is not None else None
        if self.scrub is not None and isinstance(asked, Seek):
            return self.scrub.seek(asked)
        if self.ask is None or asked is None:
            raise FollowspotError(self.shut)
        if isinstance(asked, Seek):
            raise FollowspotError("a run goes on by itself; pause and step hold a replay")
        if isinstance(asked, Record):
            if asked.on:
                return await self.button.start(self.ask, self.plan, asked.ports)
            return await self.button.stop()
        if isinstance(asked, Hold):
            return await self._hold(self.ask, asked)
        if isinstance(asked, MarkWish):
            moment = await asyncio.to_thread(self.ask.mark, note=asked.mark)
            return f"saving the last seconds, and the next, in {Path(moment.file).name}"
        if isinstance(asked, OpenPage):
            if self.runs is None:
                raise FollowspotError("this page tells nothing of other runs")
            return await asyncio.to_thread(self.runs.open, asked.open)
        if isinstance(asked, Save):
            return await asyncio.to_thread(saved_overlay, self.ask)
        return await self._change(self.ask, words_of(asked, self.plan))

    async def _change(self, run: RunHandle, words: list[str]) -> str:
        try:
            answer = await asyncio.to_thread(run.change, words)
        except FollowspotError as error:
            raise FollowspotError(sentence(str(error))) from error
        self.show(await plan_of(run))
        told = dict.fromkeys(
            stage.text.partition(": ")[2] for stage in answer.stages
        )  # once, not once a camera
        return "; ".join(told) or "it is so already"

    async def _hold(self, run: RunHandle, asked: Hold) -> str:
        if asked.hold == "step":
            reached = await asyncio.to_thread(run.step, asked.count)
            return f"at {reached / 1e9:.6f} s"
        await asyncio.to_thread(run.pause if asked.hold == "pause" else run.resume)
        return ""

    def _tell_recording(self, about: dict[str, Any]) -> None:
        self.feed.put("recording", json.dumps({"type": "recording", **about}))

    def take_status(self, status: RunStatus | None) -> None:
        """Take the run's status; None if it does not answer, and the last one becomes old."""
        if status is not None:
            self.run.take(status)
        self.feed.put("run", json.dumps(self.run.data()))

    def take_kept(self, kept: Kept | None) -> None:
        """Take what the flight recorder of the run holds; None if the run has none."""
        if kept is not None and self.ask is not None:
            last = [asdict(moment) for moment in kept.moments[-1:]]
            self.feed.put("kept", json.dumps({"type": "kept", **asdict(kept), "moments": last}))

    async def end(self, how: str) -> None:
        """Tell browsers that the run has ended, and how; return when all have read it, or after FAREWELL."""
        self.feed.end(json.dumps({"type": "end", "how": how}))
        with suppress(TimeoutError):
            async with asyncio.timeout(FAREWELL):
                await self._deserted.wait()

    async def look(self, socket: WebSocket) -> None:
        """Serve one browser until it leaves or stops taking messages."""
        address = socket.client.host if socket.client is not None else ""
        of_it = MAX_BROWSERS if is_loopback(address) else MAX_OF_ADDRESS
        if self.browsers >= MAX_BROWSERS or self._browsers[address] >= of_it:
            self.connections.refused["crowded"] += 1
            await socket.close(1013)
            return
        await socket.accept()
        self._count(address, 1)
        try:
            await Browser(socket, self.feed, self.do).serve()
        finally:
            self._count(address, -1)

    @property
    def browsers(self) -> int:
        """Number of browsers."""
        return self._browsers.total()

    def _count(self, address: str, change: int) -> None:
        self._browsers[address] += change
        self._browsers += Counter()  # drops addresses with a count of 0
        watched = self.browsers > 0
        (self._deserted.clear if watched else self._deserted.set)()
        self.gate.watched = watched
        if self.remote is not None:
            self.remote.watch(watched=watched)


def _edge(edge: PlannedEdge) -> dict[str, Any]:
    """delay: whether it leads to a later frame."""
    return {
        "from": f"{edge.from_stage}.{edge.from_port}",
        "to": f"{edge.to_stage}.{edge.to_port}",
        "kind": edge.kind,
        "delay": bool(edge.delay),
    }
