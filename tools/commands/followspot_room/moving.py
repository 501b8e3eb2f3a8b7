"""Rooms whose file stands in another folder than their sources."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

from followspot.room import Room, StageUse

PATHS = ("path", "times")
"""Parameters of sources that name files."""


def moved(room: Room, output: Path) -> Room:
    """The room with the paths of its sources relative to the folder of the file that is to be written."""
    folder = output.parent.resolve()

    def use(given: StageUse | None) -> StageUse | None:
        if given is None:
            return given
        paths = {name: path for name in PATHS if isinstance(path := given.params.get(name), str)}
        moved_paths = {
            name: os.path.relpath((Path(given.folder) / path).resolve(), folder)
            for name, path in paths.items()
        }
        return replace(given, params={**given.params, **moved_paths}, folder=str(folder)) if paths else given

    cameras = {name: replace(camera, source=use(camera.source)) for name, camera in room.cameras.items()}
    return replace(room, cameras=cameras, truth=use(room.truth))
