"""Views of the board in all recordings at the same moments."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from followspot import Camera
from followspot.errors import InputError, Mistake
from followspot_calibrate.boards.board import Board
from followspot_calibrate.boards.detection import Detector, View
from followspot_calibrate.boards.pictures import count, pictures
from followspot_calibrate.progress import show_progress


def find_views(
    cameras: Sequence[Camera],
    paths: Mapping[str, Path],
    board: Board,
    moments: Mapping[str, Mapping[int, int]] | None,
    most: int,
) -> dict[str, list[View]]:
    """Camera -> views of the board at the same moments, at most this many. Raises InputError."""
    when = moments or {name: {k: k for k in range(count(path))} for name, path in paths.items()}
    everything = sorted({moment for of_camera in when.values() for moment in of_camera.values()})
    chosen = set(everything[:: max(1, -(-len(everything) // most))])
    views: dict[str, list[View]] = {}
    for camera in cameras:
        wanted = {picture: moment for picture, moment in when[camera.name].items() if moment in chosen}
        views[camera.name] = []
        detector = Detector(board, camera)
        for done, (picture, gray) in enumerate(pictures(paths[camera.name], wanted), 1):
            if gray.shape[::-1] != camera.size:
                raise InputError([_other_size(camera, gray.shape[::-1])])
            view = detector.find(gray, wanted[picture])
            if view is not None:
                views[camera.name].append(view)
            show_progress(f"{camera.name}, {len(views[camera.name])} views", done / len(wanted))
    return views


def _other_size(camera: Camera, found: tuple[int, ...]) -> Mistake:
    text = f"camera {camera.name} is calibrated for {camera.size[0]}x{camera.size[1]} px, its recording is "
    return Mistake(None, f"{text}{found[0]}x{found[1]}", "calibrate intrinsics at this size first")
