"""Well-formed graphs, rooms and placements that say extreme things; `python tools/fuzz.py` tries 10,000."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

TOOLS = Path(__file__).parents[2] / "tools"
KINDS = ("graph_values", "room_values", "placement_values")


@pytest.mark.thorough  # test_fuzz.py tries a few of these
def test_no_extreme_value_is_a_traceback_slow_or_takes_much_memory() -> None:
    words = [
        sys.executable,
        str(TOOLS / "fuzz.py"),
        "--only",
        *KINDS,
        "--share",
        "0.02",
        "--seed",
        "5",
        "--json",
    ]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    found = json.loads(done.stdout)
    assert {name: outcome["crashes"] for name, outcome in found.items() if outcome["crashes"]} == {}
    assert done.returncode == 0
    assert sum(outcome["inputs"] for outcome in found.values()) == 200
    assert all(outcome["accepted"] and len(outcome["refused"]) > 10 for outcome in found.values())
    assert all(outcome["whole_mb"] < 300 for outcome in found.values())
