"""Descriptors of too many other edges on their way: that is backpressure, and no end of a reader."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path


def test_too_many_descriptors_on_their_way_delay_an_edge_and_are_told_once() -> None:
    words = [sys.executable, "-m", "tests.core.transport.descriptor_flood"]
    done = subprocess.run(
        words, capture_output=True, text=True, timeout=60, check=False, cwd=Path(__file__).parents[3]
    )
    assert done.returncode == 0, done.stderr
    arrived = json.loads(done.stdout)
    assert arrived["ring"] == [0, 1]
    assert arrived["channel"] == [1]
    (line,) = arrived["logged"]
    assert "ulimit -n" in line
