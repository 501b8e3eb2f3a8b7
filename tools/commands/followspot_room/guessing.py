"""`followspot room guess`: a rough camera pose from the sizes of people in its video."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from followspot import Camera, Room
from followspot.errors import InputError, require_unused, writing
from followspot.messages import Array
from followspot.notes import progress_is_shown
from followspot.room import StageUse
from followspot.room_file import save
from followspot_cameras.video.file import announced_frames, open_video
from followspot_room.moving import moved

PICTURES = 20
"""So many pictures of the video, evenly spread, are searched for people."""
WORKING_HEIGHT = 1100
"""Pictures are searched at this height, px; OpenCV's detector finds people from about 100 px on."""
PERSON_OF_BOX, FOOT_OF_BOX = 0.75, 0.875
"""Shares of the height of the detector's box, which has margins: height of the person, row of the feet."""
SCORE = 0.6
"""Lowest score of a detection that counts."""
STILL = 0.08
"""Detections that agree within this share of their height are furniture or a standing person."""
FEWEST = 8
"""People that the guess needs."""
OPEN = 2.0
"""Ratio of two heights of the camera that fit nearly as well, from which on the people do not tell it."""
PITCHES = np.radians(np.arange(-5.0, 75.0, 0.25))
"""Candidate pitch angles, rad."""


@dataclass(frozen=True)
class Guess:
    """The guessed pose.

    pitch: downward, rad; height: above the floor, m; spread: median deviation of the heights from single
    people, m; people: how many counted.
    """

    pitch: float
    height: float
    spread: float
    people: int


def guess_room(video: Path, output: Path, field: float, person: float, *, as_json: bool) -> int:
    """Write the room file and say what was guessed; returns the exit code. Raises InputError.

    field: horizontal field of view, rad; person: usual height of people, m.
    """
    require_unused(output)
    if not video.is_file():
        raise InputError.of(f"there is no video {video}", "give a video in which people walk")
    size, found = people_in(video)
    focal = size[0] / 2 / np.tan(field / 2)
    guess = guess_pose(found, size, focal, person)
    with writing(output):
        output.parent.mkdir(parents=True, exist_ok=True)
        save(room_of(video, output, size, focal, guess), output)
    print(_as_json(output, guess) if as_json else _summary(output, guess))
    return 0


def people_in(video: Path) -> tuple[tuple[int, int], Array]:
    """Size of the pictures and the people found in them: (N, 3) column and row of the feet, height; px."""
    hog = cv2.HOGDescriptor()
    hog.setSVMDetector(np.array(cv2.HOGDescriptor.getDefaultPeopleDetector(), np.float32))
    found, size = [np.empty((0, 3))], (0, 0)
    for picture in _pictures(video):
        size = (picture.shape[1], picture.shape[0])
        scale = WORKING_HEIGHT / size[1]
        resized = cv2.resize(picture, None, fx=scale, fy=scale)
        box, score = hog.detectMultiScale(resized, winStride=(8, 8), scale=1.07)
        sure = np.array(box, float).reshape(-1, 4)[np.ravel(score) > SCORE] / scale
        feet = np.stack([sure[:, 0] + sure[:, 2] / 2, sure[:, 1] + FOOT_OF_BOX * sure[:, 3]], axis=1)
        found.append(np.column_stack([feet, PERSON_OF_BOX * sure[:, 3]]))
    return size, np.concatenate(found)


def _pictures(video: Path) -> Iterator[Array]:
    step = max(1, announced_frames(video) // PICTURES)
    capture = open_video(video)
    number = 0
    try:
        while capture.grab():
            if number % step == 0:
                picture = capture.retrieve()[1]
                if picture is not None:
                    yield picture
                if progress_is_shown():
                    print(f"\rlooking for people: frame {number}", end="", file=sys.stderr)
            number += 1
    finally:
        capture.release()
        if progress_is_shown():
            print(file=sys.stderr)


def without_still(people: Array) -> Array:
    """People at different places, (N, 3) as :func:`people_in`."""
    apart = np.abs(people[:, None] - people[None]).max(axis=2) / people[:, 2]
    np.fill_diagonal(apart, np.inf)
    return np.asarray(people[(apart > STILL).all(axis=1)])


def guess_pose(people: Array, size: tuple[int, int], focal: float, person: float) -> Guess:
    """The pitch at which people of one height agree best on the height of the camera.

    The feet of a person of height h are seen at an angle a below the horizon, the head at b, both at the
    distance H / tan(a) = (H - h) / tan(b) from a camera at height H, hence H = h tan(a) / (tan(a) - tan(b)).
    people: (N, 3) as :func:`people_in`; size, focal: px; person: h, m. Raises InputError for too few people,
    and for people whose sizes fit a low camera as well as a high one, as those at one distance do.
    """
    moving = without_still(people)
    if len(moving) < FEWEST:
        text = f"only {len(moving)} people were found at places of their own"
        raise InputError.of(text, f"give a video in which {FEWEST} and more people walk upright")
    tried = [
        Guess(pitch, *found, len(moving))
        for pitch in PITCHES.tolist()
        if (found := _height_at(pitch, moving, size, focal, person)) is not None
    ]
    if not tried:
        remedy = "give the camera's own --field, and a video that is not upside down"
        raise InputError.of("no camera above a floor sees people so high in the picture", remedy)
    best = min(tried, key=lambda guess: guess.spread / guess.height)
    limit = best.spread / best.height * (1 + 2 / np.sqrt(len(moving)))  # by chance another could be the best
    fitting = [guess.height for guess in tried if guess.spread <= limit * guess.height]
    if max(fitting) > OPEN * min(fitting):
        text = f"a camera {min(fitting):.1f} m above the floor fits these people as well as one at"
        remedy = "give a video in which people walk near the camera and far from it"
        raise InputError.of(f"{text} {max(fitting):.1f} m", remedy)
    return best


def _height_at(
    pitch: float, people: Array, size: tuple[int, int], focal: float, person: float
) -> tuple[float, float] | None:
    """Height of a camera with this pitch and the median deviation from it, m; None if few people fit."""
    feet = _below_horizon(people[:, :2], size, focal, pitch)
    head = _below_horizon(people[:, :2] - people[:, 2:] * [0.0, 1.0], size, focal, pitch)
    usable = (feet > 0) & (feet > head)
    if usable.mean() < 0.8:
        return None
    heights = person * feet[usable] / (feet - head)[usable]
    height = float(np.median(heights))
    return height, float(np.median(np.abs(heights - height)))


def _below_horizon(pixel: Array, size: tuple[int, int], focal: float, pitch: float) -> Array:
    """Tangent of the angle below the horizon at which pixels are seen, (N,)."""
    x, y = ((pixel - (np.array(size) - 1) / 2) / focal).T
    down = np.sin(pitch) + y * np.cos(pitch)
    return np.asarray(down / np.hypot(x, np.cos(pitch) - y * np.sin(pitch)))


def room_of(video: Path, output: Path, size: tuple[int, int], focal: float, guess: Guess) -> Room:
    """The room with its origin on the floor below the camera, which looks along x."""
    c, s = np.cos(guess.pitch), np.sin(guess.pitch)
    rotation = np.array([[0.0, -1.0, 0.0], [-s, 0.0, -c], [c, 0.0, -s]])
    matrix = np.array([[focal, 0, (size[0] - 1) / 2], [0, focal, (size[1] - 1) / 2], [0, 0, 1]])
    camera = Camera(
        name="camera",
        kind="color",
        size=size,
        matrix=matrix,
        distortion=np.zeros(5),
        rotation=rotation,
        translation=-rotation @ np.array([0.0, 0.0, guess.height]),
        source=StageUse("cameras.video", {"path": str(video)}),
    )
    floor = np.array([0.0, 0.0, 1.0, 0.0])
    return moved(Room(name=output.stem, cameras={"camera": camera}, planes={"floor": floor}), output)


def _summary(output: Path, guess: Guess) -> str:
    return (
        f"{output}: camera {guess.height:.2f} m above the floor (people differ by {guess.spread:.2f} m), "
        f"{np.degrees(guess.pitch):.1f} degrees down, after {guess.people} people\n"
        "a guess, not a calibration: places are off by tenths of their distance"
    )


def _as_json(output: Path, guess: Guess) -> str:
    found = {"height_m": guess.height, "spread_m": guess.spread, "pitch_deg": float(np.degrees(guess.pitch))}
    return json.dumps({"room": output.stem, **found, "people": guess.people})
