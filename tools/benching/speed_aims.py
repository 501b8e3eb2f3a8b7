"""The aims of docs/speed_causes.md beside what the tables tell, so that no figure is copied by hand."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from operator import ge, le

HEAD = ("aim", "limit", "measured", "held", "by")
OWN = "followspot, a process for each camera"
EDGES = "bench/runtime/edges"
BESIDE_PEERS = "bench/runtime/peers"
FORECAST_DELAY = "bench/runtime/forecast_delay"
LIVE_LATENCY = "bench/runtime/live_latency"
START = "bench/runtime/start"
BUSY_MACHINE = "bench/runtime/busy_machine"
SCALING = "bench/runtime/scaling"
PEERS = ("multiprocessing", "ezmsg", "dora")


@dataclass(frozen=True)
class Table:
    """A table of the page."""

    head: Sequence[str]
    rows: Sequence[Sequence[str]]


class Page:
    """The tables of the page by the tool that printed them."""

    def __init__(self, printed: Mapping[str, Sequence[Table]]) -> None:
        self._printed = printed

    def cell(self, tool: str, column: str, *row: str) -> float:
        """A number: of the first table with such a column and a row that begins so. Raises LookupError."""
        for table in self._printed.get(tool, ()):
            if column in table.head:
                for cells in table.rows:
                    if tuple(cells[: len(row)]) == row:
                        return float(cells[table.head.index(column)])
        raise LookupError(f"{tool} printed no {column} of {', '.join(row)}")


@dataclass(frozen=True)
class Aim:
    """A figure of a tool that should be at most or at least as large as a limit."""

    text: str
    tool: str
    measured: Callable[[Page], float]
    limit: Callable[[Page], float]
    held: Callable[[float, float], bool] = le


def aims(page: Page) -> Iterator[tuple[str, ...]]:
    """The cells of each. Raises LookupError if a table lacks what an aim needs."""
    for aim in AIMS:
        measured, limit = aim.measured(page), aim.limit(page)
        bound = "at most" if aim.held is le else "at least"
        held = "yes" if aim.held(measured, limit) else "**no**"
        yield aim.text, f"{bound} {limit:.4g}", f"{measured:.3g}", held, f"`{aim.tool}`"


def tables(text: str) -> Iterator[Table]:
    """The tables in a piece of Markdown."""
    for part in text.strip().split("\n\n"):
        head, _, *rows = ([cell.strip() for cell in line.strip("|").split("|")] for line in part.split("\n"))
        yield Table(head, rows)


def _at(tool: str, column: str, *row: str) -> Callable[[Page], float]:
    return lambda page: page.cell(tool, column, *row)


def _is(limit: float) -> Callable[[Page], float]:
    return lambda _: limit


def _hop(text: str, column: str, row: str, limit: float) -> Aim:
    return Aim(text, EDGES, _at(EDGES, column, row), _is(limit))


def _beside_peers(column: str, best: Callable[[Iterator[float]], float]) -> Callable[[Page], float]:
    def ratio(page: Page) -> float:
        others = (page.cell(BESIDE_PEERS, column, peer) for peer in PEERS)
        return page.cell(BESIDE_PEERS, column, OWN) / best(others)

    return ratio


def _scaling(side: str) -> Aim:
    text = f"two processes with `delay: 2`, {side}, times one process"
    return Aim(text, FORECAST_DELAY, _at(FORECAST_DELAY, "x one", side, "2", "auto"), _is(1.7), ge)


def _live(row: str) -> Aim:
    text = f"capture to track, {row}: the stages' own time and 0.5 ms a hop, p50, ms"
    return Aim(text, LIVE_LATENCY, _at(LIVE_LATENCY, "p50", row), _at(LIVE_LATENCY, "aim", row))


def _tracker(text: str, column: str, side: str, limit: float) -> Aim:
    return Aim(text, "bench_tracker", _at("bench_tracker", column, side), _is(limit), ge)


def _seven(page: Page) -> float:
    """CPU time of seven workers, s: of a run with them less that of one process."""
    return page.cell(START, "all", "forked") - page.cell(START, "all", "one process")


AIMS = (
    _hop("a hop of 1 kB, p50, us", "p50 us", "1 kB ring in place", 100),
    _hop("a hop of a picture, p50, us", "p50 us", "640x480 ring in place", 150),
    _hop("processor time of a picture's hop, both ends, us", "CPU us", "640x480 ring in place", 350),
    _hop("a hop of 1 kB, times the bare ring", "x p50", "1 kB ring in place", 2.0),
    _hop("a hop of a picture, times the bare ring", "x p50", "640x480 ring in place", 1.3),
    Aim("frame sets/s, times the best peer", BESIDE_PEERS, _beside_peers("sets/s", max), _is(1), ge),
    Aim("latency p50, times the best peer", BESIDE_PEERS, _beside_peers("p50 ms", min), _is(1)),
    Aim("latency p99, times the best peer", BESIDE_PEERS, _beside_peers("p99 ms", min), _is(1)),
    Aim("processor time, times the best peer", BESIDE_PEERS, _beside_peers("CPU ms", min), _is(1)),
    Aim("memory, times the best peer", BESIDE_PEERS, _beside_peers("MB", min), _is(1)),
    Aim("lines of a user, times the best peer", BESIDE_PEERS, _beside_peers("lines", min), _is(1)),
    *(_scaling(side) for side in ("tracked", "searching")),
    Aim(
        "ball path beside two programs that never rest, with `realtime`, p99, ms (limit: alone)",
        BUSY_MACHINE,
        _at(BUSY_MACHINE, "p99", "beside two others, realtime: 10"),
        _at(BUSY_MACHINE, "p99", "alone"),
    ),
    Aim("start of a worker, CPU s", START, _at(START, "a worker more", "forked"), _is(0.3)),
    Aim("start of seven workers, CPU s", START, _seven, _is(2)),
    *(_live(f"{name}, {rate}/s") for name in ("one worker", "two workers", "camera") for rate in (30, 60)),
    _tracker("tracked, times the plain script", "ratio", "tracked", 3),
    _tracker("searching, times the plain script", "ratio", "searching", 3),
    _tracker("frame sets/s tracked", "graph", "tracked", 800),
    _tracker("frame sets/s searching", "graph", "searching", 300),
    Aim(
        "six cameras of 1080p at 60/s: processor time of a searching frame set on two cores, ms",
        SCALING,
        _at(SCALING, "searching, ms", "6", "6", "1920x1080"),
        _is(2e3 / 60),
    ),
)
"""What speed is held against. With peers, a process for each camera is meant."""
