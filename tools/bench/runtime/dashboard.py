"""Cost of the operator's page for a graph: without it, unwatched, watched, and with a stalled browser.

    python tools/bench/runtime/dashboard.py
    python tools/bench/runtime/dashboard.py --room room.yaml --frames 3000 --rounds 3 --json

The same run in each of four settings, in turns, so that what else the machine does falls on all alike. Of
the second half of each run, when the page is at rest, the frames per second and the processor time of the
graph's own process are told, each as a ratio to the run without a page: the median over the rounds. Browsers
and page have processes of their own. Four rounds take about three minutes on a quiet machine.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import json
import socket
import statistics
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack, contextmanager
from dataclasses import asdict, dataclass
from multiprocessing import get_context
from multiprocessing.connection import Connection
from multiprocessing.synchronize import Event
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Literal, NamedTuple, get_args
from urllib.parse import urlsplit

from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from followspot.control.progress import Progress
from followspot.graph.compile import compile_graph
from followspot.operator.launch import run_plan
from followspot.worker.wiring import RunOptions
from followspot_page.page_process import PageOrder, shown
from scripting import options_of

ROOT = Path(__file__).parents[3]
Setting = Literal["without", "unwatched", "watched", "stalled"]
UPGRADE = (
    "GET /look HTTP/1.1\r\nHost: {}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\nSec-WebSocket-Version: 13\r\n\r\n"
)


@dataclass(frozen=True)
class Trial:
    """One run. shown: previews that its browser got."""

    frames_per_second: float
    cpu_ms_per_frame: float
    dropped: int
    shown: int


@dataclass(frozen=True)
class Row:
    """A setting against the runs without a page: medians over the rounds."""

    setting: Setting
    frames_per_second: float
    cpu_ms_per_frame: float
    throughput: float
    """Frames per second over those of the same round without a page."""
    cpu: float
    dropped: int
    shown: int


class Moment(NamedTuple):
    """Progress of a run, and CPU time of its process until then, s."""

    frames: int
    wall: float
    cpu: float


class Meter:
    """Notes the progress of the second half of a run: by then the page, too, has begun and is at rest."""

    def __init__(self, frames: int) -> None:
        self.frames = frames
        self.moments: list[Moment] = []

    def __call__(self, progress: Progress, expected: int | None) -> None:
        if self.frames <= 2 * progress.fired and progress.fired < self.frames:
            self.moments.append(Moment(progress.fired, time.monotonic(), time.process_time()))


def main() -> None:
    """Measure and print the table."""
    parser = options_of(__doc__)
    parser.add_argument("--graph", default=str(ROOT / "graphs/glowballs.yaml"))
    parser.add_argument("--room", help="room file instead of the graph's own")
    parser.add_argument("--frames", type=int, default=1200, help="frame sets of each run (default 1200)")
    parser.add_argument("--rounds", type=int, default=4)
    parser.add_argument("--rate", type=float, default=10.0, help="pictures a second (default 10)")
    args = parser.parse_args()
    rows = measure(args)
    if args.json:
        print(json.dumps([asdict(row) for row in rows]))
        return
    head = f"{'page':<10} {'frames/s':>9} {'cpu ms':>8} {'throughput':>11} {'cpu':>7}"
    print(f"{head} {'dropped':>8} {'shown':>6}")
    for row in rows:
        speed = f"{row.frames_per_second:>9.1f} {row.cpu_ms_per_frame:>8.2f}"
        ratios = f"{row.throughput:>11.3f} {row.cpu:>7.3f}"
        print(f"{row.setting:<10} {speed} {ratios} {row.dropped:>8} {row.shown:>6}")


def measure(args: argparse.Namespace) -> list[Row]:
    """A row for each setting."""
    settings: tuple[Setting, ...] = get_args(Setting)
    rounds: list[dict[Setting, Trial]] = []
    for number in range(args.rounds):
        turn = settings if number % 2 == 0 else settings[::-1]
        rounds.append({setting: _in_a_process(setting, args) for setting in turn})
    return [_row(setting, rounds) for setting in settings]


def _row(setting: Setting, rounds: list[dict[Setting, Trial]]) -> Row:
    mine = [found[setting] for found in rounds]
    base = [found["without"] for found in rounds]
    pairs = list(zip(mine, base, strict=True))
    return Row(
        setting,
        statistics.median(trial.frames_per_second for trial in mine),
        statistics.median(trial.cpu_ms_per_frame for trial in mine),
        statistics.median(a.frames_per_second / b.frames_per_second for a, b in pairs),
        statistics.median(a.cpu_ms_per_frame / b.cpu_ms_per_frame for a, b in pairs),
        sum(trial.dropped for trial in mine),
        sum(trial.shown for trial in mine),
    )


def _in_a_process(setting: Setting, args: argparse.Namespace) -> Trial:
    """A trial in a fresh process, so that none warms another's caches."""
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        return pool.submit(trial, setting, args).result()


def trial(setting: Setting, args: argparse.Namespace) -> Trial:
    """One run in one setting."""
    plan = compile_graph(args.graph, room=args.room)
    seen: list[int] = []
    with TemporaryDirectory() as out, ExitStack() as stack:
        if setting != "without":
            page = stack.enter_context(shown(PageOrder(os.getpid(), rate=args.rate)))
            if setting != "unwatched":
                host = urlsplit(page.url).netloc
                stack.enter_context(_watching(host, seen, stalled=setting == "stalled"))
        meter = Meter(args.frames)
        report = run_plan(plan, RunOptions(Path(out), args.frames), meter)
    assert report.ok, report.errors
    first, last = meter.moments[0], meter.moments[-1]
    frames = last.frames - first.frames
    dropped = sum(count.dropped for _, count in report.edges)
    rate = frames / (last.wall - first.wall)
    return Trial(rate, 1000.0 * (last.cpu - first.cpu) / frames, dropped, sum(seen))


@contextmanager
def _watching(host: str, seen: list[int], *, stalled: bool) -> Iterator[None]:
    """A browser in a process of its own; what it got is added to `seen` at the end."""
    context = get_context("spawn")
    ready, over = context.Event(), context.Event()
    ours, theirs = context.Pipe()
    browser = context.Process(target=_stall if stalled else _look, args=(host, ready, over, theirs))
    browser.start()
    ready.wait()
    yield
    over.set()
    seen.append(ours.recv())
    browser.join()


def _look(host: str, ready: Event, over: Event, told: Connection) -> None:
    """Take all that comes, like a browser that keeps up."""
    pictures = 0
    ready.set()  # the page answers once the run has begun
    with connect(f"ws://{host}/look", max_size=None, proxy=None, open_timeout=60) as page:
        while not over.is_set():
            try:
                pictures += isinstance(page.recv(timeout=0.5), bytes)
            except TimeoutError:
                continue
            except ConnectionClosed:
                break
    told.send(pictures)


def _stall(host: str, ready: Event, over: Event, told: Connection) -> None:
    """Ask for everything and take nothing, with as little room for it as the system allows."""
    name, _, port = host.rpartition(":")
    with socket.socket() as page:
        page.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1)
        page.connect((name, int(port)))
        page.sendall(UPGRADE.format(host).encode())
        ready.set()
        over.wait()
    told.send(0)


if __name__ == "__main__":
    main()
