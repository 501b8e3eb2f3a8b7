"""A script that ends while its run goes on."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = """
import os, sys, threading
from pathlib import Path
import followspot as fs

class Note(fs.Message):
    value: int

class Endless(fs.Stage):
    def process(self) -> fs.Source[Note]:
        number = 0
        while True:
            yield fs.at(number * 10_000_000, Note(number))
            number += 1

begun = threading.Event()

class Keep(fs.Stage):
    count = 0

    def process(self, note: Note) -> None:
        self.count += 1
        begun.set()

    def close(self) -> None:
        (self.context.out / "closed.txt").write_text(str(self.count))

graph = fs.Graph("g")
graph.add("keep", Keep, note=graph.add("numbers", Endless))
run = fs.run(graph, out=Path(sys.argv[1]))
begun.wait()
"""


@pytest.mark.parametrize(
    ("end", "code"),
    [("", 0), ("raise ValueError('of a cell')", 1), ("import warnings; warnings.simplefilter('error')", 0)],
    ids=["end", "exception", "warnings are errors"],
)
def test_its_stages_are_closed_and_the_remedy_is_told(end: str, code: int, tmp_path: Path) -> None:
    words = [sys.executable, "-c", f"{SCRIPT}\n{end}", str(tmp_path)]
    done = subprocess.run(words, capture_output=True, text=True, timeout=120)
    assert done.returncode == code
    assert 'goes on at the end of the script, and is stopped: use it in a "with" block' in done.stderr
    assert int((tmp_path / "closed.txt").read_text()) > 0


def test_a_copy_of_the_process_ends_without_it(tmp_path: Path) -> None:
    """The thread of the run is not in it."""
    forked = "if os.fork() == 0: sys.exit(7)\nprint(os.waitstatus_to_exitcode(os.wait()[1]))\nrun.close()"
    words = [sys.executable, "-c", f"{SCRIPT}\n{forked}", str(tmp_path)]
    done = subprocess.run(words, capture_output=True, text=True, timeout=120)
    assert (done.stdout, done.returncode) == ("7\n", 0)
    assert "goes on at the end" not in done.stderr
