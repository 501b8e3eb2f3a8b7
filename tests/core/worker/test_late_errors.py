"""What a live source raises after the run asked it to end is told, and does not fail the run."""

from __future__ import annotations

import errno
import logging
import threading
from pathlib import Path

import pytest
from tests.core.worker.live_bench import Bench, Device, Note

import followspot as fs
from followspot import Context, Source, Stage
from followspot.worker.runners.error_policy import StageError

CLOSED = [
    OSError(errno.EBADF, "Bad file descriptor"),
    OSError(errno.ENODEV, "No such device"),
    EOFError(),
    ValueError("I/O operation on closed file."),
    ValueError("file descriptor cannot be a negative integer (-1)"),
]
"""What Python raises if another thread closes the file, socket, pipe or device that one waits for."""
OTHERS = [OSError(errno.ENOSPC, "No space left on device"), ValueError("wrong byte"), SystemExit(1)]


class Taken(Device):
    """A device that `close` takes away, so that the wait for it raises."""

    def __init__(self, error: BaseException) -> None:
        super().__init__()
        self.error = error
        self.warnings: list[str] = []
        self.ending = False
        self.context = Context("taken", warn=self.warnings.append, pause=lambda _: not self.ending)

    def process(self) -> Source[Note]:
        yield Note(0)
        self.asked.release()
        self.wanted.acquire()
        raise self.error

    def raise_now(self, bench: Bench) -> None:
        """Let it raise, and wait for the end of its thread."""
        assert bench.runner._thread is not None
        self.wanted.release()
        bench.runner._thread.join(60)


def begun(device: Taken) -> Bench:
    bench = Bench(device, "out")
    bench.begin()
    return bench


@pytest.mark.parametrize("error", CLOSED, ids=str)
def test_a_device_that_close_takes_away_ends_the_stream(
    error: Exception, caplog: pytest.LogCaptureFixture
) -> None:
    bench = begun(device := Taken(error))
    with caplog.at_level(logging.INFO):
        bench.runner.stop()
    bench.pull_all()
    assert bench.runner.done
    assert not device.warnings
    assert [record.getMessage() for record in caplog.records] == [
        f"close ended its wait: {type(error).__name__}: {error}"
    ]


@pytest.mark.parametrize("error", OTHERS, ids=str)
@pytest.mark.parametrize("policy", ["fail", "skip", "restart"])
def test_another_error_after_the_end_is_a_warning(error: BaseException, policy: fs.graph.ErrorPolicy) -> None:
    bench = begun(device := Taken(error))
    bench.runner.on_error = policy
    bench.runner.stop()
    bench.pull_all()
    assert bench.runner.done
    assert device.warnings == [f"raised after it was asked to end: {type(error).__name__}: {error}"]


def test_the_run_has_asked_as_soon_as_pause_says_so() -> None:
    bench = begun(device := Taken(RuntimeError("it fell down")))
    device.ending = True
    device.raise_now(bench)
    bench.pull_all()
    assert bench.runner.done
    assert device.warnings == ["raised after it was asked to end: RuntimeError: it fell down"]


@pytest.mark.parametrize("error", [*CLOSED, *OTHERS], ids=str)
def test_an_error_before_that_fails_the_run_even_if_it_is_seen_later(error: BaseException) -> None:
    bench = begun(device := Taken(error))
    device.raise_now(bench)
    bench.runner.stop()
    with pytest.raises(StageError, match=type(error).__name__):
        bench.pull_all()


def test_an_error_of_a_device_that_was_replaced_is_a_warning() -> None:
    bench = begun(first := Taken(RuntimeError("it fell down")))
    old = bench.runner._thread
    assert old is not None
    bench.runner.replace_stage(second := Device(), lambda: second)
    first.wanted.release()
    old.join(60)
    assert first.warnings == ["raised after it was asked to end: RuntimeError: it fell down"]
    bench.runner.stop()


class Unreadable(ValueError):
    def __str__(self) -> str:
        raise RuntimeError("no text")


def test_an_error_whose_text_cannot_be_read_is_a_warning() -> None:
    bench = begun(device := Taken(Unreadable()))
    bench.runner.stop()
    assert device.warnings == ["raised after it was asked to end: Unreadable: its text cannot be read"]


class Waits(Stage):
    """Waits for what only `close` ends, which makes the wait raise."""

    live = True

    def setup(self) -> None:
        self.closed = threading.Event()

    def process(self) -> Source[Note]:
        yield Note(0)
        self.closed.wait(60)
        raise OSError(errno.EBADF, "Bad file descriptor")

    def close(self) -> None:
        self.closed.set()


def test_a_run_that_is_stopped_while_its_source_waits_is_a_success(tmp_path: Path) -> None:
    graph = fs.Graph("waits")
    graph.add("waits", Waits)
    with fs.run(graph, out=tmp_path, ports="waits") as run:
        next(iter(run["waits"]))
        run.stop()
        report = run.wait()
    assert report.ok
    assert not report.warnings
