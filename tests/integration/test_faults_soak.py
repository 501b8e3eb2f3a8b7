"""A short soak; `python tools/soak.py` inflicts two hundred faults."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from tests.integration.hosts import namespaces_are_permitted

SOAK = Path(__file__).parents[2] / "tools" / "soak.py"
KINDS = ["clock steps", "disk full", "worker killed"]
pytestmark = pytest.mark.skipif(
    not namespaces_are_permitted(), reason="this user may not make network namespaces"
)


@pytest.mark.thorough
def test_a_run_survives_random_faults_and_accounts_for_every_message() -> None:
    """The tracker recovers after each fault; other tests measure how fast."""
    words = ["--faults", str(len(KINDS)), "--within", "50", "--notice", "50", "--json", "--only", *KINDS]
    done = subprocess.run([sys.executable, str(SOAK), *words], capture_output=True, text=True, check=False)
    assert done.stdout, done.stderr
    found: dict[str, Any] = json.loads(done.stdout)
    assert done.returncode == 0, found
    assert set(found["kinds"]) == set(KINDS)
    assert not found["unaccounted"]
    assert not found["left_over"]
    assert sum(edge["sent"] for edge in found["edges"]) > 100
