"""Fixtures of the tests of recordings that `followspot verify` repeats."""

from pathlib import Path

import pytest
from tests.tools.flight.bars import written


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One for all tests, for a process loads a stage from one file."""
    return written(tmp_path_factory.mktemp("bars"))
