"""What a disk refuses is told in a line that names the file, whichever command meets it."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest
from tests.commands import COMMAND, command

GRAPH = Path(__file__).parents[3] / "graphs/glowballs.yaml"


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("graph", GRAPH, "--svg", "/proc/none/plan.svg"), "/proc/none/plan.svg"),
        (("new", "plugin", "mine", "--dir", "/proc"), "/proc/followspot-mine"),
    ],
)
def test_what_cannot_be_written_is_named_without_a_traceback(words: tuple[object, ...], told: str) -> None:
    done = command(*words)
    assert done.returncode == 1
    assert done.stderr.startswith(f"followspot: {told}")
    assert "Traceback" not in done.stderr


def test_a_full_disk_behind_the_output_is_told() -> None:
    with Path("/dev/full").open("w") as full:
        done = subprocess.run([*COMMAND, "plugins"], stdout=full, stderr=subprocess.PIPE, text=True)
    assert done.returncode == 1
    assert "No space left on device" in done.stderr
    assert "Traceback" not in done.stderr


def test_a_reader_that_has_gone_ends_a_command_quietly() -> None:
    read, write = os.pipe()
    os.close(read)
    with os.fdopen(write, "w") as gone:
        done = subprocess.run([*COMMAND, "plugins"], stdout=gone, stderr=subprocess.PIPE, text=True)
    assert done.returncode in (1, 120), "120 is Python's own"
    assert "Traceback" not in done.stderr
