"""A sub-graph is swapped again and again in several workers: journals of the stages agree with the ledger.

In a replay nothing is lost on the way from one file to the next. In a live run workers die meanwhile.
"""

from __future__ import annotations

import os
import random
import threading
import time
import uuid
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from itertools import cycle
from pathlib import Path
from typing import Any

import pytest
from tests.integration.hosts import near_agent
from tests.integration.running import Finished, finish, start, write_graph
from tests.promises.journaled import STAGES, Journaled
from tests.promises.ledger_check import Journals, impossible, journals_of

from followspot.errors import FollowspotError
from followspot.operator.connect import run_here

COUNT = 100
"""Notes of a film that nobody asks for more."""
GRAPH = """
cam:  {{uses: journal.{source}, with: {{size: {size}, count: {count}}}}}
slow: {{uses: journal.step, in: {{note: cam}}}}
hall: {{graph: one.yaml, in: {{note: slow}}}}
save: {{uses: journal.save, in: {{note: hall}}}}
side: {{uses: journal.meet, in: {{notes: [cam, hall]}}, tolerance: 0.002}}
rest: {{uses: journal.save, with: {{path: side.csv}}, in: {{note: side}}}}
"""
FILES = {
    "one": """
inputs: {note: a.note}
outputs: {note: a}
stages:
  a: {uses: journal.step}
""",
    "two": """
inputs: {note: a.note}
outputs: {note: b}
stages:
  a: {uses: journal.step}
  b: {uses: journal.step, in: {note: a}}
""",
    "feedback": """
inputs: {note: b.note}
outputs: {note: c}
stages:
  b: {uses: journal.step}
  c: {uses: journal.sampling, in: {note: b, known: {from: c, delay: 1}}}
""",
    "halves": """
inputs: {note: s.note}
outputs: {note: m}
stages:
  s: {uses: journal.split}
  a: {uses: journal.step, in: {note: s.even}}
  d: {uses: journal.step, in: {note: s.odd}}
  m: {uses: journal.meet, in: {notes: [a, d]}, tolerance: 0.002}
""",
    "sick": """
inputs: {note: x.note}
outputs: {note: x}
stages:
  x: {uses: journal.sick}
""",
}
ENTRIES = {("slow.out", f"hall/{first}.note") for first in "abs"}
"""Into each file: every note of `slow` goes one of these ways."""
STAY = {("cam.out", "slow.note"), ("cam.out", "side.notes"), ("side.out", "rest.note")}
"""Edges that no file changes."""
STAGES_APART = ["cam", "slow", "hall/a", "side", "rest", "save"]
LOSSES = ("lost", "dropped", "late", "invalid", "unmatched")


class Run(Journaled):
    """A run of two to four workers."""

    def __init__(self, folder: Path, chance: random.Random, *, live: bool, edges: str) -> None:
        """edges: as --edges; "hosts" for workers in turn here and under two agents."""
        self.chance, self.live, self.files = chance, live, folder
        stages = chance.sample(STAGES_APART, len(STAGES_APART))
        count = chance.choice([2, 3, 4])
        groups = {f"w{n}": stages[n::count] for n in range(count)}
        firsts = {name: group[0] for name, group in groups.items()}
        super().__init__(f"swaps-{uuid.uuid4().hex[:8]}", folder / "journals", folder / "out", firsts)
        self.folder.mkdir()
        for name, text in FILES.items():
            (folder / f"{name}.yaml").write_text(text)
        source, endless = ("camera", 10**9) if live else ("film", COUNT)
        text = GRAPH.format(source=source, size=chance.choice([0, 6000]), count=endless)
        placement = folder / "placement.yaml"
        os.environ["JOURNALS"] = str(self.folder)
        hosts = ("pc-left", "pc-right") if edges == "hosts" else ()
        self.agents = [near_agent(host, folder, "--plugin", STAGES) for host in hosts]
        lines = (
            f"  {name}: {{{host}stages: [{', '.join(group)}]}}\n"
            for (name, group), host in zip(groups.items(), cycle(["", *map("host: {}, ".format, hosts)]))
        )
        placement.write_text(f"placement: apart\nworkers:\n{''.join(lines)}")
        self.more = self.folder / "more.cam"
        self.more.touch()
        words = ["--plugin", str(STAGES), "--placement", str(placement)]
        for agent in self.agents:
            words += "--connect", agent.endpoint
        words += () if self.agents else ("--edges", edges)
        self.process = start(write_graph(folder, text, self.name), self.out, *words)
        self.refused: list[str] = []

    def __exit__(self, *found: object) -> None:
        super().__exit__(*found)
        for agent in self.agents:
            agent.process.kill()
            agent.process.communicate()

    def parents(self) -> list[int]:
        return [self.process.pid, *(agent.process.pid for agent in self.agents)]

    def swap(self) -> None:
        """Put any file in the place of any; a sick one is refused."""
        file = self.chance.choice(list(FILES))
        try:
            run_here(str(self.process.pid)).change([f"hall={self.files / file}.yaml"])
        except FollowspotError as error:
            self.refused.append(f"{file}: {error}")

    def swaps(self, count: int) -> None:
        """One after the other, or several at once, or while the replay is paused, or a worker dies."""
        handle = run_here(str(self.process.pid))
        for _ in range(count):
            kind = self.chance.choice(["alone", "together", "disturbed"])
            if kind == "together":
                together([self.swap] * 3)
            elif kind == "disturbed" and self.live:
                together([self.swap, self.disturb])
            elif kind == "disturbed":
                handle.pause()
                self.swap()
                handle.step(self.chance.choice([1, 3]))
                self.swap()
                handle.resume()
            else:
                self.swap()
            if self.live:
                self.goes_on("save", "rest")

    def disturb(self) -> None:
        time.sleep(self.chance.choice([0.0, 0.03, 0.3]))
        self.chance.choice([self.kill, self.suspend])(self.chance.choice(list(self.workers)))


def together(works: list[Callable[[], None]]) -> None:
    threads = [threading.Thread(target=work) for work in works]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()


def by_ends(edges: list[dict[str, Any]]) -> Mapping[tuple[str, str], Counter[str]]:
    """The counts of the edges between two ports: one that came back is another edge."""
    found: dict[tuple[str, str], Counter[str]] = {}
    for edge in edges:
        counts = {key: value for key, value in edge.items() if isinstance(value, int)}
        found.setdefault((edge["from"], edge["to"]), Counter()).update(counts)
    return found


def differing(edges: list[dict[str, Any]], journals: Journals) -> Iterator[str]:
    """What the ledger and the journals do not agree on."""
    yield from impossible(edges)
    sums = by_ends(edges)
    for ends, counts in sums.items():
        start, end = ends
        sender, _, out = start.rpartition(".")
        reader, _, into = end.rpartition(".")
        made = journals.of(sender, f"out.{out}")
        got = [line for line in journals.of(reader, f"in.{into}") if line.by == sender]
        name = f"{start} -> {end}"
        if counts["in_flight"]:
            yield f"{name}: {counts['in_flight']} in flight"
        if not 0 <= counts["delivered"] - len(got) <= journals.in_hand(reader):
            yield f"{name}: {counts['delivered']} delivered, {reader} got {len(got)}"
        unsaid = len(made) - counts["produced"]
        if unsaid < 0 or (ends in STAY and unsaid > journals.in_hand(sender)):
            yield f"{name}: {counts['produced']} produced, {sender} made {len(made)}"
        if into != "known" and len({line.value for line in got}) < len(got):
            yield f"{name}: some came twice"
    made = len(journals.of("slow", "out.out"))
    entered = sum(counts["produced"] for ends, counts in sums.items() if ends in ENTRIES)
    if not 0 <= made - entered <= journals.in_hand("slow"):
        yield f"slow made {made}, and {entered} went into a file"


def judge(run: Run, finished: Finished) -> None:
    assert finished.code == 0, finished.errors
    edges = finished.summary["edges"]
    journals = journals_of(run.folder, finished.summary["warnings"], run.killed)
    assert not list(differing(edges, journals))
    assert all(text.startswith(("sick", "another")) for text in run.refused) or run.killed
    if run.live:
        return
    lost = {
        ends: [c[k] for k in LOSSES] for ends, c in by_ends(edges).items() if not ends[1].endswith("known")
    }
    assert not {ends: counts for ends, counts in lost.items() if any(counts)}
    film = [line.value for line in journals.of("cam", "out.out")]
    assert len(film) >= COUNT
    for sink in ("save", "rest"):
        assert [line.value for line in journals.of(sink, "in.note")] == film, (
            f"{sink} got each once, in order"
        )


MORE = [(live, edges, n) for live in (False, True) for edges in ("ring", "zenoh", "hosts") for n in range(4)]


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("live", "edges", "seed"),
    [(False, "ring", 10), *MORE],
)
def test_every_message_goes_through_one_file_or_is_counted(
    tmp_path: Path, live: bool, edges: str, seed: int
) -> None:
    with Run(tmp_path, random.Random(seed), live=live, edges=edges) as run:
        with run.asked("slow", "slow"):
            run.goes_on("save")
            run.swaps(4)
        run.more.unlink()
        judge(run, run.end() if live else finish(run.process, run.out))
