"""Helpers of the maintainers' scripts: options, tables, and commands of followspot that they run."""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from followspot.tables.terminal import table


def options_of(description: str | None) -> argparse.ArgumentParser:
    """A parser with --json, whose help is the docstring of a script."""
    parser = argparse.ArgumentParser(
        description=description, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    return parser


def table_options(description: str | None) -> argparse.ArgumentParser:
    """The same for a script whose tables stand on the pages about speed: with --markdown, see `shown`."""
    parser = options_of(description)
    parser.add_argument("--markdown", action="store_true", help="print the tables as those pages have them")
    return parser


def shown(args: argparse.Namespace, head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table as the command line wants it: plain text, or Markdown."""
    return markdown(head, rows) if args.markdown else table(head, rows)


def markdown(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table in Markdown; empty if there are no rows."""
    lines = ["| " + " | ".join(row) + " |" for row in (head, ["---"] * len(head), *rows)]
    return "\n".join(lines) if rows else ""


def followspot(*words: str | Path) -> dict[str, Any]:
    """The JSON object that a command prints with --json, whatever its exit code; exits if there is none."""
    command = [sys.executable, "-m", "followspot.cli.main", *words, "--quiet", "--json"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if not done.stdout:
        raise SystemExit(done.stderr)
    told: dict[str, Any] = json.loads(done.stdout)
    return told
