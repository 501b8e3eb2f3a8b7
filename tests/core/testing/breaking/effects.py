"""Stages that act on others, or depend on what no input says: the clock, memory, threads, files."""

from __future__ import annotations

import ctypes
import os
import threading
import time
from typing import Any

import numpy as np

from followspot import Stage
from followspot.messages import Array
from followspot.tracking import Blobs, Frame


class Clocked(Stage):
    """Sends the time of day."""

    def process(self, frame: Frame) -> Frame:
        return Frame(frame.camera, np.array([[[time.perf_counter_ns() % 251]]], np.uint8))


class Lingering(Stage):
    """Takes longer than a second to close."""

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


class Hashing(Stage):
    """Gives what depends on the hash of a text, which differs from process to process."""

    def process(self, frame: Frame) -> Frame:
        return Frame(frame.camera, np.full((4, 4, 1), hash(frame.camera) % 251, np.uint8))
