"""Standard output of `--json` is one JSON object, whatever stages print."""

from __future__ import annotations

import json
import shlex
import subprocess
from pathlib import Path

import pytest
from tests.commands import COMMAND, command

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


RESULTS = (
    ("graph", "g.yaml", "--flat"),
    ("graph", "g.yaml", "--mermaid"),
    ("check", "g.yaml"),
    ("plugins", "--json"),
    ("plugins", "loud.loud"),
)


@pytest.mark.parametrize("words", RESULTS, ids=" ".join)
def test_what_modules_print_on_import_is_in_no_result(tmp_path: Path, words: tuple[str, ...]) -> None:
    (tmp_path / "loud.py").write_text(STAGES)
    (tmp_path / "g.yaml").write_text(GRAPH)
    done = command(*words, "--plugin", "loud.py", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "loaded" in done.stderr.splitlines()
    assert "loaded" not in done.stdout.splitlines()
    assert done.stdout


def test_a_command_works_without_standard_output(tmp_path: Path) -> None:
    """As a service may be started."""
    (tmp_path / "loud.py").write_text(STAGES)
    (tmp_path / "g.yaml").write_text(GRAPH)
    check = shlex.join([*COMMAND, "check", "g.yaml", "--plugin", "loud.py"])
    done = subprocess.run(["sh", "-c", f"{check} >&-"], cwd=tmp_path, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "loaded\n")


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
