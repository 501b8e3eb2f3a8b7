"""The output folder of a run: what hinders a run from taking it is told with a remedy."""

from __future__ import annotations

import resource
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from followspot.errors import FollowspotError
from followspot.operator.output_folder import reserved_folder


@contextmanager
def no_more_open_files() -> Iterator[None]:
    """Let this process open no file while the block runs."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (0, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


def test_a_folder_that_cannot_be_opened_is_told_with_the_remedy_of_the_limit(tmp_path: Path) -> None:
    with pytest.raises(FollowspotError) as told, no_more_open_files(), reserved_folder(tmp_path / "out"):
        pass
    assert f"the output folder {tmp_path / 'out'}" in str(told.value)
    assert "ulimit -n" in str(told.value)
