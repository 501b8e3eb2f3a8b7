"""Tests import what they share by its path: ``from tests.integration.hosts import Hosts``."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
