"""Stages that each break one promise."""

from __future__ import annotations

import ctypes
import os
import threading
import time
from typing import Any

import numpy as np
from pydantic import ConfigDict

from followspot import Deferred, Field, Lagged, Latest, Outputs, Source, Stage, StageParams, Window, at
from followspot.messages import Array
from followspot.tracking import Blobs, Forecast, Frame, Tracks


class LooseParams(StageParams):
    model_config = ConfigDict(extra="ignore", frozen=False)


class Loose(Stage):
    """Takes any parameter."""

    Params = LooseParams  # type: ignore[assignment]

    def process(self, blobs: Blobs) -> Blobs:
        return blobs


class Writing(Stage):
    """Unlocks the arrays of others."""

    def process(self, blobs: Blobs) -> Blobs:
        object.__setattr__(blobs, "area", blobs.area + 1)
        return blobs


class Reusing(Stage):
    """Sends one array again and again."""

    def setup(self) -> None:
        self.pixels = np.zeros((4, 4, 1), np.uint8)

    def process(self, frame: Frame) -> Frame:
        self.pixels.flags.writeable = True
        self.pixels += 1
        return Frame(frame.camera, self.pixels)


class Unreadable(Exception):
    def __str__(self) -> str:
        raise LookupError


class Speechless(Stage):
    """Raises what says nothing."""

    def process(self, blobs: Blobs) -> Blobs:
        raise Unreadable


class Untyped(Stage):
    """Does not say what it takes."""

    def process(self, blobs) -> Blobs:  # type: ignore[no-untyped-def]
        return blobs


class Stubborn(Stage):
    """Goes on when its generator is closed."""

    def process(self) -> Source[Blobs]:
        for number in range(1, 4):
            try:
                yield at(number, Blobs.empty())
            except GeneratorExit:
                yield at(4, Blobs.empty())


class HalfTimed(Stage):
    """Says times that are no whole numbers."""

    def process(self) -> Source[Blobs]:
        yield at(1.5, Blobs.empty())  # type: ignore[arg-type]


class Guessing(Stage):
    """Does not know its times."""

    def process(self) -> Source[Blobs]:
        yield at(1, Blobs.empty())

    def capture_time(self, number: int) -> int | None:
        raise LookupError


class Clocked(Stage):
    """Sends the time of day."""

    def process(self, frame: Frame) -> Frame:
        return Frame(frame.camera, np.array([[[time.perf_counter_ns() % 251]]], np.uint8))


class Lingering(Stage):
    """Waits for somebody who does not come."""

    def process(self, blobs: Blobs) -> None:
        self.busy = True

    def close(self) -> None:
        time.sleep(1.1)


class Drawing(Stage):
    """Draws from the generator of all."""

    def process(self, blobs: Blobs) -> Blobs:
        np.random.random()  # noqa: NPY002
        return blobs


class Printing(Stage):
    """Prints."""

    def process(self, blobs: Blobs) -> Blobs:
        print("blobs")
        return blobs


class PrintingBytes(Stage):
    """Prints past `print`, as a library in C does."""

    def process(self, blobs: Blobs) -> Blobs:
        os.write(1, b"\xff blobs\n")
        return blobs


class PrintingBuffered(Stage):
    """Prints from C, which keeps the text in a buffer."""

    def process(self, blobs: Blobs) -> Blobs:
        ctypes.CDLL(None).puts(b"blobs")
        return blobs


class WrongType(Stage):
    """Returns what it does not declare."""

    def process(self, blobs: Blobs) -> Tracks:
        return blobs  # type: ignore[return-value]


class NoMessage(Stage):
    """Returns no message at all."""

    def process(self, blobs: Blobs) -> Tracks:
        return [blobs]  # type: ignore[return-value]


class Timed(Stage):
    """Says at which time its result was captured, though it is no source."""

    def process(self, blobs: Blobs) -> Blobs:
        return at(blobs.header.time - 1, blobs)


class Hasty(Stage):
    """Gives a message for a firing that is yet to come."""

    def process(self, frame: Frame) -> Lagged[Frame]:
        return [at(frame.header.time + 1, Frame(frame.camera, frame.pixels))]


class Unending(Stage):
    """Gives what remains without times."""

    def process(self, frame: Frame) -> Lagged[Frame]:
        self.frame = frame
        return ()

    def remaining(self) -> list[Frame]:
        return [Frame(self.frame.camera, self.frame.pixels)]


class EarlyOutputs(Stage):
    """Gives several messages, one before the time of the firing."""

    def process(self, blobs: Blobs) -> Outputs[Blobs]:
        return blobs, at(blobs.header.time - 1, blobs)


class LateAnswer(Stage):
    """Answers later, with a message of another type."""

    def process(self, blobs: Blobs) -> Deferred[Tracks]:
        return lambda: blobs  # type: ignore[return-value]


class WindowWriter(Stage):
    """Changes a message of its window."""

    def process(self, blobs: Blobs, window: Window[Blobs] = ()) -> Blobs:
        for other in window:
            object.__setattr__(other, "area", other.area + 1)
        return blobs


class WrongShape(Stage):
    """Returns arrays of other shapes than it declares."""

    def process(self, frame: Frame) -> Frame:
        return Frame(frame.camera, np.zeros((2, 2), np.uint8))


class Stranger(Stage):
    """Speaks of no camera of the room."""

    def process(self, frame: Frame) -> Blobs:
        return Blobs.empty()


class NotANumber(Stage):
    """Trusts its input."""

    def process(self, forecast: Forecast) -> Forecast:
        forecast.xyz.astype(int)
        if np.isnan(forecast.xyz).any():
            raise ValueError("not a number")
        return forecast


class Late(Stage):
    """Trusts the clock."""

    last = -1

    def process(self, blobs: Blobs) -> Blobs:
        if blobs.header.time <= self.last:
            raise ValueError("time goes back")
        self.last = blobs.header.time
        return blobs


class SmallPicture(Stage):
    """Trusts the size of pictures."""

    def process(self, frame: Frame) -> Frame:
        return Frame(frame.camera, frame.pixels[20:21, 20:21] // frame.pixels[20, 20].shape)


class Hoarding(Stage):
    """Keeps everything."""

    def setup(self) -> None:
        self.kept: list[Array] = []

    def process(self, frame: Frame) -> Frame:
        self.kept.append(frame.pixels.astype(float))
        return Frame(frame.camera, frame.pixels.copy())


class Threaded(Stage):
    """Leaves a thread behind."""

    def setup(self) -> None:
        threading.Thread(target=threading.Event().wait, args=(20,), daemon=True).start()

    def process(self, blobs: Blobs) -> Blobs:
        return blobs


class Opening(Stage):
    """Leaves a file open."""

    kept: list[Any] = []  # noqa: RUF012

    def process(self, blobs: Blobs) -> Blobs:
        self.kept.append(open("/dev/null"))  # noqa: SIM115, PTH123
        return blobs


class NeedsSetup(Stage):
    """Cannot be closed before it was set up."""

    def setup(self) -> None:
        self.file = open("/dev/null")  # noqa: SIM115, PTH123

    def process(self, blobs: Blobs) -> Blobs:
        return blobs

    def close(self) -> None:
        self.file.close()


class ObjectState(Stage):
    """Has a state that does not travel."""

    def process(self, blobs: Blobs) -> Blobs:
        return blobs

    def state(self) -> Any:
        return {"lock": threading.Lock()}


class Forgetful(Stage):
    """Says its state and forgets it."""

    count = 0

    def process(self, frame: Frame) -> Frame:
        self.count += 1
        return Frame(frame.camera, np.full((1, 1, 1), self.count, np.uint8))

    def state(self) -> Any:
        return self.count


class Backwards(Stage):
    """Yields times that fall."""

    class Params(StageParams):
        start: int = Field(5, description="first time", unit="ns")

    params: Params

    def process(self) -> Source[Frame]:
        for n in range(self.params.start):
            yield at(self.params.start - n, Frame("cam0", np.zeros((1, 1, 1), np.uint8)))


class Misdated(Stage):
    """Tells other capture times than its messages have."""

    def capture_time(self, number: int) -> int:
        return number

    def process(self) -> Source[Frame]:
        for n in range(3):
            yield at(2 * n, Frame("cam0", np.zeros((1, 1, 1), np.uint8)))


class Unsteady(Stage):
    """Yields something else each time."""

    def process(self) -> Source[Frame]:
        for n in range(3):
            yield at(n, Frame("cam0", np.array([[[time.perf_counter_ns() % 251]]], np.uint8)))


class Undeclared(Stage):
    """Yields what it does not declare."""

    def process(self) -> Source[Frame]:
        yield at(0, Blobs.empty())  # type: ignore[misc]


class Timeless(Stage):
    """Yields without a capture time, though it is no device."""

    def process(self) -> Source[Blobs]:
        yield Blobs.empty()


class Lonely(Stage):
    """Needs what is only held."""

    def process(self, blobs: Blobs, forecast: Latest[Forecast] = None) -> Blobs:
        return blobs.where(np.arange(len(forecast.xyz)))  # type: ignore[union-attr]


class Hashing(Stage):
    """Gives what depends on the hash of a text, which differs from process to process."""

    def process(self, frame: Frame) -> Frame:
        return Frame(frame.camera, np.full((4, 4, 1), hash(frame.camera) % 251, np.uint8))


class HashingSource(Stage):
    """Yields what depends on the hash of a text."""

    def process(self) -> Source[Frame]:
        name = next(iter(self.room.cameras))
        for n in range(4):
            yield at(n, Frame(name, np.full((4, 4, 1), hash(f"{name}{n}") % 251, np.uint8)))
