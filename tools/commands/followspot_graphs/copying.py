"""Copies graphs with the files they need, so that they can be changed."""

from __future__ import annotations

import shutil
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

from followspot.errors import InputError
from followspot_graphs.shipped import files_of, graph_file, graphs_folder


def copy_graphs(names: Iterable[str], to: Path) -> list[Path]:
    """Copy graphs and what they need into a folder; return the new files.

    Files that are there already and say the same are left alone. Raises InputError, and copies nothing, if a
    graph is unknown or a file there says something else; also if the folder cannot be written.
    """
    source = graphs_folder()
    wanted = {path: to / path.relative_to(source) for name in names for path in files_of(graph_file(name))}
    new = {path: target for path, target in wanted.items() if not target.exists()}
    for path, target in wanted.items():
        if path not in new and (not target.is_file() or target.read_bytes() != path.read_bytes()):
            raise InputError.of(f"{target} exists and says something else", "choose another folder with --to")
    for path, target in new.items():
        try:
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(path, target)
        except OSError as error:
            with suppress(OSError):
                target.unlink()  # half a copy would be taken for another file
            at = target if target.parent.is_dir() else error.filename
            text = f"{at} cannot be written: {error.strerror}"
            raise InputError.of(text, "choose another folder with --to") from None
    return list(new.values())
