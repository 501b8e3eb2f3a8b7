"""`python -m followspot_persons.pose_net.trial FILE MODULE DECODER`: loads a model and uses it once.

What is raised is raised again where the model is loaded for use; a crash ends this process alone.
"""

from __future__ import annotations

import importlib
import sys
from contextlib import suppress
from operator import attrgetter
from pathlib import Path

from followspot_persons.pose_net.loading import loaded


def main(path: str, module: str, decoder: str) -> None:
    """Load the model and use it."""
    with suppress(Exception):
        loaded(Path(path), attrgetter(decoder)(importlib.import_module(module)))


if __name__ == "__main__":
    main(*sys.argv[1:])
