"""Tests import what they share by its path: ``from tests.integration.hosts import Hosts``."""

import gc
import os
import sys
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # called stages give the bits of workers

import hypothesis
import pytest

sys.path.insert(0, str(Path(__file__).parents[1]))
hypothesis.settings.register_profile("any machine", deadline=None)
hypothesis.settings.load_profile("any machine")
gc.set_threshold(20_000, 20, 20)  # tests make little garbage: to look for it took 8 % of a run


def pytest_collection_finish() -> None:
    gc.freeze()


def pytest_runtest_teardown(item: pytest.Item, nextitem: pytest.Item | None) -> None:
    if nextitem is None or item.path != nextitem.path:
        gc.collect()  # cycles may hold pictures
