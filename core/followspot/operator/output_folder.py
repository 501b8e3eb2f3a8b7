"""The output folder of a run, which one run at a time writes to."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from followspot.errors import FollowspotError
from followspot.graph.parameters import output_paths
from followspot.graph.plan import Plan
from followspot.operating_system.limits import limit_remedy
from followspot.plugins.registry import load_stage


@contextmanager
def reserved_folder(folder: Path) -> Iterator[None]:
    """Make a folder and keep other runs out of it while the block runs.

    The lock ends with the process, however that ends. On a file system without locks no run is kept out. The
    present folder is not reserved: it is that of runs without outputs. Raises FollowspotError if a run writes
    there or the folder cannot be made.
    """
    if folder == Path():
        yield
        return
    with _refused(existing_folder(folder), "open"):
        descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    try:
        with suppress(OSError):
            _lock(descriptor, folder)
        yield
    finally:
        os.close(descriptor)


def existing_folder(folder: Path) -> Path:
    """The folder, which exists now. Raises FollowspotError."""
    with _refused(folder, "make"):
        folder.mkdir(parents=True, exist_ok=True)
    return folder


@contextmanager
def _refused(folder: Path, what: str) -> Iterator[None]:
    """Raise FollowspotError with a remedy if the system refuses an operation on a folder in this block."""
    try:
        yield
    except OSError as error:
        remedy = limit_remedy(error, "choose one with --out")
        raise FollowspotError(
            f"cannot {what} the output folder {folder}: {error.strerror}; {remedy}"
        ) from None


def replaced_outputs(plan: Plan, folder: Path) -> list[str]:
    """The outputs of an earlier run in the folder that a run of this plan replaces on this host."""
    here = [stage for stage in plan.stages if not plan.host_of_stage(stage.name)]
    paths = (path for stage in here for path in output_paths(load_stage(stage.uses).Params, stage.params))
    return [path for path in dict.fromkeys(paths) if (folder / path).is_file()]


def _lock(descriptor: int, folder: Path) -> None:
    """Raises FollowspotError if another run has the lock, OSError if the disk has none."""
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        text = f"another run writes to {folder}: two would mix their files\n    choose another with --out"
        raise FollowspotError(text) from None
