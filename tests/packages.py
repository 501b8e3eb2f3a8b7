"""Wheels and source distributions of a checkout."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path


def build(what: str, source: Path, out: Path) -> Path:
    """Build a wheel or an sdist with hatchling; the file."""
    command = [sys.executable, "-m", "hatchling", "build", "-t", what, "-d", str(out)]
    subprocess.run(command, cwd=source, check=True, capture_output=True, timeout=300)
    (made,) = out.iterdir()
    return made
