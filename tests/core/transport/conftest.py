"""Rings and Zenoh edges with both ends in the process of the test."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from tests.core.transport.rings import Ring
from tests.core.transport.zenoh_pair import Pair


@pytest.fixture
def ring() -> Iterator[Ring]:
    with Ring() as made:
        yield made


@pytest.fixture
def shared() -> Iterator[Ring]:
    """One writer, three readers."""
    with Ring(3) as made:
        yield made


@pytest.fixture
def pair() -> Iterator[Pair]:
    made = Pair()
    yield made
    made.close()
