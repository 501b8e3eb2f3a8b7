"""A hash of all inputs of a sweep besides its parameters: it changes if one of them changes."""

from __future__ import annotations

import hashlib
import inspect
import json
from collections.abc import Iterator, Sequence
from importlib.metadata import version
from itertools import chain
from pathlib import Path
from typing import Any

from followspot.graph.plan import Plan
from followspot.graph.plan_data import plan_to_data
from followspot.plugins.registry import load_stage

_LONGEST = 500
"""Longest text that may be the name of a file."""


def fingerprint_of(plans: Sequence[Plan]) -> str:
    """A hash of graph and room as the first plan has them, of the followspot version, and of when files were
    changed that any of the plans names or whose stages it uses: plugins, videos, models, truth.
    """
    data = [plan_to_data(plan) for plan in plans]
    modules = {file for plan in plans for stage in plan.stages if (file := _module_of(stage.uses))}
    files = sorted({*chain.from_iterable(map(_named_files, data)), *modules})
    whole = json.dumps([version("followspot"), data[0], list(map(_change_of, files))])
    return hashlib.sha256(whole.encode()).hexdigest()


def _module_of(uses: str) -> Path | None:
    """The file that a stage is written in."""
    try:
        file = inspect.getsourcefile(load_stage(uses))
    except (TypeError, OSError):  # it has no source
        return None
    return None if file is None else Path(file)


def _named_files(data: Any) -> Iterator[Path]:
    """The files that texts of a plan name, absolutely or below a folder that it names."""
    texts = [Path(text) for text in set(_texts(data)) if 0 < len(text) <= _LONGEST and "\0" not in text]
    folders = [Path("/"), *(path for path in texts if path.is_absolute() and path.is_dir())]
    for path in texts:
        yield from (file for folder in folders if (file := folder / path).is_file())


def _texts(data: Any) -> Iterator[str]:
    """All texts of JSON data but its keys."""
    if isinstance(data, str):
        yield data
    elif isinstance(data, dict):
        yield from chain.from_iterable(map(_texts, data.values()))
    elif isinstance(data, (list, tuple)):
        yield from chain.from_iterable(map(_texts, data))


def _change_of(file: Path) -> tuple[str, int, int]:
    """Name, size and time of the last change of a file; zeros if it has gone meanwhile."""
    try:
        about = file.stat()
    except OSError:
        return str(file), 0, 0
    return str(file), about.st_size, about.st_mtime_ns
