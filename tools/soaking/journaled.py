"""Stages for tools/soak.py: live cameras of the simulated room, the tracker, and the judge of its tracks.

All of them keep journals in the folder JOURNALS of the environment: a line for each message before it is
handed out, and when it is given, with the id of the process, the message's source and its number. They are
compared with the ledger (tests/promises/ledger_check.py), and nothing here looks at that.
"""

from __future__ import annotations

import functools
import math
import os
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from followspot import Field, Message, OutputPath, Source, Stage, at
from followspot.ports.signature import ports
from followspot.ports.specs import Ports
from followspot.tracking import TRACKED, Frame, Tracks
from followspot_balls.associate_tracked import AssociateTracked as PlainAssociateTracked
from followspot_balls.bridge import Bridge as PlainBridge
from followspot_balls.color_blobs import ColorBlobs as PlainColorBlobs
from followspot_balls.ir_blobs import IrBlobs as PlainIrBlobs
from followspot_balls.kalman import Kalman as PlainKalman
from followspot_balls.mean_shift import MeanShift as PlainMeanShift
from followspot_balls.triangulate import Triangulate as PlainTriangulate
from followspot_balls.verify_pairs import VerifyPairs as PlainVerifyPairs
from followspot_sim.camera import SimCamera
from followspot_sim.parameters import CameraParams, SimParams
from followspot_sim.truth import SimTruth
from followspot_sinks.csv_file import CsvFile as PlainCsvFile

_files: dict[str, int] = {}
_seen: dict[str, Message] = {}
"""The last message at each input, for one that is sampled is seen more than once."""


def note(stage: str, port: str, source: str, seq: int) -> None:
    """Append a line to the journal of a port, in.NAME or out.NAME, with one call."""
    name = f"{stage.replace('/', '~')}.{port}"
    if name not in _files:
        flags = os.O_WRONLY | os.O_CREAT | os.O_APPEND
        _files[name] = os.open(os.path.join(os.environ["JOURNALS"], name), flags, 0o600)  # noqa: PTH118
    os.write(_files[name], f"{os.getpid()} {source} {seq}\n".encode())


def journaled(stage: type[Stage]) -> type[Stage]:
    """The stage, and before each message that it gets or makes a line is written."""
    known = ports(stage)
    if known.source:
        body: dict[str, Any] = {"process": _noted_source(stage)}
    elif stage.process_together is not None:  # `process` calls it
        body = {"process_together": classmethod(_noted_together(stage, known))}
    else:
        body = {"process": _noted(stage, known)}
    return type(stage.__name__, (stage,), {"__module__": __name__, "__doc__": stage.__doc__, **body})


def _noted_source(stage: type[Stage]) -> Callable[..., Any]:
    original = stage.process

    @functools.wraps(original)
    def process(self: Stage) -> Iterator[Any]:
        for item in original(self):
            note(self.context.name, "out.out", self.context.name, item.header.seq)
            yield item

    return process


def _noted(stage: type[Stage], known: Ports) -> Callable[..., Any]:
    original = stage.process

    @functools.wraps(original)
    def process(self: Stage, *arguments: Any) -> Any:
        first = _got(self.context.name, known, arguments)
        made = original(self, *arguments)
        _made(self.context.name, known, made, first)
        return made

    return process


def _noted_together(stage: type[Stage], known: Ports) -> Callable[..., Any]:
    original: Any = stage.process_together

    def process_together(cls: type[Stage], stages: Sequence[Stage], inputs: Sequence[Any]) -> Sequence[Any]:
        firsts = [_got(one.context.name, known, each) for one, each in zip(stages, inputs, strict=True)]
        results = original(stages, inputs)
        for one, made, first in zip(stages, results, firsts, strict=True):
            _made(one.context.name, known, made, first)
        return list(results)

    return process_together


def _got(stage: str, known: Ports, arguments: Sequence[Any]) -> Message:
    """Note the messages that came; return the earliest of the firing, whose number the results get."""
    firing: list[Message] = []
    for port, value in zip(known.inputs, arguments, strict=True):
        for message in value if isinstance(value, tuple) else (value,):
            here = f"{stage}.{port.name}"
            if message is None or not message.header.source:  # nothing yet, or what feedback begins with
                continue
            if port.kind != "latest":
                firing.append(message)
            elif _seen.get(here) is message:
                continue
            _seen[here] = message
            note(stage, f"in.{port.name}", message.header.source, message.header.seq)
    return min(firing, key=lambda message: message.header.time)


def _made(stage: str, known: Ports, made: Any, first: Message) -> None:
    for port in known.outputs:
        message = made if port.name == "out" or made is None else getattr(made, port.name)
        if message is not None:
            note(stage, f"out.{port.name}", first.header.source, first.header.seq)


ColorBlobs = journaled(PlainColorBlobs)
IrBlobs = journaled(PlainIrBlobs)
VerifyPairs = journaled(PlainVerifyPairs)
Triangulate = journaled(PlainTriangulate)
AssociateTracked = journaled(PlainAssociateTracked)
MeanShift = journaled(PlainMeanShift)
Bridge = journaled(PlainBridge)
Kalman = journaled(PlainKalman)
CsvFile = journaled(PlainCsvFile)


@journaled
class LiveCamera(SimCamera):
    """A simulated camera that follows the clock: after a restart it goes on at the present frame."""

    live = True

    class Params(CameraParams):
        """The room, and the time at which its simulation began."""

        opened: float = Field(0.0, ge=0, description="time of frame 0 by the monotonic clock", unit="s")

    params: Params  # type: ignore[assignment]  # more than those of the base

    def setup(self) -> None:
        """Prepare the room."""
        super().setup()
        self.over = threading.Event()

    def close(self) -> None:
        """End the waiting."""
        self.over.set()

    def process(self) -> Source[Frame]:
        """Each picture at its time by the clock of this host; pictures after the last are never taken."""
        opened, fps = self.params.opened, self.params.fps
        frame = math.ceil((time.monotonic() - opened) * fps)
        while not (self.params.frames and frame >= self.params.frames):
            due = opened + frame / fps
            if self.over.wait(max(0.0, due - time.monotonic())):
                return
            captured = time.time_ns() - round((time.monotonic() - due) * 1e9)
            pixels = self.context.loan(self._picture.shape, "u1")
            self._picture.render(frame, pixels)
            yield at(captured, Frame(camera=self.camera.name, pixels=pixels), seq=frame)
            frame = max(frame + 1, math.floor((time.monotonic() - opened) * fps))


@journaled
class Judge(Stage):
    """Writes for each frame its time of tracking, s of the monotonic clock, and its error, m.

    That is the largest error of the targets that a colour and an infrared camera see; infinite where one of
    them is not tracked. A full disk is an error each time.
    """

    class Params(SimParams):
        """The room that the cameras look into."""

        path: OutputPath = Field("judged.csv", description="file to write")

    params: Params

    def setup(self) -> None:
        """Open the file, behind what was written before."""
        self.truth = SimTruth(self.context, **self.params.model_dump(exclude={"path"}))
        self.truth.setup()
        flags = os.O_WRONLY | os.O_CREAT | os.O_APPEND
        self.file = os.open(self.context.out / self.params.path, flags, 0o600)

    def close(self) -> None:
        """Close the file."""
        os.close(self.file)

    def process(self, tracks: Tracks) -> None:
        """One line."""
        frame = tracks.header.seq
        line = f"\n{time.monotonic():.4f},{frame},{self.error(tracks):.4f}"  # first the end of a cut one
        os.write(self.file, line.encode())

    def error(self, tracks: Tracks) -> float:
        """The largest, m; 0 if no target is to be seen."""
        truth = self.truth.truth(tracks.header.seq)
        names = list(self.room.targets)
        placed = np.full((len(names), 3), np.inf)
        found = tracks.state == TRACKED
        placed[tracks.target[found]] = tracks.xyz[found]
        wanted = [names.index(name) for name in truth.objects]
        errors = np.linalg.norm(placed[wanted] - truth.xyz, axis=1)
        return float(errors[truth.pair].max(initial=0.0))
