"""The state of the page's process: the run, the browsers, and what they may ask for."""

from __future__ import annotations

import asyncio
import json
from collections import Counter
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import Any

from followspot.graph.names import subgraphs
from followspot.graph.output_ports import output_ports
from followspot.graph.plan import Plan, PlannedEdge, PlannedStage
from followspot.library.handle import RecorderState, RunHandle, RunStatus
from followspot.messages import Message
from followspot_dashboard.gate import Gate
from followspot_page import metrics
from followspot_page.address import is_loopback
from followspot_page.allowed_requests import forms
from followspot_page.connections import Connections
from followspot_page.display.curves import Curves, figures
from followspot_page.display.feed import Feed, Previews
from followspot_page.display.scene import scene
from followspot_page.page_process import FAREWELL
from followspot_page.recordings.record_button import RecordButton, recordable
from followspot_page.recordings.scrub import Scrub
from followspot_page.run_list import RunList
from followspot_page.taps.live_run import Sight
from followspot_page.taps.remote_previews import RemotePreviews
from followspot_page.taps.sensors import sensors
from followspot_page.taps.shown_ports import plotted_ports, sent_kinds, shown_ports
from followspot_watch.run_monitor import RunMonitor

MAX_BROWSERS = 32
MAX_OF_ADDRESS = 12
"""Largest number from one other host."""


class Page:
    """The state of the page, and its browsers."""

    def __init__(self, plan: Plan, gate: Gate, folder: Path) -> None:
        """folder: of the page, for sockets."""
        self.plan = plan
        self.ask: RunHandle | None = None
        """The run that browsers may change; None if the page only shows it."""
        self.shut = "this page only shows: it is open to other hosts"
        """Why browsers may not change the run."""
        self.gate = gate
        self.remote: RemotePreviews | None = None
        """Previews from other hosts; None if the run has none."""
        self.feed = Feed()
        self.run = RunMonitor(plan)
        self.targets = metrics.Targets(plan.room)
        self.previews = Previews(self.feed, plan.room, self._take)
        self.curves = Curves(self.feed, plan.room)
        self.figures: Mapping[str, type[Message]] = {}
        """The types of the messages of the ports whose figures browsers may plot."""
        self.sight: Sight | None = None
        """The page's taps; None for a recording."""
        self.button = RecordButton(folder, self._tell_recording)
        self.connections = Connections()
        self.scrub: Scrub | None = None
        """The recording that is shown instead of a run."""
        self.runs: RunList | None = None
        """The runs in reach; None if this page shows no others."""
        self._browsers: Counter[str] = Counter()
        """Number of browsers by address."""
        self._deserted = asyncio.Event()
        """No browser is here."""
        self._deserted.set()
        self.show(plan)

    def show(self, plan: Plan) -> None:
        """Take the present plan; browsers receive it if it differs."""
        self.plan = self.run.plan = plan
        self.figures = self._figures()
        self._expect()
        scene = json.dumps({"type": "scene", **self.about()})
        if self.feed.newest("scene") != scene:
            self.feed.put("scene", scene)

    def _figures(self) -> dict[str, type[Message]]:
        """Of a page that only shows, and of a recording: those of the ports that are shown anyway."""
        every = output_ports(self.plan)
        if self.ask is not None:
            return dict(every)
        shown = shown_ports(self.plan) if self.scrub is None else self.scrub.ports
        return {port.name: every[port.name] for port in shown}

    def _expect(self) -> None:
        """Tell the views which ports the taps will send: those that are shown, and those that are plotted."""
        shown = shown_ports(self.plan)
        self.previews.drawn = frozenset(port.name for port in shown)
        self.previews.kinds = sent_kinds((*shown, *plotted_ports(self.plan, self.curves.ports)))
        self.readings = [port for port in shown if port.sensor]

    async def look_at_curves(self) -> None:
        """Tap the ports whose figures are plotted now. Raises FollowspotError."""
        self._expect()
        if self.sight is not None:
            self.sight.plotted = self.curves.ports
            await self.sight.turn_to(self.plan)

    def _take(self, port: str, message: Message) -> None:
        self.curves.take(port, message)
        if port in self.previews.drawn:
            self.targets.take(port, message)

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
            "figures": figures(self.figures, self.plan.room),
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

    def send_position(self, text: str) -> None:
        """Tell browsers where the recording stands, and that this page lives."""
        self.feed.put("position", text)
        self.take_status(None)

    def _tell_recording(self, about: dict[str, Any]) -> None:
        self.feed.put("recording", json.dumps({"type": "recording", **about}))

    def take_status(self, status: RunStatus | None) -> None:
        """Take the run's status; None if it does not answer, and the last one becomes old."""
        if status is not None:
            self.run.take(status)
        data = self.run.data()
        if self.scrub is not None:
            data["faults"] = [*self.scrub.problems, *data["faults"]]
        self.feed.put("run", json.dumps(data))

    def take_kept(self, kept: RecorderState | None) -> None:
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

    def full(self, address: str) -> str:
        """Why there is no room for one more browser from this address; "" if there is."""
        of_it = MAX_BROWSERS if is_loopback(address) else MAX_OF_ADDRESS
        if self.browsers >= MAX_BROWSERS:
            return f"{MAX_BROWSERS} browsers show this page, which is all it serves; close one of them"
        if self._browsers[address] >= of_it:
            return f"{of_it} browsers of this host show this page, which is all it serves; close one"
        return ""

    @property
    def browsers(self) -> int:
        """Number of browsers."""
        return self._browsers.total()

    def count(self, address: str, change: int) -> None:
        """One more browser from an address (1), or one fewer (-1)."""
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
