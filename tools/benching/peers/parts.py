"""The tracker in seven parts, one process each: a part for each camera with its detector, and the fusion.

The stages are those of the graph, made from its plan. What joins the parts is up to each contender: blobs
go to the fusion, the forecast of a frame set goes back to the cameras for the next one.
"""

from __future__ import annotations

import json
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from followspot.context import Context
from followspot.graph.compile import compile_graph
from followspot.graph.plan import Plan, PlannedStage
from followspot.message_checks.sealing import seal
from followspot.messages import Header, M, stamped
from followspot.plugins.registry import load_stage
from followspot.stage import Stage
from followspot.tracking import Blobs, Forecast, Frame, Tracks

LEAD = 10
"""Frame sets before the clock starts: the targets are found in them."""
DETECTORS = ("color", "infrared")
READY, START, RESULT = "ready-", "start", "result.json"
"""Files: of a camera that is ready, with the moment of the first frame set, with what came of the run."""


@dataclass(frozen=True)
class Order:
    """What a run plays.

    rate: frame sets per second, 0 as fast as they are taken; folder: of pictures and results.
    """

    graph: str
    room: str
    folder: str
    frames: int
    rate: float

    def plan(self) -> Plan:
        """The graph in its room."""
        return compile_graph(self.graph, room=self.room)

    def path(self, name: str) -> Path:
        """A file of the run."""
        return Path(self.folder) / name

    def written(self) -> Path:
        """The file of this order."""
        file = self.path("order.json")
        file.write_text(json.dumps(asdict(self)), encoding="utf-8")
        return file


def read_order(file: str) -> Order:
    """The order in a file."""
    return Order(**json.loads(Path(file).read_text(encoding="utf-8")))


class Clock:
    """Lets cameras begin together, and knows when each frame set is due."""

    def __init__(self, order: Order) -> None:
        self.order = order
        self._started = 0

    def ready(self, camera: str) -> None:
        """Say that a camera is ready."""
        self.order.path(f"{READY}{camera}").touch()

    def wait(self) -> None:
        """Until all cameras are."""
        start = self.order.path(START)
        while not start.exists():
            time.sleep(0.01)

    def due(self, number: int) -> int:
        """When a frame set is captured, ns of the monotonic clock; now if there is no rate."""
        if not self.order.rate:
            return time.monotonic_ns()
        self._started = self._started or int(self.order.path(START).read_text(encoding="utf-8"))
        return self._started + round(number * 1e9 / self.order.rate)

    def seconds_until(self, number: int) -> float:
        """Time left until a frame set is due, s."""
        return max(0.0, (self.due(number) - time.monotonic_ns()) / 1e9)


class Camera:
    """One camera and its detector."""

    def __init__(self, order: Order, camera: str) -> None:
        cv2.setNumThreads(1)
        plan = order.plan()
        self.clock = Clock(order)
        self._camera = camera
        self._pictures = np.load(order.path(f"{camera}.npy"))
        (planned,) = [s for s in plan.stages if s.group in DETECTORS and s.camera == camera]
        self._detector: Any = _made(plan, planned)

    def blobs(self, number: int, forecast: Forecast | None) -> Blobs:
        """What the detector finds in a frame."""
        frame = Frame(self._camera, self._pictures[number])
        header = Header(f"camera/{self._camera}", number, time_of(number), self.clock.due(number))
        sent = stamped(seal(frame), header)
        found: Blobs = self._detector.process(sent, forecast)
        return _sent(found, header)


class Fusion:
    """All that follows the detectors, and what the run reports."""

    def __init__(self, order: Order) -> None:
        cv2.setNumThreads(1)
        plan = order.plan()
        self._told = Told(order)
        self.cameras = list(plan.room.cameras)
        by_name = {stage.group: stage for stage in plan.stages}
        names = ("verify", "triangulate", "associate", "fuse", "bridge", "track")
        self._stages: list[Any] = [_made(plan, by_name[name]) for name in names]
        self.forecast: Forecast | None = None

    def fuse(self, blobs: Sequence[Blobs]) -> Forecast:
        """Track the targets of one frame set; blobs: in the order of the cameras. Returns the forecast."""
        verify, triangulate, associate, fuse, bridge, track = self._stages
        before, header = self.forecast, blobs[0].header
        pairs = _sent(verify.process(blobs, before), header)
        candidates = _sent(triangulate.process(pairs, before), header)
        associated = associate.process(candidates, before)
        likely, existence = _sent(associated.candidates, header), _sent(associated.existence, header)
        positions = _sent(fuse.process(likely, before), header)
        bridged = _sent(bridge.process(positions, blobs, before, [existence]), header)
        found = track.process(bridged)
        self._told.tracks(_sent(found.tracks, header))
        self.forecast = _sent(found.forecast, header)
        return self.forecast

    def report(self) -> None:
        """Write the results."""
        self._told.report()


class Told:
    """When tracks came, and which."""

    def __init__(self, order: Order) -> None:
        self._order = order
        self._clock = Clock(order)
        self._arrived: list[int] = []
        self._latencies: list[float] = []
        self._tracks: list[Any] = []

    def tracks(self, tracks: Tracks) -> None:
        """Note one frame set."""
        now = time.monotonic_ns()
        self._latencies.append((now - self._clock.due(len(self._arrived))) / 1e6)
        self._arrived.append(now)
        self._tracks.append([tracks.target.tolist(), tracks.xyz.tolist()])

    def report(self) -> None:
        """Write latencies from capture to track, ms, rate, 1/s, both after the lead, and all tracks."""
        arrived = self._arrived[LEAD:]
        rate = (len(arrived) - 1) * 1e9 / (arrived[-1] - arrived[0])
        told = {"per_second": rate, "latencies_ms": self._latencies[LEAD:], "tracks": self._tracks}
        draft = self._order.path("draft.json")
        draft.write_text(json.dumps(told), encoding="utf-8")
        draft.rename(self._order.path(RESULT))


def time_of(number: int) -> int:
    """Capture time of a frame set, ns, in the room's own time: at 60 a second."""
    return round(number * 1e9 / 60)


def _made(plan: Plan, planned: PlannedStage) -> Stage:
    stage = load_stage(planned.uses)(Context(planned.name, plan.room, planned.member), **planned.params)
    stage.setup()
    return stage


def _sent(message: M, header: Header) -> M:
    """The message as an edge would deliver it."""
    return stamped(message if message.header.source else seal(message), header)
