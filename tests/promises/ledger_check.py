"""Compares what a run says in its ledger with the journals that its stages kept (journal.py).

It knows the summary of a run as JSON and the lines of the journals, and nothing else of followspot.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

OUTCOMES = ("delivered", "dropped", "late", "unmatched", "invalid", "lost", "in_flight")
_KILLED = re.compile(r"\(process (\d+)\) died: killed by SIGKILL")


class Line(NamedTuple):
    """Of a journal: the process that wrote it, whose message it is, and its number; no other has both."""

    pid: int
    by: str
    value: int


def read(journal: Path) -> list[Line]:
    """All lines; none if nothing was ever written."""
    if not journal.exists():
        return []
    words = (line.split() for line in journal.read_text().splitlines())
    return [Line(int(pid), by, int(value)) for pid, by, value in words]


@dataclass(frozen=True)
class Journals:
    """The journals in a folder. killed: processes that had a SIGKILL, with one message in hand at most."""

    folder: Path
    killed: frozenset[int] = frozenset()

    def of(self, stage: str, what: str) -> list[Line]:
        """A port's journal; what: in.PORT or out.PORT."""
        return read(self.folder / f"{stage.replace('/', '~')}.{what}")

    def files(self, stage: str) -> list[Path]:
        """Those of all ports of a stage."""
        begin = stage.replace("/", "~")
        return [*self.folder.glob(f"{begin}.in.*"), *self.folder.glob(f"{begin}.out.*")]

    def pid(self, stage: str) -> int:
        """The process that wrote last for this stage."""
        newest = max(self.files(stage), key=lambda path: path.stat().st_mtime_ns)
        return read(newest)[-1].pid

    def lines(self) -> int:
        """Of all journals."""
        return sum(len(read(path)) for path in self.folder.glob("*.*.*"))

    def in_hand(self, stage: str) -> int:
        """How many messages this stage may have had in hand when it was killed, over all its processes."""
        return len(self.killed & self._pids.get(stage, frozenset()))

    @cached_property
    def _pids(self) -> Mapping[str, frozenset[int]]:
        found: dict[str, set[int]] = {}
        for journal in self.folder.glob("*.*.*"):
            stage = journal.name.split(".")[0].replace("~", "/")
            found.setdefault(stage, set()).update(line.pid for line in read(journal))
        return {stage: frozenset(pids) for stage, pids in found.items()}


def journals_of(folder: Path, news: Iterable[str], killed: Iterable[int] = ()) -> Journals:
    """The journals of a run. news: what it said, of workers that it saw die; killed: processes, by others."""
    said = {int(pid) for line in news for pid in _KILLED.findall(line)}
    return Journals(folder, frozenset(said | set(killed)))


def disagreements(edges: Sequence[Mapping[str, Any]], journals: Journals) -> list[str]:
    """Everything in which the ledger of a run that has ended differs from the journals."""
    return [*impossible(edges), *_unended(edges), *_differing(edges, journals)]


def impossible(edges: Iterable[Mapping[str, Any]]) -> Iterator[str]:
    """What no ledger may ever show, at the end or while a run goes on."""
    for edge in edges:
        for column in ("produced", "away", "sent", *OUTCOMES):
            if edge[column] < 0:
                yield f"{_name(edge)}: {column} {edge[column]}"
        if edge["produced"] != edge["sent"] + edge["away"]:
            yield f"{_name(edge)}: {edge['produced']} produced, {edge['sent']} sent, {edge['away']} away"
        if edge["sent"] != sum(edge[column] for column in OUTCOMES):
            yield f"{_name(edge)}: {edge['sent']} sent, became {[edge[column] for column in OUTCOMES]}"


def _unended(edges: Iterable[Mapping[str, Any]]) -> Iterator[str]:
    return (f"{_name(edge)}: {edge['in_flight']} in flight" for edge in edges if edge["in_flight"])


def _differing(edges: Sequence[Mapping[str, Any]], journals: Journals) -> Iterator[str]:
    senders = Counter(edge["to"] for edge in edges)
    for edge in edges:
        start, _, port = edge["from"].rpartition(".")
        end, _, into = edge["to"].rpartition(".")
        made = journals.of(start, f"out.{port}")
        got = journals.of(end, f"in.{into}")
        if senders[edge["to"]] > 1:
            origins = {line.by for line in made}
            got = [line for line in got if line.by in origins]
        unsaid = len(made) - edge["produced"]
        if not 0 <= unsaid <= journals.in_hand(start):
            in_hand = f"{journals.in_hand(start)} in hand"
            yield f"{_name(edge)}: {start} made {len(made)}, {edge['produced']} produced, {in_hand}"
        ungot = edge["delivered"] - len(got)
        if not 0 <= ungot <= journals.in_hand(end):
            in_hand = f"{journals.in_hand(end)} in hand"
            yield f"{_name(edge)}: {end} got {len(got)}, {edge['delivered']} delivered, {in_hand}"
        yield from _strange(_name(edge), made, got)


def _strange(name: str, made: Sequence[Line], got: Sequence[Line]) -> Iterator[str]:
    """Messages that came twice, or from nowhere."""
    twice = [value for value, count in Counter(line[1:] for line in got).items() if count > 1]
    if twice:
        yield f"{name}: {len(twice)} messages came twice, {twice[:3]}"
    nowhere = {line[1:] for line in got} - {line[1:] for line in made}
    if nowhere:
        yield f"{name}: {len(nowhere)} messages were never made"


def _name(edge: Mapping[str, Any]) -> str:
    return f"{edge['from']} -> {edge['to']}"
