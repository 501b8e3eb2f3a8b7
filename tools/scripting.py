"""What the maintainers' scripts share: their options, and commands of followspot that they run."""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from pathlib import Path
from typing import Any


def options_of(description: str | None) -> argparse.ArgumentParser:
    """A parser with --json, whose help is the docstring of a script."""
    parser = argparse.ArgumentParser(
        description=description, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    return parser


def followspot(*words: str | Path) -> dict[str, Any]:
    """The JSON object that a command prints with --json, whatever its exit code; exits if there is none."""
    command = [sys.executable, "-m", "followspot.cli.main", *words, "--quiet", "--json"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if not done.stdout:
        raise SystemExit(done.stderr)
    told: dict[str, Any] = json.loads(done.stdout)
    return told
