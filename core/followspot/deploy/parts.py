"""All parts of runs that an agent has: found for whoever asks, ended when nobody does any more."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any, Literal

from followspot.deploy.part import KeptParts, Part
from followspot.errors import FollowspotError

MAX_RUNS = 16
_KEPT = 600.0
"""Seconds that the last status of a run that goes on alone is kept for an operator to fetch."""
_REMEMBERED = 256
"""How many runs that were given up are remembered by name."""

Known = Literal["here", "given up", "unknown"]


class Parts:
    """By the name of the run.

    kept: remembers those that go on alone.
    """

    def __init__(self, runs: Path, host: str, tell: Callable[[str], None]) -> None:
        """runs, host: as `KeptParts` takes them; tell: gets lines for the log."""
        self.kept = KeptParts(runs, host)
        self._tell = tell
        self._parts: dict[str, Part] = {}
        self._given_up: deque[str] = deque(maxlen=_REMEMBERED)

    def __iter__(self) -> Iterator[Part]:
        return iter(tuple(self._parts.values()))

    def part(self, run: str) -> Part:
        """The part of a run whose operator asks for it now. Raises FollowspotError where there is none."""
        part = self._parts.get(run)
        if part is None or part.operator.given_up:
            raise FollowspotError(f"there is no run {run!r} here")
        part.operator.heard(time.monotonic())
        return part

    def known(self, run: str) -> Known:
        """Whether there is a part of this run."""
        if run in self._given_up:
            return "given up"
        return "here" if run in self._parts else "unknown"

    def check_room(self, run: str) -> None:
        """Raises FollowspotError where no part of this run can be added."""
        if self.known(run) == "given up":
            self.close(run)
        if run in self._parts:
            raise FollowspotError(f"the run {run!r} is here already")
        if len(self._parts) >= MAX_RUNS:
            for part in [part for part in self if part.over]:
                self.close(part.order.run)
        if len(self._parts) >= MAX_RUNS:
            raise FollowspotError(f"this host has parts of {MAX_RUNS} runs already, and takes no more")

    def add(self, part: Part) -> None:
        """One more; it may have been given up before."""
        run = part.order.run
        self._parts[run] = part
        if run in self._given_up:
            self._given_up.remove(run)

    def close(self, run: str) -> None:
        """Forget a run; what still lives is killed."""
        part = self._parts.pop(run, None)
        if part is not None:
            part.run.close()
            self.kept.forget(part)
            self._tell(f"run {run[:8]} of {part.graph}: over")

    def tidy(self, now: float) -> None:
        """End what nobody wants any more, forget what nobody fetched, remember the rest. now: the time, s."""
        for part in self:
            run = part.order.run
            if (line := part.operator.look(now)) and not part.over:
                part.run.tell("warning" if part.operator.silent else "info", line)
                self._tell(f"run {run[:8]} of {part.graph}: {line}")
            if part.operator.given_up and run not in self._given_up:
                self._given_up.append(run)
                part.leave(now)
            if part.left(now) or (part.order.detached and part.over and part.operator.seconds(now) > _KEPT):
                self.close(run)
        self.kept.keep(self, now)

    def forget(self) -> None:
        """None of them is to be taken up again."""
        for part in self:
            self.kept.forget(part)

    def listing(self) -> Sequence[dict[str, Any]]:
        """All, as JSON types."""
        now = time.monotonic()
        return [
            {
                "run": part.order.run,
                "graph": part.graph,
                "over": part.over,
                "detached": part.order.detached,
                "silent_s": part.operator.seconds(now),
                "origin": asdict(part.order.origin),
            }
            for part in self
        ]
