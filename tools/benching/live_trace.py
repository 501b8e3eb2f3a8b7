"""A plugin file: cameras that play videos at a pace, in workers that note what they do when.

`bench/runtime/live_latency.py` loads it. In a worker it wraps what makes frames, takes messages and fires
stages. Runs without this file pay nothing. At its end a worker writes what it noted into the folder that an
environment variable names.
"""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import Any

from followspot import Field, Source, Stage, StageParams, at
from followspot.messages import Message
from followspot.plugins.registry import load_stage
from followspot.tracking import Frame
from followspot.worker.inputs.input_queue import InputQueue
from followspot.worker.runners.source import SourceRunner
from followspot.worker.runners.stage_runner import StageRunner
from followspot.worker.scheduler import Scheduler

FOLDER = "FOLLOWSPOT_LIVE_TRACE"
"""Environment variable: where the notes go."""
Call = Callable[..., Any]
_now = time.monotonic_ns


class Paced(Stage):
    """Play a video at a pace: frame n is captured, and due, n / fps seconds after all cameras began."""

    per_camera = True

    class Params(StageParams):
        path: Path = Field(description="the video file")
        fps: float = Field(gt=0, description="frames per second", unit="1/s")

    params: Params

    def setup(self) -> None:
        """Open the file."""
        self._video = load_stage("cameras.video")(self.context, path=self.params.path)
        self._video.setup()

    def process(self) -> Source[Frame]:
        """The frames, decoded one ahead."""
        begun = self.context.begun()
        for number, frame in enumerate(self._video.process()):
            since = round(number * 1e9 / self.params.fps)
            yield at(since, Frame(frame.camera, frame.pixels), seq=number, due=begun + since)

    def close(self) -> None:
        """Close the file."""
        self._video.close()


class _Notes:
    """What the workers of this process did, with times of the monotonic clock, ns."""

    def __init__(self) -> None:
        self.frames: list[tuple[str, int, int, int]] = []
        """Source, capture time, when the frame was due, when it entered the graph; the last of one counts."""
        self.decoded: list[tuple[str, int, int]] = []
        """Source, and from when to when it made a frame."""
        self.fired: list[tuple[str, int, int, int, int]] = []
        """Stage, capture time, when it took its inputs, had its result, and had sent it."""
        self.arrived: list[tuple[str, int, int]] = []
        """Edge, capture time, when its reader had the message."""
        self.waited: list[tuple[int, int]] = []
        """At these times, how long the worker's thread had waited for a core since it began, ns."""
        self._taken: dict[str, int] = {}
        self._told = -1

    def _wait(self) -> None:
        """Note how long the calling thread has waited for a core: the worker's, for it alone calls this."""
        if self._told < 0:
            self._told = os.open("/proc/thread-self/schedstat", os.O_RDONLY | os.O_CLOEXEC)
        self.waited.append((_now(), int(os.pread(self._told, 64, 0).split()[1])))

    def making(self, call: Call) -> Call:
        """Around `SourceRunner._next`."""

        @wraps(call)
        def noted(runner: SourceRunner) -> Any:
            begun = _now()
            item = call(runner)
            self.decoded.append((runner.name, begun, _now()))
            self._wait()
            return item

        return noted

    def stamping(self, call: Call) -> Call:
        """Around `SourceRunner._stamp`."""

        @wraps(call)
        def noted(runner: SourceRunner, item: Any) -> Any:
            header = call(runner, item)
            self.frames.append((runner.name, header.time, runner.not_before, header.entered))
            self._wait()
            return header

        return noted

    def taking(self, call: Call) -> Call:
        """Around `StageRunner.take`."""

        @wraps(call)
        def noted(runner: StageRunner, fire_at: int) -> Any:
            self._taken[runner.name] = _now()
            self._wait()
            return call(runner, fire_at)

        return noted

    def delivering(self, call: Call) -> Call:
        """Around `StageRunner.deliver`."""

        @wraps(call)
        def noted(runner: StageRunner, result: Any, header: Any) -> None:
            ended = _now()
            self._wait()
            call(runner, result, header)
            self.fired.append((runner.name, header.time, self._taken[runner.name], ended, _now()))

        return noted

    def receiving(self, call: Call) -> Call:
        """Around `InputQueue.put` and `InputQueue.accept`."""

        @wraps(call)
        def noted(queue: InputQueue, token: Any) -> None:
            if isinstance(token, Message):
                self.arrived.append((queue.name, token.header.time, _now()))
                self._wait()
            call(queue, token)

        return noted

    def writing(self, call: Call) -> Call:
        """Around `Scheduler.close`."""

        @wraps(call)
        def noted(scheduler: Scheduler) -> Any:
            found = {name: rows for name, rows in vars(self).items() if isinstance(rows, list)}
            file = Path(os.environ[FOLDER]) / f"{os.getpid()}.json"
            file.write_text(json.dumps(found), encoding="utf-8")
            return call(scheduler)

        return noted


def _wrap(cls: type, name: str, around: Callable[[Call], Call]) -> None:
    call = getattr(cls, name)
    if not hasattr(call, "__wrapped__"):
        setattr(cls, name, around(call))


if FOLDER in os.environ:
    _notes = _Notes()
    _wrap(SourceRunner, "_next", _notes.making)
    _wrap(SourceRunner, "_stamp", _notes.stamping)
    _wrap(StageRunner, "take", _notes.taking)
    _wrap(StageRunner, "deliver", _notes.delivering)
    _wrap(InputQueue, "put", _notes.receiving)
    _wrap(InputQueue, "accept", _notes.receiving)
    _wrap(Scheduler, "close", _notes.writing)
