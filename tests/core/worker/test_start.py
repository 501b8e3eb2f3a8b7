"""A worker starts, and starts again after a fault, as soon as what every stage needs is imported."""

from __future__ import annotations

import subprocess
import sys

NEEDLESS = ("asyncio", "cryptography", "cv2", "mcap", "packaging", "pluggy", "zenoh")


def test_a_worker_imports_nothing_that_only_some_stages_or_edges_need() -> None:
    program = (
        "import sys, followspot.worker.main; from followspot.plugins.registry import catalogue; catalogue();"
        f"print([name for name in {NEEDLESS!r} if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"
