"""Rooms whose file stands in another folder than their sources."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

from followspot.room import Room, StageUse


def moved(room: Room, output: Path) -> Room:
    """The room with the paths of its sources relative to the folder of the file that is to be written."""
    folder = output.parent.resolve()

    def use(given: StageUse | None) -> StageUse | None:
        if given is None or not isinstance(given.params.get("path"), str):
            return given
        path = os.path.relpath((Path(given.folder) / given.params["path"]).resolve(), folder)
        return replace(given, params={**given.params, "path": path}, folder=str(folder))

    cameras = {name: replace(camera, source=use(camera.source)) for name, camera in room.cameras.items()}
    return replace(room, cameras=cameras, truth=use(room.truth))
