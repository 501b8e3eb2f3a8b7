"""The recordings of cameras: one video, or one folder of pictures, named like the camera."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from followspot.errors import InputError, Mistake

SUFFIXES = frozenset({".avi", ".m4v", ".mjpeg", ".mjpg", ".mkv", ".mov", ".mp4", ".mpg", ".ts", ".webm"})

POSE_TRUTH = "_gt.csv"
"""Follows the camera's name in files with the true poses of the persons that it sees."""


def find_recordings(folder: Path, cameras: Iterable[str]) -> dict[str, Path]:
    """Camera -> video file or folder of pictures; cameras without one are left out.

    Raises InputError if the folder is none, or a camera has several videos.
    """
    if not folder.is_dir():
        raise InputError([Mistake(None, f"{folder} is not a folder")])
    entries = sorted(folder.iterdir())
    videos = [p for p in entries if p.suffix.lower() in SUFFIXES and p.is_file()]
    found, mistakes = {}, []
    for camera in cameras:
        pictures = [p for p in entries if p.name == camera and p.is_dir()]
        matches = [p for p in videos if p.stem == camera] or pictures
        if len(matches) > 1:
            names = ", ".join(p.name for p in matches)
            mistakes.append(Mistake(None, f"camera {camera} has several videos: {names}", "keep one of them"))
        elif matches:
            found[camera] = matches[0]
    if mistakes:
        raise InputError(mistakes)
    return found
