"""Tries a model in a process of its own: a damaged TensorFlow Lite file can make OpenCV crash."""

from __future__ import annotations

import os
import signal
import subprocess
from pathlib import Path

from followspot.operating_system.child_processes import module_command
from followspot_persons.pose_net.contract import Decoder

_TIMEOUT = 60.0
"""Longest time, s, that a model may take to load and to look at a black image."""
_TRIAL = "followspot_persons.pose_net.trial"
_FILLED = {"MALLOC_PERTURB_": "165"}
"""Fills uninitialised memory, so that code that reads it crashes each time and not by chance."""


def try_apart(path: Path, decoder: type[Decoder]) -> None:
    """Load a model and use it once, in another process.

    Raises ValueError if that process crashes, or does not end.
    """
    words = module_command(_TRIAL, str(path.absolute()), decoder.__module__, decoder.__qualname__)
    environment = {**os.environ, **_FILLED}
    try:
        done = subprocess.run(
            words, stdin=subprocess.DEVNULL, capture_output=True, timeout=_TIMEOUT, env=environment
        )
    except subprocess.TimeoutExpired:
        raise ValueError(f"it is not done with a black image after {_TIMEOUT:.0f} s") from None
    if done.returncode < 0:
        name = signal.Signals(-done.returncode).name
        raise ValueError(f"the file is damaged: the process that loads it ends by {name}")
