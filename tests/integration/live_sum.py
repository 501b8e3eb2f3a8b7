"""A live graph whose sum has numbers of two hosts, and the file that grows meanwhile."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from tests.integration.running import wait_until

LIVE = """
a:    {uses: ticks.live, with: {count: 1000000, period: 0.02}}
b:    {uses: ticks.live, with: {count: 1000000, period: 0.02}}
more: {uses: ticks.add, in: {number: a}, with: {term: 10000000}}
less: {uses: ticks.add, in: {number: b}, with: {term: 1000000}}
sum:  {uses: ticks.sum, in: {numbers: [more, less]}, tolerance: 0.008}
save: {uses: ticks.write, in: {number: sum}}
"""


def values(path: Path) -> list[int]:
    lines = path.read_text().splitlines() if path.exists() else []
    return [int(fields[2]) for line in lines if len(fields := line.split(",")) == 4]


def grows(path: Path, fits: Callable[[int], bool] = lambda value: True, more: int = 10) -> None:
    """Wait until `more` further lines whose values fit were written."""
    before = len(values(path))
    assert wait_until(lambda: sum(map(fits, values(path)[before:])) >= more, 40.0), values(path)[-5:]


def of_left(value: int) -> bool:
    """True for a value to which the left host contributes: it counts from ten million, the other from one."""
    return value >= 10_000_000
