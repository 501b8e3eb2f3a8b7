"""A page that is served in a process of its own, of a run that answers as the test wants."""

from __future__ import annotations

import os
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Event
from typing import Any
from urllib.parse import urlsplit

import numpy as np
from websockets.sync.client import ClientConnection, connect

from followspot.control.dispatch import Dispatcher
from followspot.control.tapping import PlaceTaps
from followspot.control.unix_socket import serve_requests
from followspot.errors import FollowspotError
from followspot.graph.compile import compile_graph
from followspot.graph.plan import Plan
from followspot.graph.plan_data import plan_to_data
from followspot.messages import Header, Message, stamped
from followspot.operator.change_outcome import ChangeOutcome, StageOutcome
from followspot.operator.run_requests import (
    ChangeStages,
    GetPlan,
    GetRunMetadata,
    GetStatus,
    RunMetadata,
)
from followspot.operator.run_status import RunStatus
from followspot.taps.sender import TapSender
from followspot.tracking import Tracks
from followspot.wire import pack
from followspot_dashboard.gate import SOCKET, Gate
from followspot_page.page_process import PageOrder, shown

GRAPH = Path(__file__).parents[3] / "graphs" / "glowballs.yaml"


class Shown:
    """A page that is being served, and the run that it asks, as far as it is one."""

    def __init__(self, plan: Plan, out: Path) -> None:
        self.plan = plan
        self.status = RunStatus((), (), 0, None)
        self.tapped = Event()
        self.asked: list[list[str]] = []
        self.out = out
        self.recorded: dict[str, Any] = {}
        self.pid = 0

    def tap(self, request: PlaceTaps) -> None:
        """Previews first, then recordings."""
        if self.tapped.is_set():
            self.recorded = {tap.port: dict(tap.params) for tap in request.taps}
            return
        self.folder = Path(request.taps[0].params["folder"])
        self.tapped.set()

    def dispatcher(self) -> Dispatcher:
        return Dispatcher(
            "operator",
            {
                GetPlan: lambda _: plan_to_data(self.plan),
                GetStatus: lambda _: self.status,
                PlaceTaps: self.tap,
                GetRunMetadata: lambda _: RunMetadata(self.out),
                ChangeStages: self.change,
            },
        )

    def change(self, request: ChangeStages) -> ChangeOutcome:
        if request.words[0].endswith("fuse.maximum_iterations=-1"):
            raise FollowspotError("maximum_iterations must be at least 1")
        self.asked.append(list(request.words))
        return ChangeOutcome("it", "glowballs", (StageOutcome(request.words[0], "", "", {}),))

    def serve(self, url: str) -> None:
        """The page is at this address."""
        self.url = url
        self.host = urlsplit(url).netloc
        assert self.tapped.wait(60)
        self.taps = TapSender(self.folder / SOCKET)
        self.gate = Gate(self.folder)
        self.get("")

    def send(self, port: str, message: Message) -> None:
        """Send a preview as the tap of a port does."""
        self.taps.send(port, 0, pack(message))

    def get(self, path: str, **headers: str) -> tuple[int, str, Any]:
        request = urllib.request.Request(self.url + path, headers=headers)
        try:
            with urllib.request.urlopen(request, timeout=60) as answer:
                return answer.status, answer.read().decode(), answer.headers
        except urllib.error.HTTPError as error:
            return error.code, error.read().decode(), error.headers

    def look(self, origin: str | None = None, **options: Any) -> ClientConnection:
        return connect(f"ws://{self.host}/look", origin=origin, proxy=None, **options)  # type: ignore[arg-type]


@contextmanager
def served(out: Path, plan: Plan | None = None) -> Iterator[Shown]:
    """The page of a run of the glowing balls, or of this plan. out: folder for its outputs."""
    made = Shown(plan or compile_graph(GRAPH), out)
    name = f"{os.getpid():x}{out.name}"
    with serve_requests(name, made.plan.graph, made.dispatcher()), shown(PageOrder(os.getpid())) as page:
        made.pid = page.pid
        made.serve(page.url)
        yield made


def at(ms: int, message: Message) -> Message:
    return stamped(message, Header("camera/cam0", ms, ms * 1_000_000))


def tracks(*states: int) -> Tracks:
    rows = len(states)
    place = np.tile([0.5, 0.25, 1.0], (rows, 1))
    return Tracks(
        np.arange(rows, dtype="i4"), np.array(states, "u1"), place, np.zeros((rows, 3)), place / 100
    )
