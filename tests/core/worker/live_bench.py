"""A live source in a worker of its own, with a device that gives what a test asks it for."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator

from followspot import Context, Message, Source, Stage, at
from followspot.worker.inputs.input_queue import InputQueue
from followspot.worker.inputs.join import Join
from followspot.worker.ledger import EdgeCount, Ledger
from followspot.worker.output_port import OutputPort
from followspot.worker.runners.live_source import LiveSourceRunner


class Note(Message):
    number: int


class Device(Stage):
    """Yields as many messages as a test wants, and signals each request for another one."""

    live = True

    def __init__(self) -> None:
        super().__init__(Context())
        self.wanted = threading.Semaphore(0)
        self.asked = threading.Semaphore(0)
        self.made = 0
        self.fails = False

    def process(self) -> Source[Note]:
        yield from self.items(lambda n: at(n, Note(n)))

    def items(self, made: Callable[[int], object]) -> Iterator[object]:
        while True:
            self.asked.release()
            self.wanted.acquire()
            if self.fails:
                raise RuntimeError("it fell down")
            self.made += 1
            yield made(self.made)

    def make(self, count: int) -> None:
        for _ in range(count):
            self.wanted.release()
            assert self.asked.acquire(timeout=60)

    def close(self) -> None:
        self.wanted.release()


class Bench:
    """A live source with a reader for each port in the same worker. ledger: of a worker that died."""

    def __init__(self, device: Device, *ports: str, ledger: Ledger | None = None) -> None:
        self.ledger = Ledger(len(ports) + 1) if ledger is None else ledger
        self.queues = []
        outputs = {}
        for n, port in enumerate(ports):
            queue = InputQueue(port, self.ledger.words, self.ledger.row(n), depth=100, lateness=0)
            outputs[port] = OutputPort(Note, self.ledger.words, lateness=0)
            outputs[port].connect([queue])
            self.queues.append(queue)
        self.device = device
        self.runner = LiveSourceRunner("camera", 0, lambda: device, Join((), lateness=0), outputs)
        self.runner.notify = lambda: None

    def begin(self) -> None:
        self.runner.setup()
        self.runner.start()
        assert self.device.asked.acquire(timeout=60)

    def pull_all(self) -> None:
        """Until it has nothing to give now, or is over."""
        while not self.runner.done and self.runner.pull():
            pass

    def count(self, port: int = 0) -> EdgeCount:
        return self.ledger.count(port)
