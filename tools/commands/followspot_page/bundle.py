"""The files that browsers take: bundled from `web/` of the repository, in wheels from the beginning."""

from __future__ import annotations

from pathlib import Path

from followspot.errors import InputError

STATIC = Path(__file__).parent / "static"
MISSING = "the page is not bundled in this checkout yet: make bundle does it"


def is_bundled(static: Path = STATIC) -> bool:
    """True if the page's files are there."""
    return (static / "index.html").exists()


def check_bundle(static: Path = STATIC) -> None:
    """Raises InputError if the page's files are not there."""
    if not is_bundled(static):
        raise InputError.of(MISSING)
