"""Recordings that tests need and the repository does not contain; `make data` says how to get each."""

from __future__ import annotations

from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
FOLDERS = (ROOT / "data", ROOT.parent / "shared" / "data")
"""Where a data set may lie: where `make data` puts it, or beside the checkout."""


def dataset(name: str) -> Path:
    """The folder of a data set, whether it is there or not."""
    return next((folder / name for folder in FOLDERS if (folder / name).is_dir()), FOLDERS[0] / name)


def needs_data(*names: str) -> pytest.MarkDecorator:
    """A mark that skips a test, and names the data sets that are missing."""
    missing = [name for name in names if not dataset(name).is_dir()]
    return pytest.mark.skipif(bool(missing), reason=f"needs {', '.join(missing)}: see `make data`")
