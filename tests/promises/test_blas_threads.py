"""A run in a script gives the bits of the command, however many threads the script's linear algebra has."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

KINDS = """
from followspot import Message, Source, Stage, at
from threadpoolctl import threadpool_info

class Tick(Message):
    value: int = 0

class Ticks(Stage):
    def process(self) -> Source[Tick]:
        for number in range(3):
            yield at(number * 10_000_000, Tick(number))

class Threads(Stage):
    def process(self, tick: Tick) -> None:
        pools = [pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas"]
        print("stage", *pools, flush=True)
"""
RUN = """
import numpy
from threadpoolctl import threadpool_info
import followspot as fs

def threads():
    return [pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas"]

before = threads()
with fs.run("graph.yaml", plugin_files=["kinds.py"], placement=PLACEMENT, out="out") as run:
    run.wait()
assert run.report.ok
print("script", *before)
assert threads() == before, "the script has its threads again"
"""
GRAPH = """\
graph: graph
stages:
  ticks: {uses: kinds.ticks}
  look:  {uses: kinds.threads, in: {tick: ticks}}
"""


@pytest.mark.parametrize("placement", [None, "stage"])
def test_stages_have_one_thread_of_linear_algebra(tmp_path: Path, placement: str | None) -> None:
    (tmp_path / "kinds.py").write_text(KINDS)
    (tmp_path / "graph.yaml").write_text(GRAPH)
    (tmp_path / "script.py").write_text(RUN.replace("PLACEMENT", repr(placement)))
    said = subprocess.run(
        [sys.executable, "script.py"],
        cwd=tmp_path,
        env=os.environ | {"OPENBLAS_NUM_THREADS": "2"},
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert said.returncode == 0, said.stderr
    lines = [line.split() for line in said.stdout.splitlines()]
    seen = [set(numbers) for name, *numbers in lines if name == "stage"]
    assert seen == [{"1"}] * 3
    assert {"2"} in [set(numbers) for name, *numbers in lines if name == "script"]
