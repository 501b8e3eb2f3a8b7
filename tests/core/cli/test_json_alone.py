"""Standard output of `--json` is one JSON object, whatever stages print."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from tests.commands import command

STAGES = '''
import os
from collections.abc import Iterator
from followspot import Message, Stage, at

print("loaded")

class Note(Message):
    number: int

class Loud(Stage):
    """Prints in every way."""

    def process(self) -> Iterator[Note]:
        """Three notes."""
        for number in range(3):
            print("by print")
            os.write(1, b"by descriptor\\n")
            os.system("echo by child")
            yield at(number * 1000, Note(number=number))

class End(Stage):
    """Takes the notes."""

    def process(self, note: Note) -> None:
        """Print one."""
        print("at the end")
'''
GRAPH = "graph: g\nstages: {a: {uses: loud.loud}, b: {uses: loud.end, in: {note: a}}}\n"


@pytest.mark.parametrize("placement", [(), ("--placement", "stage")])
def test_what_stages_print_goes_to_standard_error(tmp_path: Path, placement: tuple[str, ...]) -> None:
    (tmp_path / "loud.py").write_text(STAGES)
    (tmp_path / "g.yaml").write_text(GRAPH)
    words = ("run", "g.yaml", "--plugin", "loud.py", "--out", "out", "--quiet", *placement)
    done = command(*words, "--json", cwd=tmp_path)
    assert json.loads(done.stdout)["ok"], done.stderr
    for said in ("loaded", "by print", "by descriptor", "by child", "at the end"):
        assert said in done.stderr
    loud = command(*words, cwd=tmp_path)
    assert "by print" in loud.stdout
    assert "by descriptor" in loud.stdout
