"""The ledger tells the truth: journals of the stages agree with it, whatever befalls the run.

Faults at random: workers killed, hanging, suspended for a moment; readers that are slow; a disk that is full.
"""

from __future__ import annotations

import os
import random
import uuid
from collections.abc import Callable
from pathlib import Path

import pytest
from tests.integration.running import start, write_graph
from tests.promises.journaled import STAGES, Journaled
from tests.promises.ledger_check import impossible

LIVE = """
cam:   {uses: journal.camera}
left:  {uses: journal.step, with: {invalid_every: 50}, in: {note: cam}}
right: {uses: journal.sampling, in: {note: {from: cam, policy: drop_oldest}, known: {from: both, delay: 1}}}
split: {uses: journal.split, in: {note: cam}}
even:  {uses: journal.step, in: {note: split.even}}
both:  {uses: journal.meet, in: {notes: [left, right]}}
save:  {uses: journal.save, in: {note: both}, on_error: skip}
odd:   {uses: journal.save, with: {path: odd.csv}, in: {note: split.odd}, on_error: skip}
rest:  {uses: journal.save, with: {path: even.csv}, in: {note: even}, on_error: skip}
"""
PLACEMENT = """
placement: five
workers:
  first:  {stages: [cam]}
  second: {stages: [left, split]}
  third:  {stages: [right]}
  fourth: {stages: [both, save]}
  fifth:  {stages: [even, rest, odd]}
"""
WORKERS = {"first": "cam", "second": "left", "third": "right", "fourth": "both", "fifth": "odd"}
"""Each worker with a stage of it that gets every message."""


class Run(Journaled):
    """A live run of five workers of this machine."""

    def __init__(self, folder: Path, edges: str, size: int = 0) -> None:
        super().__init__(f"accounts-{uuid.uuid4().hex[:8]}", folder / "journals", folder / "out", WORKERS)
        self.folder.mkdir()
        graph = write_graph(folder, LIVE, self.name)
        placement = folder / "placement.yaml"
        placement.write_text(PLACEMENT)
        words = ("--plugin", str(STAGES), "--placement", str(placement), "--edges", edges)
        os.environ["JOURNALS"] = str(self.folder)
        self.process = start(graph, self.out, *words, "--set", f"cam.size={size}")


def befall(run: Run, chance: random.Random, faults: int) -> None:
    """Faults one after the other, some of them while the last one is not over yet."""
    kinds: list[Callable[[str], None]] = [run.kill, run.kill, run.hang, run.suspend]
    for _ in range(faults):
        kind, worker = chance.choice(kinds), chance.choice(list(WORKERS))
        misbehaving = chance.choice([("slow", "left"), ("slow", "odd"), ("full", "save"), ("slow", "right")])
        with run.asked(*misbehaving):
            kind(worker)
            if chance.random() < 0.3:
                run.kill(chance.choice(list(WORKERS)))
        if chance.random() < 0.7:
            run.goes_on()


def look(run: Run) -> None:
    """What died is not said to be on its way: an edge holds its queues and what a source has made."""
    edges = run.status()
    assert not list(impossible(edges))
    assert all(edge["in_flight"] <= 25 + 3 * len(run.killed) for edge in edges), edges


@pytest.mark.parametrize("edges", ["ring", pytest.param("zenoh", marks=pytest.mark.thorough)])
def test_journals_agree_with_the_ledger_after_faults_at_random(tmp_path: Path, edges: str) -> None:
    with Run(tmp_path, edges, size=6000) as run:
        run.goes_on()
        befall(run, random.Random(1), 3)
        look(run)
        run.judge(run.end())


@pytest.mark.thorough
@pytest.mark.parametrize("edges", ["ring", "zenoh"])
@pytest.mark.parametrize("seed", range(100, 112))
def test_journals_agree_with_the_ledger_after_many_faults(tmp_path: Path, edges: str, seed: int) -> None:
    chance = random.Random(seed)
    with Run(tmp_path, edges, size=chance.choice([0, 6000])) as run:
        run.goes_on()
        for _ in range(3):
            befall(run, chance, 3)
            look(run)
        run.judge(run.end(), with_dead=True)
